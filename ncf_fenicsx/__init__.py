"""Implicit finite elements for the compaction and wrinkling of dry non-crimp fabric under rigid tools."""

from ncf_fenicsx import laws, tools
from ncf_fenicsx.errors import SceneError
from ncf_fenicsx.scene import Scene
from ncf_fenicsx.version import VERSION

__version__ = VERSION
__all__ = ["Scene", "SceneError", "laws", "run", "tools"]


def __getattr__(name: str) -> object:
    """Load ``run`` with DOLFINx behind it only when it is asked for: reading a scene needs neither."""
    if name == "run":
        from ncf_fenicsx.accuracy.sequence import run

        return run
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
