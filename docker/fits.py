"""Whether the present Python runs the package: silent if so; else one line on standard error, and exit code 1.

The package is imported, and each dependency has the version that ``pyproject.toml`` asks for: no list of its own.
Another argument is the DOLFINx that is wanted, as ``0.11``.
"""

import sys
from pathlib import Path

PROJECT = Path(__file__).resolve().parents[1] / "pyproject.toml"
UNTOLD = "0+unknown"
"""Version of a package that was built without one, as Debian's shapely for DOLFINx 0.11: that it imports has to do."""


def check() -> None:
    """Raise what speaks against the present Python; imports stand here, for each of them may fail."""
    import platform
    import tomllib
    from importlib.metadata import version

    import dolfinx
    import numpy as np
    from packaging.requirements import Requirement

    import ncf_fenicsx.cli
    import ncf_fenicsx.simulation.simulation  # noqa: F401

    project = tomllib.loads(PROJECT.read_text(encoding="utf-8"))["project"]
    found = {f"python {project['requires-python']}": platform.python_version()}
    found |= {dependency: version(Requirement(dependency).name) for dependency in project["dependencies"]}
    for version_of_dolfinx in sys.argv[1:]:
        found[f"fenics-dolfinx =={version_of_dolfinx}.*"] = version("fenics-dolfinx")
    for wanted, present in found.items():
        if present != UNTOLD and not Requirement(wanted).specifier.contains(present, prereleases=False):
            raise RuntimeError(f"{wanted} is needed, {present} is here")
    if dolfinx.default_scalar_type is not np.float64:
        raise RuntimeError("DOLFINx is here on complex PETSc; a real one is needed")


if __name__ == "__main__":
    try:
        check()
    except Exception as error:
        sys.exit(" ".join(str(error).split()))
