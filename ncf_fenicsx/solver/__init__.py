"""Newton's method on the compiled forms: the only room that knows PETSc."""

from ncf_fenicsx.solver.assembly import Residual
from ncf_fenicsx.solver.compat import petsc_version
from ncf_fenicsx.solver.newton import Newton

__all__ = ["Newton", "Residual", "petsc_version"]
