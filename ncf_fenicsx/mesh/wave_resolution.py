"""Whether a mesh resolves the waves that a pressed stack may throw, before a run.

A layer of bending stiffness B per width and shear stiffness S = G_t h, pressed between others of stiffness k, first
gives way to waves of length 2 pi (B / k)^(1/4) sqrt(1 - sqrt(B k) / S), if S > sqrt(B k). Else nothing keeps a wave
from being shorter than another, and those that come are as short as the mesh lets them be.
"""

from __future__ import annotations

import math

import numpy as np

from ncf_fenicsx.mesh.hexahedra import FACES, TAGS, Hexahedra
from ncf_fenicsx.mesh.tool_placement import AXES, reached
from ncf_fenicsx.scene import Scene
from ncf_fenicsx.tools.rigid_surface import Tool

ELEMENTS_A_WAVE = 4 * math.pi
"""Elements that a wave needs: each (B / k)^(1/4) / 2 long."""


def wave_cautions(scene: Scene, stack: Hexahedra) -> list[str]:
    """What is doubtful about waves under and beside tools that are not plane, with the element that would do."""
    curved = [tool for tool in scene.tool if tool.kind != "plate"]
    if not curved or scene.laws.solid is not None:
        return []
    if scene.laws.bending is None:
        return [
            "laws.bending: not given: where layers lose stability, their waves are a few elements long, whatever the "
            "elements; with a bending stiffness they have a length of their own"
        ]
    wave = natural_wavelength(scene)
    if wave is None:
        return [
            f"laws.shear: layers pressed to Vf 0.60 give way to shear before they bend, in waves a few elements long; "
            f"expected more than {1e-6 * least_shear_modulus(scene):.3g} MPa for waves of a length of their own"
        ]
    needed = wave / ELEMENTS_A_WAVE
    longest = [max(_longest(tool, stack, axis) for tool in curved) for axis in range(2)]
    return [
        f"stack.divisions: waves of layers pressed to Vf 0.60 are {1e3 * wave:.3g} mm long and ask for elements of "
        f"{1e3 * needed:.2g} mm; under tools they are up to {1e3 * length:.2g} mm along {letter}"
        for letter, length in zip(AXES, longest, strict=True)
        if length > needed * (1 + 1e-9)
    ]


def natural_wavelength(scene: Scene) -> float | None:
    """Length in m of the waves to which layers pressed to Vf 0.60 first give way; None if they give way to shear."""
    bending, stiffness = _bending_stiffness(scene), scene.natural_stiffness
    left = 1 - math.sqrt(bending * stiffness) / (scene.laws.shear.small_strain_modulus * scene.stack.thickness)
    return 2 * math.pi * (bending / stiffness) ** 0.25 * math.sqrt(left) if left > 0 else None


def least_shear_modulus(scene: Scene) -> float:
    """Transverse shear modulus in Pa below which layers give way to shear."""
    return math.sqrt(_bending_stiffness(scene) * scene.natural_stiffness) / scene.stack.thickness


def _bending_stiffness(scene: Scene) -> float:
    assert scene.laws.bending is not None
    return scene.laws.bending.stiffness_per_width(scene.stack.thickness)


def _longest(tool: Tool, stack: Hexahedra, axis: int) -> float:
    """Longest element in m along an axis under a tool; 0 where one element is as long as the stack."""
    quads = stack.points[stack.cells[:, FACES].reshape(-1, 4)[(stack.face_tags == TAGS["top"]).ravel()]]
    lengths = np.ptp(quads[reached(tool, quads)][:, :, axis], axis=1)
    longest = float(lengths.max(initial=0.0))
    return longest if longest < np.ptp(stack.points[:, axis]) * (1 - 1e-9) else 0.0
