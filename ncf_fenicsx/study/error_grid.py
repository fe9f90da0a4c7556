"""The variants of a scene whose error and cost a study weighs: one thing changed at a time, or all refined."""

from __future__ import annotations

import os
from collections.abc import Iterator
from dataclasses import dataclass

from ncf_fenicsx.errors import SceneError
from ncf_fenicsx.parameters.units import PenaltyStiffness
from ncf_fenicsx.scene import Scene
from ncf_fenicsx.scene.interfaces import OneSided
from ncf_fenicsx.tools.rigid_surface import RigidSurface
from ncf_fenicsx.workers.launch import folder_name

TOGETHER = "all refined together"
IN_PLANE = (0.25, 0.5, 1.0, 2.0, 4.0)
SQUARES = (0.5, 1.0, 2.0, 4.0)
THROUGH = (1, 2, 3, 4)
STEPS = (2, 4, 8, 16, 32, 64)
PENALTIES = (0.01, 0.1, 1.0, 10.0, 100.0)
TOLERANCES = ((1e-2, 1e-1), (1e-4, 1e-2), (1e-7, 1e-4), (1e-9, 1e-6))
ENFORCEMENTS = {
    "Nitsche, incomplete": "{kind = 'nitsche'}",
    "Nitsche, symmetric": "{kind = 'nitsche', variant = 'symmetric'}",
    "augmented Lagrangian": "{kind = 'augmented_lagrangian'}",
}
NEWTONS = {
    "plain tangent": "solver.tangent=plain",
    "critical point": "solver.line_search=critical_point",
    "error oriented": "solver.line_search=error_oriented",
    "kept factors": "solver.factors=kept",
}
TIME_SCALINGS = (30_000, 10_000)
ASKED = ("5 %", "2 %", "1 %")


@dataclass(frozen=True)
class Variant:
    """A scene with something changed.

    Attributes:
        method: what is changed.
        level: how far.
        overrides: ``key=value`` texts.
        command: ``run`` or ``explicit``.
        ranks: processes.
        by_levels: whether an accuracy is asked for, so that it is a sequence of runs.
    """

    method: str
    level: str
    overrides: tuple[str, ...]
    command: str = "run"
    ranks: int = 1
    by_levels: bool = False

    @property
    def name(self) -> str:
        """Of its folder."""
        return folder_name(f"{self.method} {self.level}")


