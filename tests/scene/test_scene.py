"""Scenes: what is read, what is refused, in one line, with nothing written."""

import subprocess
import sys
import tomllib

import pytest
from program import DEMOS, ENVIRONMENT, ROOT, SMALL_STACK

from ncf_fenicsx import Scene, SceneError
from ncf_fenicsx.scene.keys import keys

pytestmark = pytest.mark.serial

ROLLER = DEMOS / "roller.toml"

WRONG = {
    "unknown key": (["stack.thicknes=2 mm"], "stack.thicknes = '2 mm': unknown key; did you mean 'thickness'?"),
    "former key": (["solver.steadying=none"], "solver.steadying = 'none': renamed; expected 'stabilisation'"),
    "another former key": (
        ["solver.travel_cap=0.1"],
        "solver.travel_cap = 0.1: renamed; expected 'sliding_increment_cap'",
    ),
    "unknown table": (["tol.radius=2 mm"], "did you mean 'tool'"),
    "wrong unit": (["tool.radius=2 kg"], "tool.radius = '2 kg': expected a positive length"),
    "no unit": (["tool.radius=2"], 'tool.radius = 2: expected a positive length with its unit, such as "2 mm"'),
    "negative thickness": (["stack.thickness=-2 mm"], "stack.thickness = '-2 mm': expected a positive length"),
    "roller inside the stack": (["tool.clearance=-1 mm"], "the tool starts in the stack"),
    "zero steps": (["solver.max_steps=0"], "solver.max_steps = 0: expected greater than 0"),
    "steps out of order": (["solver.first_step=2 s", "solver.largest_step=1 s"], "smallest_step <= first_step"),
    "push without a mode": (
        ["solver.perturbation=0.01 mm", "laws.in_plane.kind=as_printed"],
        "solver.perturbation = '0.01 mm': expected none, where a law or contact",
    ),
    "push without help": (
        ["solver.perturbation=0.01 mm", "solver.stabilisation=none"],
        "solver.stabilisation = 'none': expected \"automatic\" with solver.perturbation",
    ),
    "push of no size": (["solver.perturbation=0 mm"], "solver.perturbation = '0 mm': expected a positive length"),
    "trust region under force": (
        ["solver.line_search=trust_region", "tool.path=[{hold='1 s', force='1 N'}]"],
        "solver.line_search = 'trust_region': expected \"full\"",
    ),
    "zero divisions": (["stack.divisions=[0, 4]"], "stack.divisions.0 = 0"),
    "another word for divisions": (["stack.divisions=auto"], "'auto': expected two whole numbers, or \"automatic\""),
    "divisions and nodes": (
        ["stack.nodes=[['0 mm', '76 mm'], ['0 mm', '76 mm']]"],
        "stack: nodes give divisions, grading; expected only one of both",
    ),
    "unknown tool": (["tool.kind=rollr"], "tool.kind = 'rollr': no such tool"),
    "unknown law": (["laws.compaction.kind=magic"], "laws.compaction.kind = 'magic': no such compaction"),
    "reference speed zero": (["laws.rate.v_ref=0 mm/min"], "laws.rate.v_ref = '0 mm/min': expected a positive speed"),
    "negative modulus": (["laws.in_plane.modulus=-1 GPa"], "laws.in_plane.modulus = '-1 GPa': expected a positive"),
    "negative shear": (["laws.shear.modulus=-1 Pa"], "laws.shear.modulus = '-1 Pa': expected a positive stress"),
    "rate falls": (["laws.rate.sigma_inf=1 kPa"], "laws.rate.sigma_inf = 1000.0: expected more than sigma_0"),
    "toe": (["laws.compaction.toe=none"], "laws.compaction.toe = 'none': expected 'shift', 'clip' or 'raw'"),
    "table not ascending": (
        ["laws.compaction={kind='table', volume_fraction=[0.4, 0.5], stress=['2 kPa', '1 kPa']}"],
        "laws.compaction.stress = [2000.0, 1000.0]: expected ascending numbers",
    ),
    "table with a gap": (
        ["laws.compaction={kind='table', volume_fraction=[0.4, 0.5], stress=['2 kPa', '3 kPa', '4 kPa']}"],
        "laws.compaction.stress = [2000.0, 3000.0, 4000.0]: expected 2 entries",
    ),
    "locked from the start": (
        ["laws.compaction={kind='gutowski', limit=0.3}"],
        "laws.compaction.limit = 0.3: expected above Vf0 = 0.398",
    ),
    "no plies": (
        ["laws.in_plane={kind='fibre_families', plies=[]}"],
        "laws.in_plane.plies = []: expected angles in",
    ),
    "plies of words": (["laws.in_plane={kind='fibre_families', plies=[[0], ['x']]}"], "expected angles in degrees"),
    "a table of one row": (
        ["laws.compaction={kind='table', volume_fraction=[0.4], stress=['1 Pa', '2 Pa']}"],
        "laws.compaction.volume_fraction = [0.4]: expected at least 2 entries",
    ),
    "plies of two layers": (
        ["laws.in_plane={kind='fibre_families', plies=[[0], [90]]}"],
        "laws.in_plane.plies = ((0.0,), (90.0,)): expected a list for each of 4 layers",
    ),
    "stiffer in compression": (
        ["laws.in_plane={kind='fibre_families', modulus='1 GPa'}"],
        "laws.in_plane.modulus_compression = 24200000000.0: expected at most modulus = 1e+09 Pa",
    ),
    "bending through several elements": (
        ["laws.bending={}", "stack.through=2"],
        "stack.through = 2: expected 1 with laws.bending",
    ),
    "stiffer in bending": (["laws.bending.modulus=1 TPa"], "laws.bending.modulus = 1000000000000.0: expected at most"),
    "solid and fabric": (["laws.solid={}"], "laws.solid = 'logarithmic': expected no laws of the fabric beside it"),
    "incompressible": (
        ["laws={solid={poisson=0.5}}"],
        "laws.solid.poisson = 0.5: expected less than or equal to 0.4999",
    ),
    "no such measure": (
        ["laws.volume_fraction=mass"],
        "laws.volume_fraction = 'mass': expected 'thickness' or 'volume'",
    ),
    "fibres of no radius": (
        ["output.permeability.fibre_radius=0 um"],
        "output.permeability.fibre_radius = '0 um': expected a positive length",
    ),
    "permeable solid": (
        ["laws={solid={}}", "output.permeability={}"],
        "output.permeability.kind = 'gebart': expected none for a solid",
    ),
    "no Poisson's ratio": (
        ["laws.in_plane={kind='as_printed', poisson=0}"],
        "laws.in_plane.poisson = 0: expected greater",
    ),
    "kind that is no word": (["laws.in_plane.kind=[1]"], "laws.in_plane.kind = [1]: no such in_plane"),
    "kind that is a table": (["tool.kind={a=1}"], "tool.kind = {'a': 1}: no such tool"),
    "negative at rest": (
        ["laws.rate={exponent='as_printed', alpha1=10}"],
        "laws.rate.exponent = 'as_printed': expected a positive factor; it is",
    ),
    "beyond numbers": (
        ["laws.rate={feed='process', alpha2=1000}", "tool.path.0.speed=5 mm/min"],
        "it is nan at 5 mm/min",
    ),
    "steep beyond numbers": (
        ["laws.compaction.beta2=1000"],
        "laws.compaction = 'exponential': expected parameters whose",
    ),
    "falls with Vf": (["laws.compaction.beta1=0.5 Pa"], "laws.compaction = 'exponential': expected parameters whose"),
    "no pressure at all": (
        ["laws.compaction={kind='power', exponent=1e6}"],
        "laws.compaction = 'power': expected parameters whose",
    ),
    "overfull fabric": (
        ["stack.areal_density=4 kg/m^2"],
        "gives Vf0 = 1.117; expected less than fibre_density thickness",
    ),
    "through one layer only": (["stack.through=[1, 2]"], "through has 2 numbers; expected one for each of 4 layers"),
    "nothing holds it": (["stack.sides.x_min=free"], "nothing keeps the layers from sliding away"),
    "empty path": (["tool.path=[]"], "tool.path = []: expected at least one entry"),
    "table expected": (["laws=3"], "laws = 3: expected a table"),
    "list expected": (["stack.divisions=3"], "stack.divisions = 3: expected a list"),
    "whole number expected": (["stack.layers=x"], "stack.layers = 'x': expected a whole number"),
    "nothing to choose": (
        ["interface={kind='bonded', penalty=1}"],
        "interface.penalty = 1: unknown key; it takes none",
    ),
    "travel without speed": (["tool.path=[{travel=['0 mm','0 mm','-1 mm']}]"], "expected either travel"),
    "penalty zero": (["tool.penalty=0"], "tool.penalty = 0: expected a positive factor"),
    "mesh missing": (["stack.mesh=none.msh"], "the mesh file gives"),
    "set without value": (["stack.layers"], "expected KEY=VALUE"),
    "not a number": (["laws.compaction.beta2=many"], "laws.compaction.beta2 = 'many': expected a number"),
}


