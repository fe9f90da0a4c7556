"""Contents of mesh files that are no mesh: cut off, of another format, with numbers that cannot be; one line each."""

import re

import numpy as np
import pytest
from gmsh_files import GOOD, binary, line_of, text_22, text_41, write
from program import call

from ncf_fenicsx import SceneError
from ncf_fenicsx.mesh.stack_mesh import stack_of

pytestmark = pytest.mark.two_ranks

SCENE = """
duration = "1 s"
[stack]
layers = 2
mesh = "mesh.msh"
"""
TEXT = text_22(GOOD)
LATER = text_41(GOOD)
NAMES = {"bottom": "top", "top": "bottom"}
EXCHANGED = GOOD.regroup(lambda name, _: NAMES.get(name, name))
BYTES = {
    "empty": ("", "is empty; expected a gmsh file of format 4.1 or 2.2"),
    "blank": ("\n \n", "is empty; expected a gmsh file of format 4.1 or 2.2"),
    "rubbish": (bytes(range(256)) * 9, "does not begin with $MeshFormat; expected a gmsh file of format 4.1 or 2.2"),
    "another format": ("solid cube\nfacet normal 0 0 1\n", "does not begin with $MeshFormat"),
    "format 1": ("$NOD\n1\n1 0 0 0\n$ENDNOD\n", "format 1: save as 4.1 or 2.2"),
    "format 3": (text_22(GOOD, "3 0 8"), "format 3: save as 4.1 or 2.2"),
    "format 4.0": (text_41(GOOD, line="4.0 0 8"), "format 4.0: save as 4.1 or 2.2"),
    "format 5": (text_41(GOOD, line="5.2 0 8"), "format 5.2: save as 4.1 or 2.2"),
    "no format": (text_22(GOOD, "msh"), "$MeshFormat says 'msh'; expected three numbers such as '4.1 0 8'"),
    "called binary": (text_41(GOOD, line="4.1 1 8"), "have the order of bytes of another machine; expected text"),
    "cut in nodes": (
        TEXT[: TEXT.index("$Nodes") + 60],
        "section $Nodes has no end; expected $EndNodes: the file is cut",
    ),
    "cut before elements": (TEXT[: TEXT.index("$Elements")], "has no section $Elements; expected nodes and elements"),
    "cut in a head": (
        TEXT[: TEXT.index("$Elements") + 5],
        "b'$Elem' stands after section $Nodes; expected the next section",
    ),
    "only a format": ("$MeshFormat\n4.1 0 8\n$EndMeshFormat\n", "has no section $Nodes; expected nodes and elements"),
    "fewer nodes than announced": (
        TEXT.replace("$Nodes\n36", "$Nodes\n37"),
        "section $Nodes ends early; expected as many numbers as it announces",
    ),
    "more nodes than announced": (
        TEXT.replace("$Nodes\n36", "$Nodes\n35"),
        "section $Nodes holds more than it announces; expected its end",
    ),
    "more nodes than any file has": (
        TEXT.replace("$Nodes\n36", "$Nodes\n999999999999"),
        "section $Nodes ends early; expected as many numbers as it announces",
    ),
    "no number of nodes": (
        TEXT.replace("$Nodes\n36", "$Nodes\n" + "9" * 5000),
        "section $Nodes begins with",
    ),
    "fewer elements than announced": (
        re.sub(r"\$Elements\n\d+", "$Elements\n99", TEXT),
        "elements to come; expected as many as it announces",
    ),
    "more elements than announced": (
        re.sub(r"\$Elements\n\d+", "$Elements\n10", TEXT),
        "section $Elements holds more than it announces; expected its end",
    ),
    "words for coordinates": (
        TEXT.replace("0.006", "six", 1),
        "section $Nodes holds what is no number; expected numbers",
    ),
    "decimal commas": (TEXT.replace("0.006", "0,006"), "section $Nodes holds what is no number; expected numbers"),
    "half a node": (
        TEXT.replace("\n7 ", "\n6.5 ", 1),
        "section $Nodes holds 6.5; expected a whole number",
    ),
    "two sections of nodes": (
        TEXT + TEXT[TEXT.index("$Nodes") : TEXT.index("$Elements")],
        "has two sections $Nodes; expected one",
    ),
    "fewer names than announced": (
        TEXT.replace("$PhysicalNames\n11", "$PhysicalNames\n12"),
        "$PhysicalNames announces '12' names and holds 11; expected the same",
    ),
    "a name without quotes": (
        TEXT.replace('"top"', "top"),
        "$PhysicalNames says '2 5 top'; expected a line such as '2 1 \"bottom\"'",
    ),
    "an entity in two layers": (
        text_41(GOOD, [("layer_1", "layer_2")]),
        "the cell at (2, 1.5, 1) mm is in 'layer_1' and in 'layer_2'; expected it in one physical volume",
    ),
    "an entity in two groups": (
        text_41(GOOD, [("top", "sides")]),
        "the facet at (2, 1.5, 4) mm is in 'sides' and in 'top'; expected it in one physical surface",
    ),
    "an entity that is not there": (
        LATER.replace("2 4 3 6\n", "2 44 3 6\n"),
        "has elements of an entity 44 of dimension 2; expected those of section $Entities",
    ),
    "4.1 without entities": (
        LATER[: LATER.index("$Entities")] + LATER[LATER.index("$Nodes") :],
        "the cell at (2, 1.5, 1) mm is in no group with a name; expected physical volume layer_1 to layer_2",
    ),
    "4.1 with fewer nodes in all": (
        LATER.replace("$Nodes\n1 36", "$Nodes\n1 35"),
        "section $Nodes announces 35 nodes and holds 36; expected the same",
    ),
    "4.1 with a block too many": (LATER.replace("$Nodes\n1 36", "$Nodes\n2 36"), "section $Nodes ends early"),
    "4.1 with a negative block": (
        LATER.replace("3 1 0 36", "3 1 0 -36"),
        "section $Nodes announces -36 entries; expected none or more",
    ),
    "binary, cut off": (
        binary(LATER)[:-200],
        "section $Elements has no end; expected $EndElements: the file is cut off",
    ),
    "binary, some bytes less": (
        re.sub(rb"(?s).{8}\n\$EndNodes", b"\n$EndNodes", binary(LATER)),
        "section $Nodes ends early; expected as many numbers as it announces",
    ),
    "binary, some bytes more": (
        binary(TEXT).replace(b"$EndNodes", b"1234567$EndNodes"),
        "section $Nodes holds more than it announces; expected its end",
    ),
}


