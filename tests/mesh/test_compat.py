"""Forms whose compilation was killed once are compiled by the next program, not waited for."""

import subprocess
import sys

import pytest
from program import ENVIRONMENT

PROGRAM = """
import dolfinx, ufl
from mpi4py import MPI
from ncf_fenicsx.mesh import compat
compat.WAITING, compat.JIT = 2, compat.JIT | {"timeout": 2}
mesh = dolfinx.mesh.create_unit_cube(MPI.COMM_WORLD, 2, 2, 2)
form = compat.compile_form(dolfinx.fem.Constant(mesh, 3.0) * ufl.dx(domain=mesh))
print(mesh.comm.allreduce(dolfinx.fem.assemble_scalar(form)))
"""


@pytest.mark.serial
@pytest.mark.parametrize("ranks", [1, 2])
def test_a_compilation_that_was_killed_is_done_again(tmp_path, ranks):
    environment = ENVIRONMENT | {"XDG_CACHE_HOME": str(tmp_path)}

    def run():
        command = ["mpirun", "-n", str(ranks), sys.executable, "-c", PROGRAM]
        return subprocess.run(command, env=environment, capture_output=True, text=True, check=False)

    assert float(run().stdout.split()[0]) == pytest.approx(3)
    (mark,) = (tmp_path / "fenics").glob("libffcx_forms_*.c")
    for file in (tmp_path / "fenics").iterdir():
        if file != mark:
            file.unlink()
    ended = run()
    assert ended.returncode == 0, ended.stderr
    assert float(ended.stdout.split()[0]) == pytest.approx(3)