@pytest.mark.parametrize("case", WRONG)
def test_a_wrong_value_is_one_line_that_names_it(case):
    overrides, expected = WRONG[case]
    with pytest.raises(SceneError) as caught:
        Scene.read(ROLLER, overrides)
    assert expected in str(caught.value)
    assert "\n" not in str(caught.value)


NODES = {
    "out of order": ([["0 mm", "9 mm", "8 mm"], ["0 mm", "4 mm"]], "along x are not in ascending order"),
    "too short": ([["0 mm", "8 mm"], ["0 mm", "3 mm"]], "along y are at 0 to 3 mm; expected 0 to size = 4 mm"),
    "numbers": ([[0, 8], ["0 mm", "4 mm"]], "stack.nodes.0.0 = 0: expected a length with its unit"),
    "one list": ([["0 mm", "8 mm"]], "expected one more entry"),
    "one node": ([["0 mm"], ["0 mm", "4 mm"]], "stack.nodes.0 = ['0 mm']: expected at least 2 entries"),
}


@pytest.mark.parametrize("case", NODES)
def test_nodes_that_are_none_are_one_line(case):
    nodes, expected = NODES[case]
    with pytest.raises(SceneError) as caught:
        Scene.from_table({"tool": {}, "stack": {"size": ["8 mm", "4 mm"], "nodes": nodes}})
    assert expected in str(caught.value)
    assert "\n" not in str(caught.value)


