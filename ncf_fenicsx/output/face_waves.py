"""Waves and crests of the upper face of each layer, and of the stack's lower face on a mould."""

from __future__ import annotations

from dataclasses import astuple
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ncf_fenicsx.mechanics.problem import Problem
from ncf_fenicsx.mesh import compat
from ncf_fenicsx.mesh.faces import SharedFace
from ncf_fenicsx.mesh.hexahedra import TAGS, lower_tag
from ncf_fenicsx.output.crests import highest_crest
from ncf_fenicsx.output.symmetry import WholeFace
from ncf_fenicsx.output.wrinkles import wrinkles

Floats = NDArray[np.float64]

LEAST = 0.01
"""Height of a crest over a layer's thickness below which there is none."""
WAVE_COLUMNS = {
    "wrinkle_amplitude": ("m", "half the difference of highest and lowest deflection of the face"),
    "wrinkle_wavelength": ("m", "twice the mean distance of zero crossings on the highest line; 0 without a wave"),
    "misalignment_max": (
        "rad",
        "largest angle between a deformed line of the face and its undeformed direction; above pi/2 it overhangs",
    ),
    "curvature_max": ("1/m", "largest curvature of a deformed line of the face"),
    "wrinkle_height": (
        "m",
        "height of the highest crest over the higher of the troughs on its two sides; 0 below 1 % of a layer",
    ),
    "wrinkle_lift": ("m", "how far that crest is over where it would lie undeformed on the mould, or on the plane"),
    "wrinkle_length": ("m", "distance between the two places beside it where the face lifts off"),
    "wrinkle_x": ("m", "where the crest is now; 0 without one"),
    "wrinkle_y": ("m", "the same along y"),
    "wrinkle_count": ("1", "crests on its line that have a tenth of its height or more"),
}


def numbered_by_layer(values: dict[str, float], layer: int) -> dict[str, float]:
    """Values with the names of columns of a layer (0 at the bottom), or of the interface above it."""
    return {f"{name}_{layer + 1}": value for name, value in values.items()}


def mould_columns(values: dict[str, float]) -> dict[str, float]:
    """Values with the names of columns of the mould."""
    return {f"mould_{name}": value for name, value in values.items()}


class LayerFace:
    """A face of a layer on every rank, with its mirror images.

    Args:
        problem: whose face.
        tag: of its facets.

    Attributes:
        shared: the face of the modelled part.
        whole: itself with its images.
        undeformed: positions of the nodes of the whole in m, shape (all nodes, 3).
    """

    def __init__(self, problem: Problem, tag: int) -> None:
        spaces, sides = problem.contacts.body.spaces, problem.scene.stack.sides
        self.shared = SharedFace(spaces, problem.stack.facets(tag))
        self.whole = WholeFace(self.shared.undeformed, self.shared.quads, sides)
        self.undeformed = self.whole.positions(self.shared.undeformed)
        plan = self.shared.undeformed[:, :2]
        self._model = np.array([plan.min(axis=0), plan.max(axis=0)])

    def gather(self, values: Floats) -> Floats:
        """Values at the nodes of the whole on every rank, from those at each rank's local nodes."""
        return self.shared.gather(values)[self.whole.source]

    def current(self, displacement: Floats) -> Floats:
        """Positions in m of the nodes of the whole, from a displacement (m) at this rank's local nodes."""
        return self.whole.positions(self.shared.undeformed + self.shared.gather(displacement))

    def waves(self, displacement: Floats, lift: Floats, least: float) -> dict[str, float]:
        """Values of `WAVE_COLUMNS`.

        Args:
            displacement: in m at this rank's local nodes, shape (nodes, 3).
            lift: how far each of them is over where it would lie undeformed on what carries the stack, in m.
            least: height in m below which there is no crest.
        """
        current = self.current(displacement)
        waves = wrinkles(self.undeformed[:, :2], current - self.undeformed)
        crest = highest_crest(self.undeformed[:, :2], current[:, :2], self.gather(lift), self._model, least)
        return dict(zip(WAVE_COLUMNS, [*astuple(waves), *astuple(crest)], strict=True))

    def wavelength(self, displacement: Floats) -> tuple[float, float]:
        """Amplitude and wavelength in m of a displacement at this rank's local nodes, shape (nodes, 3)."""
        waves = wrinkles(self.undeformed[:, :2], self.current(displacement) - self.undeformed)
        return waves.amplitude, waves.wavelength


class FaceWaves:
    """Evaluates the faces of a problem.

    Args:
        problem: what is measured.

    Attributes:
        upper: upper face of each layer, the lowest first.
        lower: lower face of the stack; None unless it lies on a mould.
    """

    def __init__(self, problem: Problem) -> None:
        self.problem = problem
        layers, mould = problem.scene.stack.layers, problem.contacts.mould
        tags = [lower_tag(layer) for layer in range(layers - 1)] + [TAGS["top"]]
        self.upper = [LayerFace(problem, tag) for tag in tags]
        self.lower = LayerFace(problem, TAGS["bottom"]) if mould is not None else None
        self._height = problem.contacts.body.spaces.scalars.tabulate_dof_coordinates()[:, 2] - problem.stack.bottom
        self._from_mould: Any = None
        if mould is not None:
            body = problem.contacts.body
            distance = mould.surface.with_constants(body.constants).signed_distance(body.position - mould.tip)
            self._from_mould = compat.compile_expression(distance, problem.stack.element.nodes)

    def observe(self) -> list[dict[str, float]]:
        """Values of `WAVE_COLUMNS` of each upper face in the trial state, and of the lower one, if any, as the last."""
        faces = [*self.upper, *([self.lower] if self.lower is not None else [])]
        displacement = self.problem.displacement.x.array.reshape(-1, 3)
        lift, least = self._lift(displacement), LEAST * self.problem.scales.length
        return [face.waves(displacement, lift, least) for face in faces]

    def _lift(self, displacement: Floats) -> Floats:
        """How far each local node is over where it would lie undeformed on the mould, or on the plane, in m."""
        if self._from_mould is None:
            return displacement[:, 2]
        mesh, nodes = self.problem.mesh, self.problem.space.dofmap.list
        distance = np.empty(len(displacement))
        distance[nodes] = self._from_mould.eval(mesh, np.arange(len(nodes), dtype=np.int32)).reshape(nodes.shape)
        return distance - self._height

    def wavelength(self, displacement: Floats) -> float:
        """Wavelength in m of the face between layers, or of a single one, that a displacement deflects most."""
        return max(face.wavelength(displacement) for face in self.upper[: max(1, len(self.upper) - 1)])[1]
