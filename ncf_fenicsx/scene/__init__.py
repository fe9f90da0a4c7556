"""The case as frozen data, validated when it is read."""

from ncf_fenicsx.scene.scene import Scene

__all__ = ["Scene"]
