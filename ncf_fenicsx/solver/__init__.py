"""Newton's method on the compiled forms: the only room that knows PETSc."""

from ncf_fenicsx.solver.newton import Newton, petsc_version
from ncf_fenicsx.solver.residual import Residual
from ncf_fenicsx.solver.system import Outcome

__all__ = ["Newton", "Outcome", "Residual", "petsc_version"]