@pytest.mark.parametrize("name", BYTES)
def test_a_defect_of_the_file_is_one_line(name, folder):
    content, expected = BYTES[name]
    assert expected in line_of(write(folder, content))


ALL_WAYS = pytest.mark.parametrize(
    "content",
    [TEXT.encode(), LATER.encode(), binary(TEXT), binary(LATER)],
    ids=["2.2", "4.1", "binary 2.2", "binary 4.1"],
)


@ALL_WAYS
def test_a_file_cut_anywhere_is_one_line(content, folder):
    for cut in range(0, len(content) - 12, 97):
        line_of(write(folder, content[:cut]))


@ALL_WAYS
def test_a_file_with_bytes_replaced_is_read_or_one_line(content, folder):
    """Whatever stands in a file, it ends as a mesh or as a SceneError."""
    random = np.random.default_rng(7)
    refused = 0
    for _ in range(60):
        data = bytearray(content)
        for place in random.integers(len(data), size=3):
            data[place] = random.choice(np.frombuffer(b"0123456789-. $e\x00\xff\n", np.uint8))
        try:
            stack_of(write(folder, bytes(data)))
        except SceneError:
            refused += 1
    assert refused > 20


PROGRAM = {
    "a defect of the mesh": (text_22(EXCHANGED), "the facet of 'bottom' at (2, 1.5, 4) mm faces up; expected down"),
    "a format": (text_41(GOOD, line="4.0 0 8"), "mesh.msh: format 4.0: save as 4.1 or 2.2"),
    "a file cut off": (binary(LATER)[:700], "the file is cut off"),
}


@pytest.mark.serial
@pytest.mark.parametrize("name", PROGRAM)
def test_the_program_says_it_in_one_line_and_writes_nothing(name, folder):
    content, expected = PROGRAM[name]
    write(folder, content)
    (folder / "scene.toml").write_text(SCENE, encoding="utf-8")
    ended = call("run", "scene.toml", "--out", "out", folder=folder)
    assert ended.returncode == 2
    (line,) = ended.stderr.splitlines()
    assert expected in line
    assert not (folder / "out").exists()