def test_nodes_take_the_place_of_divisions_and_read_back():
    nodes = [["0 mm", "1 mm", "8 mm"], ["0 mm", "4 mm"]]
    scene = Scene.from_table({"tool": {}, "stack": {"size": ["8 mm", "4 mm"], "nodes": nodes}})
    assert scene.stack.divisions_by_layer == [(2, 1)] * 4
    assert not {"divisions", "grading", "focus", "mesh_error"} & set(scene.table()["stack"])
    assert Scene.from_table(tomllib.loads(scene.to_toml())) == scene


FILES = {
    "missing file": (None, "No such file"),
    "not TOML": ("stack = [", "not TOML"),
    "UTF-16": ("[tool]\n".encode("utf-16"), "case.toml: is UTF-16; save it as UTF-8"),
    "UTF-16 without a mark": ("[tool]\n".encode("utf-16-be"), "case.toml: is UTF-16; save it as UTF-8"),
    "UTF-32": ("[tool]\n".encode("utf-32"), "case.toml: is UTF-32; save it as UTF-8"),
    "Latin-1": ("[tool]\n# Stra\u00dfe".encode("latin-1"), "not UTF-8: line 2 has the byte 0xdf, '\u00df' in Latin-1"),
    "not text": (b"\xef\xbb\xbf[tool]\n\n\x81", "not UTF-8: line 3 has the byte 0x81"),
    "empty": ("", "[tool]"),
    "unknown key": ("[tool]\nradus = '2 mm'", "did you mean 'radius'"),
    "no such mesh": ("[tool]\n[stack]\nmesh = 'none.msh'", "none.msh"),
    "mesh that is none": ("[tool]\n[stack]\nmesh = 'case.toml'", "case.toml"),
    "layer missing": (f"[tool]\n[stack]\nlayers = 3\nmesh = '{SMALL_STACK}'", "layer_3"),
}


