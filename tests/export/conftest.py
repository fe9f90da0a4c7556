"""A small run to be written for other programs: two layers with fibres at 30 degrees under a roller."""

import pytest

from ncf_fenicsx import Scene, run

SCENE = {
    "title": "Größe",
    "stack": {"layers": 2, "size": ["12 mm", "6 mm"], "divisions": [6, 2], "grading": [0.0, 0.0]},
    "laws": {
        "in_plane": {"kind": "fibre_families", "plies": [30.0], "modulus": "10 MPa", "modulus_compression": "10 MPa"}
    },
    "tool": {"width": "infinite", "path": [{"travel": ["0 mm", "0 mm", "-0.2 mm"], "speed": "1 mm/min"}]},
    "interface": {"kind": "stitched"},
    "solver": {"largest_step": "4 s"},
    "output": {"permeability": {}, "picture": False, "report": False},
}


@pytest.fixture(scope="session")
def results(tmp_path_factory):
    """Results folder of that run."""
    folder = tmp_path_factory.mktemp("export") / "run"
    run(Scene.from_table(SCENE), folder)
    return folder
