"""The case as frozen, validated data: read from TOML, quantities converted to SI, errors in one line."""

from __future__ import annotations

import math
import tomllib
from collections.abc import Iterable
from itertools import pairwise
from pathlib import Path
from typing import Annotated, Any, Literal, Self

import tomli_w
from pydantic import PositiveInt, ValidationError, model_validator

from ncf_fenicsx import motion
from ncf_fenicsx.contracts import Mould, PermeabilityLaw, RigidSurface, Tool, real
from ncf_fenicsx.motion import Segment
from ncf_fenicsx.parts import Choice, Choices, Settings, impossible, parameter
from ncf_fenicsx.scene_errors import SceneError, one_line
from ncf_fenicsx.scene_laws import Laws
from ncf_fenicsx.scene_stack import GIVEN_BY_MESH, Bonded, OneSided, Stack
from ncf_fenicsx.units import Acceleration, PositiveLength, PositiveTime


class Solver(Settings):
    """Time steps and Newton's method."""

    first_step: PositiveTime | None = parameter(None, description="first time step; duration / 30 unless given")
    largest_step: PositiveTime | None = parameter(None, description="largest time step; duration / 8 unless given")
    smallest_step: PositiveTime | None = parameter(None, description="step at which a run stops; first_step / 1e4")
    max_steps: PositiveInt = parameter(1000, description="number of accepted steps at which a run stops")
    target_iterations: PositiveInt = parameter(6, description="Newton iterations that keep the step size as it is")
    max_iterations: PositiveInt = parameter(15, description="Newton iterations at which a step is cut")
    growth: float = parameter(1.5, ge=1, description="largest factor from one step to the next")
    cut: float = parameter(0.4, gt=0, lt=1, description="factor on a step that failed")
    tangent: Literal["extrapolated", "plain"] = parameter(
        "extrapolated", description="membrane stress in the tangent: extrapolated from the last iterate, or the current"
    )
    line_search: Literal["full", "critical_point", "error_oriented", "residual", "trust_region"] = parameter(
        "full",
        description="length of Newton's steps: whole; to where the residual is across the step (PETSc's cp); "
        "by the next simplified correction (nleqerr); by the residual's norm (bt); within a trust region (newtontr)",
    )
    factors: Literal["automatic", "kept", "new"] = parameter(
        "automatic",
        description="factors of the tangent: kept while GMRES converges fast with them, or new for each correction; "
        "kept from 50,000 unknowns on unless given",
    )
    force_tolerance: float = parameter(1e-7, gt=0, lt=1, description="residual over the support force at convergence")
    increment_tolerance: float = parameter(1e-4, gt=0, lt=1, description="next increment over the layer's thickness")
    increment_cap: float = parameter(0.3, gt=0, description="largest nodal increment over the layer's thickness")
    step_travel: float = parameter(
        0.5, gt=0, description="largest travel of a tool in a step over the layer's thickness"
    )
    travel_cap: float = parameter(0.02, gt=0, description="the same while a tool travels along the surface")

    steadying: Literal["automatic", "none"] = parameter(
        "automatic", description="whether steps that fail again and again are tried with a viscosity"
    )
    viscous_share: float = parameter(
        0.5, gt=0, description="energy of that viscosity over the work of the tools at which a run stops"
    )
    perturbation: PositiveLength | None = parameter(
        None, description="largest displacement of a push along the critical mode, where stability is lost first"
    )

    @property
    def may_steady(self) -> bool:
        """Whether a viscosity may come."""
        return self.steadying == "automatic"

    @model_validator(mode="after")
    def _steps_in_order(self) -> Self:
        given = [step for step in (self.smallest_step, self.first_step, self.largest_step) if step is not None]
        if given != sorted(given):
            raise ValueError("expected smallest_step <= first_step <= largest_step")
        return self


class Output(Settings):
    """What a run writes."""

    fields_every: PositiveInt = parameter(1, description="accepted steps between field files; the last is always one")
    checkpoint_every: PositiveInt | None = parameter(
        None, description="accepted steps between checkpoints, beside those by time"
    )
    checkpoint_interval: PositiveTime = parameter("60 s", description="wall time between checkpoints; one at the end")
    critical_mode: bool = parameter(
        False, description="write the mode in which stability is lost first, where the tangent is symmetric"
    )
    picture: bool = parameter(True, description="draw summary.png")
    permeability: Annotated[PermeabilityLaw, Choice("permeability", "gebart")] | None = parameter(
        None, description="permeability as fields; none unless given"
    )


