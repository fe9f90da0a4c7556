"""Which scene a level is: mesh, penalties and time steps of a scene refined together, from some levels below itself."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

from ncf_fenicsx.errors import SceneError
from ncf_fenicsx.laws.contact import STIFFEST_LAYERS, STIFFEST_RIGID, most_raised
from ncf_fenicsx.mesh.stack_mesh import focus_of
from ncf_fenicsx.parameters.units import PenaltyStiffness
from ncf_fenicsx.report.reading import read_fields, read_snapshots, varies_along_y
from ncf_fenicsx.scene import Scene
from ncf_fenicsx.scene.interfaces import OneSided
from ncf_fenicsx.scene.stack import Divisions
from ncf_fenicsx.tools.rigid_surface import RigidSurface

BELOW = 2
"""Halvings of the mesh and the steps that a scene names in level 0: three levels tell an order, the last is its own."""
STIFFER = 4
"""Factor on penalties from level to level: what they let through then goes away as that of a second-order mesh."""
COARSEST_TIME_ERROR = 0.1
"""Local error in time that a step of the coarsest level may have at most."""
SHOWS = 2
"""Elements along y that can show whether anything varies along it."""
FLAT = 1e-3
"""Difference of heights along y, over all heights, up to which nothing varies along it that could be seen."""
NEAR = 1.25
"""Factor that level 0's number of elements may differ by from the wanted one, so that all levels share their lines."""


@dataclass(frozen=True)
class Levels:
    """The levels of a scene.

    Args:
        scene: with an extruded stack.
        flat: whether a level has shown that nothing varies along y: finer ones then stay as they are along it.
        below: halvings of the mesh and the steps that the scene names in level 0.

    Raises:
        SceneError: the stack is read from a file, or its nodes are given, which cannot be refined.
    """

    scene: Scene
    flat: bool = False
    below: int = BELOW

    def __post_init__(self) -> None:
        if self.scene.stack.mesh is not None:
            words = "expected an extruded stack (stack.divisions), which can be refined"
            raise SceneError(f"stack.mesh = {self.scene.stack.mesh!r}: {words}")

        if self.scene.stack.is_automatic or self.scene.stack.nodes is not None:
            key = 'stack.divisions = "automatic"' if self.scene.stack.is_automatic else "stack.nodes"
            raise SceneError(f"{key}: expected numbers of elements in stack.divisions, which can be refined")

    def __getitem__(self, level: int) -> Scene:
        """The scene of a level, counted from 0."""
        scene, natural = self.coarsened(level), self.scene.natural_stiffness
        changed: dict[str, Any] = {
            "accuracy": None,
            "tool": tuple(_stiffer(tool, level, natural) for tool in scene.tool),
            "interface": tuple(
                _stiffer(way, level, natural) if isinstance(way, OneSided) else way for way in scene.interface
            ),
            "mould": None if scene.mould is None else _stiffer(scene.mould, level, natural),
        }
        return scene.model_copy(update=changed)

    def coarsened(self, level: int) -> Scene:
        """The scene with mesh and steps of a level, counted from 0, and penalties as they are."""
        scene, finer = self.scene, 2.0 ** (level - self.below)
        solver: dict[str, Any] = {
            "step_refinement": finer * scene.solver.step_refinement,
            "max_steps": max(scene.solver.max_steps, round(scene.solver.max_steps * finer)),
        }
        if scene.controls_time_error:
            loosest = max(scene.solver.time_tolerance, COARSEST_TIME_ERROR)
            solver["time_tolerance"] = min(scene.solver.time_tolerance / finer, loosest)
        mesh = scene.stack.model_copy(update=self._mesh(level))
        return scene.model_copy(update={"stack": mesh, "solver": scene.solver.model_copy(update=solver)})

    def _mesh(self, level: int) -> dict[str, Any]:
        divisions = tuple(self._divisions(pair, level) for pair in self.scene.stack.divisions_by_layer)
        return {"divisions": divisions[0] if len(set(divisions)) == 1 else divisions, "through": self._through(level)}

    def _through(self, level: int) -> Any:
        """Elements through the layers: a fabric's model, unless they are to be resolved; never a solid's."""
        if self.scene.stack.through == "resolved" or self.scene.laws.solid is not None:
            counts = tuple(_coarsest(count, 0.0, self.below) * 2**level for count in self.scene.stack.elements_through)
            return counts[0] if len(set(counts)) == 1 else counts
        return self.scene.stack.through

    def _divisions(self, pair: Divisions, level: int) -> Divisions:
        focus, size = focus_of(self.scene), self.scene.stack.size
        x, y = (_coarsest(count, focus[axis] / size[axis], self.below) for axis, count in enumerate(pair))
        if is_uniform_along_y(self.scene):
            return x * 2**level, 1
        if is_endless_along_y(self.scene) and self.below == BELOW:  # only a sequence learns from its level 0
            y = max(y, SHOWS)
        return x * 2**level, y if self.flat else y * 2**level

    def words(self, level: int) -> str:
        """What is refined in a level, in words."""
        scene = self.coarsened(level)
        meshes = " and ".join(f"{x} x {y}" for x, y in dict.fromkeys(scene.stack.divisions_by_layer))
        steps = self.scene.solver.step_refinement / scene.solver.step_refinement
        return f"{meshes} elements a layer, steps x {steps:g}"