@pytest.mark.parametrize("case", FILES)
@pytest.mark.parametrize("command", ["run", "check"])
def test_a_wrong_scene_ends_with_code_2_and_writes_nothing(case, command, tmp_path):
    content, expected = FILES[case]
    if content is not None:
        (tmp_path / "case.toml").write_bytes(content if isinstance(content, bytes) else content.encode())
    before = sorted(tmp_path.iterdir())
    ended = subprocess.run(
        [sys.executable, "-m", "ncf_fenicsx", command, "case.toml"],
        cwd=tmp_path, env=ENVIRONMENT, capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert ended.returncode == 2
    assert ended.stdout == ""
    assert expected in ended.stderr
    assert ended.stderr.count("\n") == 1
    assert sorted(tmp_path.iterdir()) == before


@pytest.mark.parametrize("end", ["\n", "\r\n"])
def test_a_byte_order_mark_is_no_part_of_a_scene(tmp_path, end):
    """Editors on Windows write one."""
    (tmp_path / "marked.toml").write_bytes(f'title = "K\u00e4se"{end}[tool]{end}'.encode("utf-8-sig"))
    assert Scene.read(tmp_path / "marked.toml").title == "K\u00e4se"


def test_results_are_not_overwritten_unasked(tmp_path):
    (tmp_path / "kept").write_text("precious")
    command = [
        sys.executable,
        "-m",
        "ncf_fenicsx",
        "run",
        str(ROLLER),
        "--out",
        str(tmp_path),
        "--set",
        "stack.layers=1",
    ]
    ended = subprocess.run(command, env=ENVIRONMENT, capture_output=True, text=True, check=False)
    assert ended.returncode == 2
    assert "--overwrite" in ended.stderr
    assert [path.name for path in tmp_path.iterdir()] == ["kept"]


@pytest.mark.parametrize("name", ["roller", "long_roller", "single_element"])
def test_the_resolved_scene_reads_back_to_the_same(name):
    scene = Scene.read(DEMOS / f"{name}.toml")
    assert Scene.from_table(tomllib.loads(scene.to_toml())) == scene


@pytest.mark.parametrize(
    "table",
    [
        {"tool": {"width": "infinite", "penalty": "1e9 Pa/m"}},
        {"tool": {}, "interface": {"kind": "bonded"}},
        {"tool": {}, "laws": {"solid": {"kind": "split", "modulus": "2 MPa"}}, "stack": {"areal_density": "15 kg/m^2"}},
        {"tool": {}, "laws": {"in_plane": {"kind": "fibre_families", "plies": [[0], [45, -45], [90], [0]]}}},
        {"tool": {}, "laws": {"relaxation": {"branches": [{"time": "3 s"}, {"share": 0.5}]}, "unloading": {}}},
        {"tool": {}, "laws": {"compaction": {"kind": "table"}, "bending": {}, "volume_fraction": "volume"}},
        {"tool": {}, "output": {"permeability": {"kind": "kozeny_carman", "fibre_radius": "5 um"}}},
        {"duration": "2 s", "stack": {"layers": 2, "mesh": str(SMALL_STACK)}},
        {"tool": {"path": [{"hold": "1 s"}]}, "stack": {"through": [1, 2, 1, 3], "focus": ["1 mm", "2 mm"]}},
    ],
)
def test_resolved_variants_read_back_to_the_same(table):
    scene = Scene.from_table(table)
    assert Scene.from_table(tomllib.loads(scene.to_toml())).model_dump() == scene.model_dump()


def test_overrides_reach_into_tables_and_lists():
    scene = Scene.read(ROLLER, ["stack.layers=2", "tool.path.0.speed=5 mm/min", "interface.penalty=1e8 Pa/m"])
    assert scene.stack.layers == 2
    assert scene.segments[0].speed == pytest.approx(5e-3 / 60)
    assert scene.interface[0].penalty.resolve(1.0) == 1e8


def test_the_defaults_are_the_papers():
    scene = Scene.from_table({"tool": {}})
    assert scene.laws.in_plane.modulus == 242e9
    assert scene.stack.thickness * scene.stack.layers == pytest.approx(8e-3)
    assert scene.tool[0].radius == pytest.approx(2.5e-3)
    assert scene.segments[0].duration == pytest.approx(30)


def test_the_scene_in_the_readme_is_the_demo():
    block = (ROOT / "README.md").read_text().split("```toml\n")[1].split("```")[0]
    assert Scene.from_table(tomllib.loads(block)) == Scene.read(ROLLER)


def test_every_key_has_a_meaning():
    listed = list(keys())
    assert len(listed) > 50
    assert all(meaning for _, _, _, meaning in listed)
    units = {key: unit for key, unit, _, _ in listed}
    assert units["stack.thickness"] == "m"
    assert units["tool(cylinder).radius"] == "m"
