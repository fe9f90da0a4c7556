"""Memory that a run takes, from the numbers of its scene."""

from __future__ import annotations

from ncf_fenicsx.scene import Scene

MEMORY_OF_PROGRAM = 0.18
MEMORY_PER_UNKNOWN = {True: 7.4e-6, False: 9.6e-6}
"""GB, symmetric or not, measured with ``ncf-fenicsx run`` (peak_memory_mb of run.json): see docs/performance.md."""


def expected_memory(scene: Scene, unknowns: int) -> float:
    """Memory in GB that a run on one rank will take."""
    return MEMORY_OF_PROGRAM + MEMORY_PER_UNKNOWN[scene.symmetric] * unknowns
