"""What the numbers and the speed depend on outside this project."""

from pathlib import Path

import dolfinx
import numpy as np
import pytest
import threadpoolctl
from petsc4py import PETSc


def test_dolfinx_is_the_supported_one_on_real_double_petsc_with_mumps():
    assert dolfinx.__version__.split(".")[:2] in (["0", "9"], ["0", "11"])
    assert np.dtype(PETSc.ScalarType) == np.float64
    assert PETSc.Sys.hasExternalPackage("mumps")


def test_the_loaded_blas_is_not_the_reference_one():
    """MUMPS is 6 to 8 times slower with the reference BLAS."""
    loaded = [pool for pool in threadpoolctl.threadpool_info() if pool["user_api"] == "blas"]
    assert loaded
    assert {pool["internal_api"] for pool in loaded} <= {"openblas", "mkl", "blis"}
    maps = Path("/proc/self/maps").read_text()
    assert "/blas/libblas.so" not in maps


@pytest.mark.serial
def test_one_blas_thread_unless_asked():
    assert all(pool["num_threads"] == 1 for pool in threadpoolctl.threadpool_info() if pool["user_api"] == "blas")