class Explicit(Settings):
    """Marching by central differences, for ``ncf-fenicsx explicit``: an explicit code to compare with."""

    mass_scaling: float = parameter(5.0, ge=1, description="factor on the density")
    time_scaling: float = parameter(
        1000.0, ge=1, description="how much faster than in the scene the tools move; laws keep the scene's time"
    )
    bulk_viscosity: float = parameter(
        0.06, ge=0, lt=1, description="damping of changes of volume, over the critical one of the highest mode"
    )
    damping: float = parameter(
        0.02,
        ge=0,
        lt=1,
        description="damping of all motion, over the critical one of the stack's lowest mode across it",
    )
    safety: float = parameter(0.9, gt=0, le=1, description="step over the largest stable one")
    rows: PositiveInt = parameter(200, description="rows of the history; states of the laws go on with each")
    kinetic_share: float = parameter(
        0.05, gt=0, description="kinetic over internal energy above which a run is not called quasi-static"
    )


class Scene(Settings):
    """One case: what is pressed by what, by which laws, and how it is solved and written."""

    title: str = parameter("untitled", min_length=1, description="name in pictures and reports")
    stack: Stack = parameter(Stack(), description="layers and mesh")
    laws: Laws = parameter({}, description="constitutive laws")
    interface: Annotated[tuple[Bonded | OneSided, ...], Choices("interface", "one_sided")] = parameter(
        {}, description="how layers meet, one for all or a list from the bottom up"
    )
    tool: Annotated[tuple[Tool, ...], Choices("tool", "cylinder")] = parameter(
        (), description="rigid tool, or a list of tools; none unless given"
    )
    mould: Annotated[Mould, Choice("mould", "cylinder")] | None = parameter(
        None, description="rigid mould below the stack; a plane that holds its bottom down unless given"
    )
    duration: PositiveTime | None = parameter(
        None, description="duration of a scene without a tool; else its path gives it"
    )
    gravity: Acceleration = parameter("9.81 m/s^2", description="gravity, along -z")
    solver: Solver = parameter(Solver(), description="steps and Newton's method")
    output: Output = parameter(Output(), description="what is written")
    explicit: Explicit | None = parameter(None, description="how `ncf-fenicsx explicit` marches")

    @model_validator(mode="after")
    def _lasts_some_time(self) -> Self:
        if bool(self.tool) == (self.duration is not None):
            raise ValueError("expected either a [tool] with its path, or a duration")
        return self

    @model_validator(mode="after")
    def _an_interface_for_each_pair(self) -> Self:
        if len(self.interface) not in (1, self.stack.layers - 1):
            expected = f"expected one table, or one for each of {self.stack.layers - 1} interfaces"
            raise impossible("interface", f"{len(self.interface)} tables", expected)
        return self

    @model_validator(mode="after")
    def _tools_can_roll(self) -> Self:
        for number, tool in enumerate(self.tool):
            if tool.axle is None and any(segment.roll for segment in tool.path):
                raise impossible(f"tool.{number}.kind", tool.kind, "expected a tool that can roll, such as cylinder")
        return self

    @model_validator(mode="after")
    def _heights_go_with_whole_steps(self) -> Self:
        if self.solver.line_search != "full" and any(tool.under_force for tool in self.tool):
            expected = 'expected "full" with a tool under a force, whose height follows whole steps'
            raise impossible("solver.line_search", self.solver.line_search, expected)
        return self

    @model_validator(mode="after")
    def _modes_are_of_a_symmetric_tangent(self) -> Self:
        if self.solver.perturbation is not None and not self.symmetric:
            expected = "expected none, where a law or contact makes the tangent not symmetric"
            raise impossible("solver.perturbation", f"{1e3 * self.solver.perturbation:.6g} mm", expected)
        if self.solver.perturbation is not None and not self.solver.may_steady:
            raise impossible("solver.steadying", "none", 'expected "automatic" with solver.perturbation')
        return self

    @model_validator(mode="after")
    def _laws_go_together(self) -> Self:
        initial = self.stack.initial_volume_fraction
        if self.laws.solid is None and initial >= 1:
            expected = "expected less than fibre_density thickness, for Vf0 below 1"
            raise impossible("stack.areal_density", self.stack.areal_density, f"gives Vf0 = {initial:.3f}; {expected}")
        for law in self.laws.chosen:
            law.check(self)
        if not 0 < real(lambda _: self.natural_stiffness, 0.0) < math.inf:
            compaction = self.laws.compaction
            raise impossible("laws.compaction", compaction.kind, "expected parameters whose pressure grows with Vf")
        if self.output.permeability is not None:
            self.output.permeability.check(self)
        return self

    @property
    def natural_stiffness(self) -> float:
        """Stiffness of a layer in Pa/m, compaction tangent over thickness at the tool's highest speed."""
        fastest = max((motion.closing_speed((segment,), 0.0) for segment in self.segments), default=0.0)
        tangent = self.laws.compaction_tangent(self.stack.initial_volume_fraction, fastest)
        return tangent / self.stack.thickness

    @property
    def cautions(self) -> list[str]:
        """What a user of the scene's laws has to know before a run."""
        return [f"laws.{law.family}: {words}" for law in self.laws.chosen if (words := law.caution(self))]

    @property
    def packing_limit(self) -> tuple[float, str]:
        """Vf that no accepted step may reach, and which law ends there."""
        compaction, permeability = self.laws.compaction, self.output.permeability
        limits = [(compaction.packing_limit, f"laws.compaction, {compaction.kind}")]
        if permeability is not None:
            limits.append((permeability.packing_limit, f"output.permeability, {permeability.kind}"))
        return min(limits)

    @property
    def interfaces(self) -> list[Bonded | OneSided]:
        """How each layer meets the next, from the bottom up."""
        return list(self.interface) * (self.stack.layers - 1 if len(self.interface) == 1 else 1)

    @property
    def rigid_surfaces(self) -> list[RigidSurface]:
        """The tools, and the mould after them."""
        return [*self.tool, *([self.mould] if self.mould is not None else [])]

    @property
    def symmetric(self) -> bool:
        """Whether the tangent is symmetric: that of all laws and contacts."""
        contacts: list[RigidSurface | OneSided] = [*self.rigid_surfaces]
        contacts += [way for way in self.interfaces if isinstance(way, OneSided)]
        return self.laws.symmetric and all(way.contact.symmetric and way.friction is None for way in contacts)

    @property
    def segments(self) -> list[Segment]:
        """All pieces of all tools' paths."""
        return [segment for tool in self.tool for segment in tool.path]

    @property
    def milestones(self) -> list[float]:
        """Times in s that steps land on: the ends of all segments of all paths, or of the duration."""
        ends = sorted(time for tool in self.tool for time in motion.milestones(tool.path))
        apart = [time for time, after in pairwise([*ends, math.inf]) if after - time > 1e-9 * ends[-1]]
        return apart or [float(self.duration or 0.0)]

    @classmethod
    def read(cls, path: str | Path, overrides: Iterable[str] = ()) -> Scene:
        """Scene from a TOML file.

        Args:
            path: the file; a mesh it names is looked for beside it.
            overrides: ``key.of.table=value`` texts that replace what the file says.

        Raises:
            SceneError: the file cannot be read or is no valid scene.
        """
        path = Path(path)
        try:
            data = tomllib.loads(path.read_text(encoding="utf-8"))
        except OSError as error:
            raise SceneError(f"{path}: {error.strerror}; expected a scene file") from error
        except (tomllib.TOMLDecodeError, UnicodeDecodeError) as error:
            raise SceneError(f"{path}: not TOML: {error}") from error
        for text in overrides:
            apply_override(data, text)
        scene = cls.from_table(data, source=str(path))
        return scene if scene.stack.mesh is None else scene.with_mesh_beside(path)

    @classmethod
    def from_table(cls, data: dict[str, Any], source: str = "scene") -> Scene:
        """Scene from nested dictionaries, as a TOML file gives them.

        Raises:
            SceneError: a key or value is not valid.
        """
        try:
            return cls.model_validate(data)
        except ValidationError as error:
            raise SceneError(f"{source}: {one_line(error)}") from error

    def with_mesh_beside(self, path: Path) -> Scene:
        """The scene with the full path of its mesh, given relative to a scene file."""
        mesh = path.parent / str(self.stack.mesh)
        if not mesh.is_file():
            raise SceneError(f"{path}: stack.mesh = {self.stack.mesh!r}: no such file; expected a gmsh file")
        stack = self.stack.model_copy(update={"mesh": str(mesh.resolve())})
        return self.model_copy(update={"stack": stack})

    def table(self) -> dict[str, Any]:
        """The scene with all defaults filled in, in SI, as nested tables: what it does not use is left out."""
        table: dict[str, Any] = _without_none(self.model_dump())
        if self.laws.solid is not None:
            table["laws"] = {"solid": table["laws"]["solid"]}
        if self.stack.mesh is not None:
            for key in GIVEN_BY_MESH:
                table["stack"].pop(key, None)
        return table

    def to_toml(self) -> str:
        """That table as a file that reads back to the same scene."""
        return tomli_w.dumps(self.table())


def apply_override(data: dict[str, Any], text: str) -> None:
    """Set one nested key of a table from ``key.of.table=value``; a number in the key picks from a list.

    Raises:
        SceneError: the text has no ``=``, or its key leads through something that is no table.
    """
    key, equals, value = text.partition("=")
    if not equals:
        raise SceneError(f"--set {text}: expected KEY=VALUE, such as stack.layers=2")
    try:
        parsed = tomllib.loads(f"value = {value}")["value"]
    except tomllib.TOMLDecodeError:
        parsed = value.strip()
    *tables, last = key.strip().split(".")
    target: Any = data
    try:
        for name in tables:
            target = target[int(name)] if isinstance(target, list) else target.setdefault(name, {})
        target[int(last) if isinstance(target, list) else last] = parsed
    except (AttributeError, IndexError, TypeError, ValueError) as error:
        raise SceneError(f"--set {text}: no such table in the scene; expected a key such as stack.layers") from error


def _without_none(table: Any) -> Any:
    if isinstance(table, dict):
        return {key: _without_none(value) for key, value in table.items() if value is not None}
    return [_without_none(item) for item in table] if isinstance(table, list | tuple) else table
