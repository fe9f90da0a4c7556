"""Raw files as testing machines write them, made here: a press from 4 mm to 3 mm at 2 mm/min, 0 to 400 N."""

TIME = [0.0, 6.0, 12.0, 18.0, 24.0, 30.0]
TRAVEL = [0.0, 0.2, 0.4, 0.6, 0.8, 1.0]
FORCE = [0.0, 12.5, 40.0, 95.25, 200.0, 400.0]
LBF = 4.4482216152605


def rows(separator, comma=False, columns=(TIME, TRAVEL, FORCE), form="{:.6g}"):
    lines = [separator.join(form.format(value) for value in row) for row in zip(*columns, strict=True)]
    return "\n".join(lines).replace(".", ",") if comma else "\n".join(lines)


def blocks():
    first = "Test 1\nTime [s],Extension [mm],Load [N]\n" + rows(",")
    return first + "\n\n" + first.replace("Test 1", "Test 2") + "\n"


def side_by_side():
    both = (TIME, TRAVEL, FORCE) * 2
    return ";".join(["Time [s]", "Travel [mm]", "Force [N]"] * 2) + "\n" + rows(";", columns=both)


def numbered():
    body = "\n".join(f"{test};{line}" for test in (1, 2) for line in rows(";").splitlines())
    return "Specimen;Time [s];Displacement [mm];Force [N]\n" + body


def unloading():
    up = (TIME, TRAVEL, FORCE)
    down = ([30.0 + time for time in TIME[1:]], TRAVEL[-2::-1], [force / 2 for force in FORCE[-2::-1]])
    return "Time [s]\tCrosshead [mm]\tLoad [N]\n" + rows("\t", columns=up) + "\n" + rows("\t", columns=down) + "\n"


KN, LB = [force / 1e3 for force in FORCE], [force / LBF for force in FORCE]
STYLES = {
    "comma": ("Time [s],Displacement [mm],Force [N]\n" + rows(",")).encode(),
    "semicolon, decimal comma, german": ("Prüfzeit [s];Standardweg [mm];Standardkraft [N]\n" + rows(";", True)).encode(
        "cp1252"
    ),
    "french, row of units": ("Temps;Déplacement;Force\ns;mm;kN\n" + rows(";", True, (TIME, TRAVEL, KN))).encode(),
    "mark": b"\xef\xbb\xbf" + ("Time (s),Extension (mm),Load (N)\n" + rows(",")).encode(),
    "utf-16": ("Zeit [s]\tWeg [mm]\tKraft [N]\n" + rows("\t", True)).encode("utf-16"),
    "utf-16 without a mark": ("Zeit [s]\tWeg [mm]\tKraft [N]\n" + rows("\t", True)).encode("utf-16-le"),
    "pounds, minutes, quotes": (
        '"Time (min)","Crosshead (in)","Load (lbf)"\n'
        + rows(",", columns=([t / 60 for t in TIME], [t / 25.4 for t in TRAVEL], LB), form='"{:.12g}"')
    ).encode(),
    "preamble": (
        "Machine;Tinius Olsen 10ST\nLayers;2\nLength [mm];152\nWidth [mm];152\n\n"
        "Tiempo [s];Desplazamiento [mm];Fuerza [N]\n" + rows(";", True)
    ).encode(),
    "several tests below each other": blocks().encode(),
    "several tests side by side": side_by_side().encode(),
    "a column of tests": numbered().encode(),
    "unload branch": unloading().encode(),
    "other language, units tell": ("Aika [s];Puristimen [mm];Voima [N]\n" + rows(";", True)).encode(),
}

HEAD = "Time [s];Travel [mm];Force [N]\n"
MALFORMED = {
    "a word": (HEAD + "0;0;0\n1;0.1;broken\n2;0.2;4\n3;0.3;5", "line 3, column 'Force [N]' = 'broken'"),
    "thousands": (HEAD + "0;0;0\n1;0.1;1.234,5\n2;0.2;4\n3;0.3;5", "line 3, column 'Force [N]' = '1.234,5'"),
    "no unit": ("Time;Travel;Force\n0;0;0\n1;0.1;1\n2;0.2;4\n3;0.3;5", "line 1, column 'Time': no unit"),
    "wrong unit": ("Time [s];Travel [mm];Force [bananas]\n0;0;0\n1;0.1;1\n2;0.2;4", "line 1, column 'Force [bananas]'"),
    "no heading": ("0;0;0\n1;0.1;1\n2;0.2;4\n3;0.3;5", "no heading with two known columns"),
    "no separator": ("Time Force\n0 0\n1 1\n", "no tabs, semicolons or commas"),
    "too few rows": (HEAD + "0;0;0\n1;0.1;1\n", "2 rows of numbers in a test"),
    "space in a number": (HEAD + "0;0;0\n1;0.1;1 234\n2;0.2;4\n3;0.3;5", "line 3, column 'Force [N]' = '1 234'"),
    "text below": (HEAD + "0;0;0\n1;0.1;1\n2;0.2;4\nend;of;test\n3;0.3;5", "line 5 (end, of, test)"),
    "nothing below": (HEAD, "a heading without numbers"),
}