class Variants:
    """Makes the variants of a scene.

    Args:
        scene: the case; its mesh is extruded, with one pair of divisions for all layers.
        along_y: whether to refine along y as well; not needed where nothing varies along it.
        levels: how often to refine all together by two, the scene itself counted.
        through: whether to refine through the layers as well; else their number of elements is part of the model.

    Raises:
        SceneError: the scene's mesh or interfaces cannot be varied.
    """

    def __init__(self, scene: Scene, along_y: bool, levels: int, through: bool) -> None:
        stack = scene.stack
        pairs = set(stack.divisions_by_layer)
        if stack.mesh is not None or len(pairs) > 1 or len(set(stack.elements_through)) > 1 or not scene.tool:
            raise SceneError("study error-time: expected a scene with a tool, and one extruded mesh for all layers")
        self.scene, self.along_y, self._levels = scene, along_y, levels
        (self._divisions,) = pairs
        self._through = stack.elements_through[0]
        self._has_through = through and scene.laws.bending is None  # bending apart is that of one element
        self._duration = scene.milestones[-1]

    def all(self) -> list[Variant]:
        """Every variant, those that the reference is made from first."""
        return [
            *self._together(),
            *self._meshes(),
            *self._times(),
            *self._contacts(),
            *self._solvers(),
            *self._asked(),
            *self._others(),
        ]

    def _mesh(self, factor: float) -> tuple[str, ...]:
        across = factor if self.along_y else 1.0
        x, y = (max(round(count * by), 1) for count, by in zip(self._divisions, (factor, across), strict=True))
        return (f"stack.divisions=[{x}, {y}]",)

    def _squares(self, factor: float) -> tuple[str, ...]:
        """As many elements along x as the scene has by a factor, all of them equal squares."""
        length, width = self.scene.stack.size
        x = max(round(self._divisions[0] * factor), 1)
        return f"stack.divisions=[{x}, {max(round(x * width / length), 1)}]", "stack.grading=[0, 0]"

    def _steps(self, count: float) -> tuple[str, ...]:
        size = self._duration / count
        return (
            f"solver.first_step={size!r} s",
            f"solver.largest_step={size!r} s",
            "solver.max_steps=100000",
            "solver.time_tolerance=1",
        )

    def _touching(self) -> Iterator[tuple[str, RigidSurface | OneSided]]:
        """Tools and interfaces that may open, with their keys."""
        for name, parts in (("tool", self.scene.tool), ("interface", self.scene.interface)):
            for number, part in enumerate(parts):
                if isinstance(part, RigidSurface | OneSided):
                    yield name if len(parts) == 1 else f"{name}.{number}", part

    def _penalties(self, factor: float) -> tuple[str, ...]:
        """All penalties by a factor."""
        return tuple(f"{key}.penalty={_scaled(part.penalty, factor)}" for key, part in self._touching())

    def _strip(self, factor: float) -> tuple[str, ...]:
        """Plane strain: one element along y between planes of symmetry, mirror images included as wide as the scene."""
        (length, width), sides = self.scene.stack.size, self.scene.stack.sides
        both = sides.model_copy(update={"y_min": "symmetry", "y_max": "symmetry"})
        x = max(round(self._divisions[0] * factor), 1)
        return (
            "stack.sides.y_min=symmetry",
            "stack.sides.y_max=symmetry",
            f"stack.size=['{length!r} m', '{width * sides.copies / both.copies!r} m']",
            f"stack.divisions=[{x}, 1]",
        )

    @property
    def _is_long(self) -> bool:
        """Whether nothing varies along y."""
        return all(getattr(tool, "width", 0.0) is None for tool in self.scene.tool) and self.scene.mould is None

    def _together(self) -> Iterator[Variant]:
        for level in range(self._levels):
            finer = 2**level
            mesh = self._strip(finer) if self._is_long else self._mesh(finer)
            through = (f"stack.through={self._through * finer}",) if self._has_through else ()
            yield Variant(TOGETHER, str(finer), mesh + through + self._steps(16 * finer) + self._penalties(4.0**level))

    def _meshes(self) -> Iterator[Variant]:
        for factor in IN_PLANE:
            yield Variant("mesh in the plane", f"{factor:g}", self._mesh(factor))
        for factor in IN_PLANE[:-1]:
            yield Variant("order 2", f"{factor:g}", (*self._mesh(factor), "stack.order=2"))
        for factor in SQUARES:
            yield Variant("even squares", f"{factor:g}", self._squares(factor))
        for through in THROUGH if self._has_through else ():
            yield Variant("elements through a layer", str(through), (f"stack.through={through}",))
        if self._is_long:
            for factor in IN_PLANE:
                yield Variant("plane strain", f"{factor:g}", self._strip(factor))
            for factor in IN_PLANE[:-1]:
                yield Variant("plane strain of order 2", f"{factor:g}", (*self._strip(factor), "stack.order=2"))
            for through in THROUGH[1:] if self._has_through else ():
                yield Variant("plane strain and through", str(through), (*self._strip(1.0), f"stack.through={through}"))

    def _times(self) -> Iterator[Variant]:
        for count in STEPS:
            yield Variant("even time steps", str(count), self._steps(count))

    def _contacts(self) -> Iterator[Variant]:
        for factor in PENALTIES:
            yield Variant("penalty", f"{factor:g}", self._penalties(factor))
        for name, text in ENFORCEMENTS.items():
            texts = tuple(f"{key}.contact={text}" for key, _ in self._touching())
            yield Variant("enforcement", name, texts)

    def _solvers(self) -> Iterator[Variant]:
        for force, increment in TOLERANCES:
            texts = (f"solver.force_tolerance={force!r}", f"solver.increment_tolerance={increment!r}")
            yield Variant("Newton's tolerance", f"{force:g}", texts)
        for name, text in NEWTONS.items():
            yield Variant("Newton's method", name, (text,))
        if any(isinstance(way, OneSided) for way in self.scene.interfaces):
            yield Variant("Newton's method", "factors of layers", ("solver.factors=layers",))

    def _asked(self) -> Iterator[Variant]:
        """The accuracy by name; through the layers as well where the reference is refined so."""
        meshes: dict[str, tuple[str, ...]] = {"accuracy asked": ()}
        if self._is_long:
            meshes["accuracy asked in plane strain"] = self._strip(1.0)
        through = ("stack.through=resolved",) if self._has_through else ()
        for method, mesh in meshes.items():
            for asked in ASKED:
                yield Variant(method, asked, (*mesh, *through, f"accuracy.tolerance='{asked}'"), by_levels=True)

    def _others(self) -> Iterator[Variant]:
        for ranks in range(1, (os.cpu_count() or 1) + 1):
            yield Variant("ranks", str(ranks), (), ranks=ranks)
        for scaling in TIME_SCALINGS:
            yield Variant("explicit", f"{scaling} x faster", (f"explicit.time_scaling={scaling}",), command="explicit")


def _scaled(penalty: PenaltyStiffness, factor: float) -> str:
    """A penalty times a factor, as a scene has it."""
    value = factor * penalty.value
    return repr(value) if penalty.is_factor else f"{value!r} Pa/m"
