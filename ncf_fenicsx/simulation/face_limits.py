"""Shapes of faces that the program cannot follow, or follows badly: overhangs, folds that touch, elements too long."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator

import numpy as np
from numpy.typing import NDArray

from ncf_fenicsx.mechanics.problem import Problem
from ncf_fenicsx.mesh.hexahedra import point_in_words
from ncf_fenicsx.output.face_lines import Place, crossing, line_families, sharpest, steepest
from ncf_fenicsx.output.face_waves import FaceWaves
from ncf_fenicsx.scene.interfaces import OneSided
from ncf_fenicsx.simulation.progress_bar import ProgressBar

Floats = NDArray[np.float64]

GRAPH = math.radians(85)
"""Largest angle of a face between layers that may part: the weights of its nodes are areas in plan."""
TURN = math.radians(30)
"""Angle from one piece of a line to the next above which its curve is coarse: chords are 1 % short, turn^2 / 24."""
COARSE = "from one node to the next"
"""Words by which a caution of this kind is known again after a restart."""


class FaceLimits:
    """Judges the shapes of the faces of a problem in its trial state.

    Args:
        problem: what is judged.
        faces: its faces.
        progress: where a caution is said, once in a run.
    """

    def __init__(self, problem: Problem, faces: FaceWaves, progress: ProgressBar) -> None:
        self._problem, self._progress = problem, progress
        upper, interfaces = faces.upper, problem.scene.interfaces
        self._faces = [(f"the upper face of layer {number}", face) for number, face in enumerate(upper, 1)]
        self._parting = [isinstance(way, OneSided) for way in interfaces] + [False]
        if faces.lower is not None:
            self._faces.append(("the lower face of the stack", faces.lower))
            self._parting.append(False)

    def violation(self) -> str | None:
        """In words, which face has a shape that cannot be, and where; None if none has. Collective."""
        for (name, families), parting in zip(self._lines(), self._parting, strict=True):
            place = _worst(families, steepest)
            if parting and place is not None and place.angle > GRAPH:
                return (
                    f"{name} is turned by {math.degrees(place.angle):.0f} degrees at {point_in_words(place.position)}: "
                    "layers on each other are followed in plan, which ends before they overhang"
                )
            touching = next((found for lines in families if (found := crossing(*lines)) is not None), None)
            if touching is not None:
                return f"{name} folds and touches itself at {point_in_words(touching)}: such contact is not modelled"
        return None

    def watch(self, time: float) -> None:
        """Say which face has a curve that its elements are too long for, in a step that ends at a time (s)."""
        if any(COARSE in words for words in self._progress.cautions):
            return
        for name, families in self._lines():
            place = _worst(families, sharpest)
            if place is not None and place.angle > TURN:
                self._progress.caution(
                    f"{name} turns by {math.degrees(place.angle):.0f} degrees {COARSE} at "
                    f"{point_in_words(place.position)}, at {time:.6g} s: its curve asks for nodes "
                    f"{1e3 * place.length * TURN / place.angle:.3g} mm apart in place of {1e3 * place.length:.3g} mm"
                )
                return

    def _lines(self) -> Iterator[tuple[str, list[tuple[Floats, int]]]]:
        displacement = self._problem.displacement.x.array.reshape(-1, 3)
        for name, face in self._faces:
            yield name, line_families(face.undeformed[:, :2], face.current(displacement))


def _worst(families: list[tuple[Floats, int]], remarkable: Callable[[Floats, int], Place | None]) -> Place | None:
    found = [place for place in (remarkable(*lines) for lines in families) if place is not None]
    return max(found, key=lambda place: place.angle) if found else None
