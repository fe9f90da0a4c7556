"""Fabric files: what a scene takes from them, what it says itself, and what is refused."""

import tomllib

import pytest
from program import DEMOS

from ncf_fenicsx import Scene, SceneError
from ncf_fenicsx.scene.fabric_file import SHIPPED, list_fabrics, read_fabric

pytestmark = pytest.mark.serial
FABRIC = """
[stack]
areal_density = "1 kg/m^2"
[laws.compaction]
kind = "power"
exponent = 12.0
[laws.relaxation]
branches = [{share = 0.1, time = "2 s"}]
[interface.friction]
coefficient = 0.3
"""


def scene(folder, text, changes=(), fabric=FABRIC):
    (folder / "mine.toml").write_text(fabric, "utf-8")
    (folder / "scene.toml").write_text('fabric = "mine.toml"\nduration = "1 s"\n' + text, "utf-8")
    return Scene.read(folder / "scene.toml", changes)


def test_a_scene_takes_the_laws_and_is_complete_without_the_file(tmp_path):
    made = scene(tmp_path, "")
    assert (made.laws.compaction.kind, made.laws.compaction.exponent) == ("power", 12.0)
    assert made.stack.areal_density == 1.0
    assert made.interface[0].friction.coefficient == 0.3
    assert Scene.from_table(tomllib.loads(made.to_toml())) == made


def test_what_the_scene_says_itself_stays(tmp_path):
    made = scene(tmp_path, "[laws.compaction]\nexponent = 9.0\n[stack]\nareal_density = '2 kg/m^2'")
    assert (made.laws.compaction.kind, made.laws.compaction.exponent) == ("power", 9.0)
    assert made.stack.areal_density == 2.0
    assert scene(tmp_path, "[laws.compaction]\nkind = 'gutowski'").laws.compaction.limit == 0.8
    assert scene(tmp_path, "[interface]\nkind = 'bonded'").interface[0].kind == "bonded"


def test_the_command_line_has_the_last_word(tmp_path):
    made = scene(tmp_path, "", ["laws.compaction.exponent=8.0", "laws.relaxation.branches.0.share=0.4"])
    assert made.laws.compaction.exponent == 8.0
    assert made.laws.relaxation.branches[0].share == 0.4
    assert scene(tmp_path, "", ["fabric=broberg_2024"]).laws.shear.kind == "table"


@pytest.mark.parametrize(
    ("fabric", "name", "words"),
    [
        ("[tool]\nkind='plate'", "mine.toml", "mine.toml: tool: unknown key of a fabric"),
        ("[stack]\nlayers = 3", "mine.toml", "stack.layers: not of a fabric"),
        ("laws = 3", "mine.toml", "laws = 3: expected a table"),
        ("", "nowhere.toml", "fabric = 'nowhere.toml': no such file beside the scene, nor one of broberg_2024"),
        ("[laws.compaction]\nscale = 1", "mine.toml", "laws.compaction.scale = 1"),
    ],
)
def test_what_no_fabric_has_is_one_line(tmp_path, fabric, name, words):
    with pytest.raises(SceneError) as caught:
        scene(tmp_path, "", [f"fabric={name}"], fabric)
    assert words in str(caught.value)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("path", sorted(SHIPPED.glob("*.toml")), ids=lambda path: path.stem)
def test_every_number_of_a_fabric_that_ships_has_its_source(path):
    table = read_fabric(path)
    made = Scene.read(DEMOS / "roller.toml", [f"fabric={path.stem}"])
    assert made
    given = {name for top in ("stack", "laws") for name in ([top] if top == "stack" else table["laws"]) if top in table}
    assert {key.removeprefix("laws.") for key in table["sources"]} == given
    assert path.stem in list_fabrics()


def test_the_papers_fabric_is_that_of_the_defaults():
    paper = Scene.read(DEMOS / "roller.toml", ["fabric=saertex_paper"])
    assert paper.laws == Scene.read(DEMOS / "roller.toml").laws
