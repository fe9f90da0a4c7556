"""Where the project's files stand, and the program as a user calls it."""

import importlib.util
import os
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).parents[1]
DEMOS = ROOT / "demos"
SMALL_STACK = ROOT / "tests" / "small_stack.msh"
"""Two layers with conforming nodes, written by gmsh."""
ENVIRONMENT = os.environ | {"PYTHONPATH": str(ROOT)}


def call(*arguments, ranks=1, folder=None, environment=None):
    """Run the program with these arguments, to its end; some variables of its environment replaced."""
    command = [sys.executable, "-m", "ncf_fenicsx", *map(str, arguments)]
    if ranks > 1:
        command = ["mpirun", "-n", str(ranks), *command]
    return subprocess.run(
        command, cwd=folder, env=ENVIRONMENT | (environment or {}), capture_output=True, text=True, check=False
    )


def script(path):
    """A script of the project, a demo's or a mesh's, as a module."""
    spec = importlib.util.spec_from_file_location(f"{path.stem}_of_a_test", path)
    module = importlib.util.module_from_spec(spec)
    sys.modules[spec.name] = module  # dataclasses look their module up
    spec.loader.exec_module(module)
    return module
