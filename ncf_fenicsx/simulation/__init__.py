"""A scene from start to end."""

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from ncf_fenicsx.simulation.run_scene import run
    from ncf_fenicsx.simulation.simulation import Simulation

__all__ = ["Simulation", "run"]


def __getattr__(name: str) -> object:
    """Load the program that runs only when it is asked for: to judge a scene needs no solver and no pictures."""
    if name not in __all__:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    from ncf_fenicsx.simulation import run_scene

    return getattr(run_scene, name)