def levels_of(scene: Scene, asks: str, below: int = BELOW) -> Levels:
    """The levels of a scene.

    Args:
        scene: the case.
        asks: key that asks for them.
        below: halvings of its mesh in level 0.

    Raises:
        SceneError: the scene's mesh cannot be refined; it names the key that asks for it.
    """
    try:
        return Levels(scene, below=below)
    except SceneError as error:
        raise SceneError(f"{asks}: {error}") from None


def is_endless_along_y(scene: Scene) -> bool:
    """Whether tools and mould are the same all along y."""
    return scene.mould is None and all(getattr(tool, "width", 0.0) is None for tool in scene.tool)


def is_uniform_along_y(scene: Scene) -> bool:
    """Whether nothing can vary along y, planes of symmetry at both ends included: one element is then exact."""
    sides = scene.stack.sides
    return is_endless_along_y(scene) and sides.y_min == sides.y_max == "symmetry"


def learn(scene: Scene, folder: Path) -> bool:
    """Whether results of the coarsest level show that nothing varies along y which finer ones have to follow.

    Args:
        scene: the case.
        folder: with the results.
    """
    if not is_endless_along_y(scene) or is_uniform_along_y(scene):
        return False
    mesh = read_fields(folder / read_snapshots(folder)[-1][1])
    return not varies_along_y(mesh, FLAT)


def _coarsest(count: int, focus: float, below: int) -> int:
    """Elements along an axis in level 0: near the wanted number, with a line at the focus, a share of the axis."""
    wanted = count / 2**below
    near = range(max(1, round(wanted / NEAR)), max(1, round(wanted * NEAR)) + 1)
    off = {n: abs(n * focus - round(n * focus)) if 0 < focus < 1 else 0.0 for n in near}
    return min(near, key=lambda n: (round(off[n], 6), abs(n - wanted)))


def _stiffer(part: Any, level: int, natural: float) -> Any:
    """A tool, a mould or an interface with the penalties of a level, and what contact and sticks else let through.

    Args:
        part: a rigid surface or an interface whose layers may part.
        level: counted from 0.
        natural: stiffness of a layer in Pa/m.
    """
    most = STIFFEST_RIGID if isinstance(part, RigidSurface) else STIFFEST_LAYERS
    raised = min(float(STIFFER**level), most_raised(most, part.penalty.resolve(natural), natural))
    changed: dict[str, Any] = {"penalty": _scaled(part.penalty, raised)}
    if part.contact.keeps_multiplier:
        tolerance = part.contact.tolerance / STIFFER**level
        changed["contact"] = part.contact.model_copy(update={"tolerance": tolerance})
    if part.friction is not None:
        stiffness = _scaled(part.friction.stiffness, 2.0**level)
        changed["friction"] = part.friction.model_copy(update={"stiffness": stiffness})
    return part.model_copy(update=changed)


def _scaled(penalty: PenaltyStiffness, factor: float) -> PenaltyStiffness:
    return PenaltyStiffness(factor * penalty.value, penalty.is_factor)
