"""Pint without Dask: units are read all the same, and Dask is there for those who want it."""

import subprocess
import sys

import pytest

pytestmark = pytest.mark.serial


@pytest.mark.parametrize("before", ["", "import dask.array;"])
def test_units_do_not_load_dask_which_can_be_loaded_afterwards(before):
    program = (
        f"import sys; {before} from ncf_fenicsx.parameters.units import parse_quantity;"
        "print(parse_quantity('2 mm', 'm'), 'dask' in sys.modules);"
        "import dask.array; print(dask.array.ones(3).sum().compute())"
    )
    ended = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=False)
    assert ended.stdout.split() == ["0.002", str(bool(before)), "3.0"], ended.stderr
