"""What a column of a testing machine's file holds: by its unit first, and by words of several languages."""

from __future__ import annotations

import re
import unicodedata
from dataclasses import dataclass

from ncf_fenicsx.parameters.units import parse_quantity

QUANTITIES = {
    "time": ("s", "time zeit temps tiempo tempo tijd tid"),
    "thickness": ("m", "thickness height gap dicke hohe epaisseur hauteur espesor altura spessore dikte"),
    "travel": (
        "m",
        "travel displacement extension crosshead stroke weg traverse verschiebung deplacement "
        "desplazamiento spostamento verplaatsing",
    ),
    "normal_force": ("N", "normal\\sforce normalkraft force\\snormale fuerza\\snormal forza\\snormale"),
    "force": ("N", "force load kraft last charge effort fuerza carga forza carico kracht"),
    "pressure": ("Pa", "pressure stress druck spannung pression contrainte presion pressione"),
    "speed": ("m/s", "speed velocity geschwindigkeit vitesse velocidad velocita snelheid"),
    "angle": ("degree", "angle winkel angulo angolo hoek"),
    "shear_stress": ("Pa", "shear\\sstress schubspannung cisaillement cortante taglio tau"),
    "deflection": ("m", "deflection sag durchbiegung fleche flecha freccia"),
    "position": ("m", "position abscissa abscisse abscisa ascissa"),
    "curvature": ("1/m", "curvature krummung courbure curvatura kromming"),
    "moment": ("N", "moment biegemoment"),
    "permeability_across": (
        "m^2",
        "permeab\\w*\\s(?:across|transvers|quer|through|perpendic) transvers\\w*\\spermeab quer\\w*permeab "
        "through.thickness\\spermeab out.of.plane\\spermeab k3 kz",
    ),
    "permeability": ("m^2", "permeab durchlassigkeit"),
    "volume_fraction": ("1", "volume\\sfraction vf fvf faservolumengehalt taux\\sde\\sfibres"),
    "test": ("", "test specimen sample probe eprouvette essai ensayo muestra provino proef"),
}
"""Each quantity with its SI unit and its words without accents, patterns of which one begins a word of the heading."""
ORDER = (
    *("normal_force", "shear_stress", "permeability_across", "permeability", "volume_fraction", "curvature", "moment"),
    *QUANTITIES,
)
BY_UNIT = {"s": "time", "m": "travel", "N": "force", "Pa": "pressure", "m/s": "speed", "degree": "angle"}
"""What a column in a unit is whose words are of another language."""
LEFT_OUT = ("temperature", "strain", "dehnung", "energy", "cycle", "number", "nr", "point")
HEADING = re.compile(r"^(?P<name>[^\[\](){}/]*?)\s*(?:[\[({]\s*(?P<unit>[^\])}]*)\s*[\])}]|/\s*(?P<bare>\S+))?\s*$")
MADE_OF = {"lbf": "lbf", "lb": "lbf", "kgf": "kgf", "kp": "kgf", "sec": "s", "sek": "s", "seg": "s", "deg": "degree"}
MADE_OF |= {"°": "degree", "%": "percent", "-": "", "psi": "psi", "kips": "kip"}
"""Units as machines write them, and as the program reads them."""


@dataclass(frozen=True)
class Column:
    """A column that is known.

    Attributes:
        number: its place in a row, from 0.
        heading: as it is written.
        quantity: name in `QUANTITIES`.
        factor: to SI.
    """

    number: int
    heading: str
    quantity: str
    factor: float


def plain(text: str) -> str:
    """Small letters without accents."""
    decomposed = unicodedata.normalize("NFKD", text.replace("ß", "ss"))
    return "".join(letter for letter in decomposed if not unicodedata.combining(letter)).lower().strip()


def parts(heading: str) -> tuple[str, str | None]:
    """Name and unit of a heading; None where it has no unit."""
    match = HEADING.match(heading.strip().strip('"'))
    if match is None:
        return heading, None
    return match["name"].strip(), match["unit"] if match["unit"] is not None else match["bare"]


def factor_of(unit: str, symbol: str) -> float | None:
    """Factor from a unit to the SI unit of a quantity; None if it is none of it."""
    written = MADE_OF.get(unit.strip().rstrip(".").strip(), unit.strip())
    if symbol in ("", "1"):
        return {"": 1.0, "1": 1.0, "percent": 0.01}.get(written)
    if symbol == "N" and written in ("N m/m", "Nm/m", "N·m/m"):
        return 1.0
    return parse_quantity(f"1 {written}", symbol)


def is_unit(text: str) -> bool:
    """Whether a cell is a unit of some quantity, or empty: what a row of units is made of."""
    bare = text.strip().strip("[](){}").strip()
    return bare == "" or any(factor_of(bare, symbol) is not None for symbol, _ in QUANTITIES.values() if symbol != "1")


def quantity_of(name: str, unit: str | None) -> str | None:
    """Which quantity a column is; None of one that is of no use here."""
    words = plain(name)
    if any(word in words for word in LEFT_OUT):
        return None
    named = [
        key
        for key in ORDER
        if any(re.search(rf"\b(?:pruf|standard)?{word}", words) for word in QUANTITIES[key][1].split())
    ]
    fits = [key for key in named if unit is not None and factor_of(unit, QUANTITIES[key][0]) is not None]
    if named:
        return (fits or named)[0]
    return (
        None
        if unit is None
        else next((key for symbol, key in BY_UNIT.items() if factor_of(unit, symbol) is not None), None)
    )
