"""Options of the mesh scripts are numbers, read like those of a scene, or refused in one line."""

import pytest
from program import ROOT, script


@pytest.fixture(scope="module")
def mesh_script():
    return script(ROOT / "meshes" / "stack.py")


@pytest.mark.serial
@pytest.mark.parametrize("option", ["--band=1_2", "--band=0,006", "--band=nan", "--thickness=-1", "--layers=4.0"])
def test_an_option_that_is_no_number_is_refused(mesh_script, option, capsys):
    with pytest.raises(SystemExit) as ended:
        mesh_script.options().parse_args(["stack.msh", option])
    assert ended.value.code == 2
    assert "expected a" in capsys.readouterr().err


@pytest.mark.serial
def test_numbers_are_read_as_they_stand(mesh_script):
    given = mesh_script.options().parse_args(["stack.msh", "--band=6e-3", "--layers=3"])
    assert (given.band, given.layers) == (0.006, 3)
