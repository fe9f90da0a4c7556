"""The case as frozen, validated data: read from TOML, quantities converted to SI, errors in one line."""

from __future__ import annotations

import math
import os
from collections.abc import Iterable
from itertools import pairwise
from pathlib import Path
from typing import Annotated, Any, Self, TypeVar

import tomli_w
from pydantic import ValidationError, model_validator

from ncf_fenicsx.errors import SceneError, one_line
from ncf_fenicsx.laws.law import Conditions, real
from ncf_fenicsx.laws.solid import POINT_PRESSURE_HOLDS_TO
from ncf_fenicsx.parameters.kinds import Choice, Choices, Settings, impossible, parameter
from ncf_fenicsx.parameters.units import Acceleration, PositiveTime
from ncf_fenicsx.scene.fabric_file import with_fabric
from ncf_fenicsx.scene.interfaces import Bonded, OneSided
from ncf_fenicsx.scene.laws import Laws
from ncf_fenicsx.scene.scene_file import apply_override, read_table, without_none
from ncf_fenicsx.scene.settings import Accuracy, Explicit, Output, Solver
from ncf_fenicsx.scene.stack import AUTOMATIC, GIVEN_BY_MESH, GIVEN_BY_NODES, Stack
from ncf_fenicsx.scene.usual_values import unusual
from ncf_fenicsx.tools import path as motion
from ncf_fenicsx.tools.path import Segment
from ncf_fenicsx.tools.rigid_surface import Mould, RigidSurface, Tool

Surface = TypeVar("Surface", bound=RigidSurface)


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
    accuracy: Accuracy | None = parameter(None, description="what a sequence of finer runs is to reach")
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
    def _layers_cannot_slide_away(self) -> Self:
        rubs = self.mould is not None and self.mould.friction is not None
        if not self.stack.sides.hold and not (rubs and all(way.holds for way in self.interfaces)):
            held = "a fixed side, a symmetry plane in x and in y, or friction at a mould and between all layers"
            raise ValueError(f"stack.sides: nothing keeps the layers from sliding away; expected {held}")
        return self

    @model_validator(mode="after")
    def _bottom_is_free_or_on_a_mould(self) -> Self:
        if self.mould is not None and self.stack.sides.bottom == "free":
            raise impossible("stack.sides.bottom", "free", 'expected "plane" with a mould, which takes its place')
        return self

    @model_validator(mode="after")
    def _tools_can_roll(self) -> Self:
        for number, tool in enumerate(self.tool):
            if tool.axle is None and any(segment.roll for segment in tool.path):
                raise impossible(f"tool.{number}.kind", tool.kind, "expected a tool that can roll, such as cylinder")
        return self

    @model_validator(mode="after")
    def _heights_go_with_whole_steps(self) -> Self:
        if self.solver.line_search not in ("full", "work") and any(tool.under_force for tool in self.tool):
            expected = 'expected "full" with a tool under a force, whose height follows whole steps'
            raise impossible("solver.line_search", self.solver.line_search, expected)
        return self

    @model_validator(mode="after")
    def _modes_are_of_a_symmetric_tangent(self) -> Self:
        if self.solver.perturbation is not None and not self.symmetric:
            expected = "expected none, where a law or contact makes the tangent not symmetric"
            raise impossible("solver.perturbation", f"{1e3 * self.solver.perturbation:.6g} mm", expected)
        if self.solver.perturbation is not None and not self.solver.may_stabilise:
            raise impossible("solver.stabilisation", "none", 'expected "automatic" with solver.perturbation')
        return self

    @model_validator(mode="after")
    def _layers_can_be_told_apart(self) -> Self:
        factors = self.solver.factors
        if factors == "layers" and not any(isinstance(way, OneSided) for way in self.interfaces):
            raise impossible("solver.factors", "layers", "expected layers that may part, for factors of each")
        if factors == "multigrid" and (self.laws.solid is None or not self.symmetric):
            raise impossible("solver.factors", "multigrid", "expected laws.solid, and contact with a symmetric tangent")
        return self

    @model_validator(mode="after")
    def _laws_go_together(self) -> Self:
        initial = self.stack.initial_volume_fraction
        if self.laws.solid is None and initial >= 1:
            expected = "expected less than fibre_density thickness, for Vf0 below 1"
            raise impossible("stack.areal_density", self.stack.areal_density, f"gives Vf0 = {initial:.3f}; {expected}")
        for law in self.laws.chosen:
            law.check(self.conditions)
        if self.laws.solid is not None and self.stack.is_automatic:
            expected = "expected two numbers with laws.solid, which has no Vf for a mesh to follow"
            raise impossible("stack.divisions", AUTOMATIC, expected)
        solid, limit = self.laws.solid, POINT_PRESSURE_HOLDS_TO
        if solid is not None and self.contact_uses_own_pressure and solid.poisson > limit:
            expected = f"expected {limit:g} at most with Nitsche's method: the stress at a node is then not the layer's"
            raise impossible("laws.solid.poisson", solid.poisson, expected)
        if not 0 < real(lambda _: self.natural_stiffness, 0.0) < math.inf:
            compaction = self.laws.compaction
            raise impossible("laws.compaction", compaction.kind, "expected parameters whose pressure grows with Vf")
        if self.output.permeability is not None:
            self.output.permeability.check(self.conditions)
        return self

    @property
    def conditions(self) -> Conditions:
        """What the laws are used for."""
        laws, initial = self.laws, self.stack.initial_volume_fraction
        return Conditions(
            initial_volume_fraction=initial,
            elements_through=self.stack.elements_through,
            closing_speeds=tuple(segment.closing_speed for segment in self.segments),
            fibre_modulus=float(laws.in_plane.stiffness),
            shear_modulus=laws.shear.small_strain_modulus,
            initial_pressure=real(lambda vf: laws.compaction.pressure(vf, vf), initial),
            has_fibres=laws.solid is None,
            layer_thickness=self.stack.thickness,
        )

    @property
    def natural_stiffness(self) -> float:
        """Stiffness of a layer in Pa/m, compaction tangent over thickness at the tool's highest speed."""
        fastest = max((segment.closing_speed for segment in self.segments), default=0.0)
        tangent = self.laws.compaction_tangent(self.stack.initial_volume_fraction, fastest)
        return tangent / self.stack.thickness

    @property
    def cautions(self) -> list[str]:
        """What a user of the scene has to know before a run: doubtful values, and what its laws say."""
        told = [(law.family, law.caution(self.conditions)) for law in self.laws.chosen]
        return [*unusual(self), *(f"laws.{family}: {words}" for family, words in told if words)]

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
    def contacts(self) -> list[RigidSurface | OneSided]:
        """All that the fabric may touch: tools, mould, and layers that may part."""
        return [*self.rigid_surfaces, *(way for way in self.interfaces if isinstance(way, OneSided))]

    @property
    def contact_uses_own_pressure(self) -> bool:
        """Whether a contact asks for the pressure that a layer's own stress has on its face."""
        return any(way.contact.uses_own_pressure for way in self.contacts)

    @property
    def symmetric(self) -> bool:
        """Whether the tangent is symmetric: that of all laws and contacts."""
        return self.laws.symmetric and not self.has_friction and all(way.contact.symmetric for way in self.contacts)

    @property
    def has_friction(self) -> bool:
        """Whether anything rubs on the fabric, or its layers on each other."""
        return any(way.friction is not None for way in self.contacts)

    @property
    def controls_time_error(self) -> bool:
        """Whether the local error in time decides on the size of steps."""
        return self.laws.follow_time and self.solver.time_tolerance < 1

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
            path: the file; a mesh and a fabric that it names are looked for beside it.
            overrides: ``key.of.table=value`` texts that replace what the file says.

        Raises:
            SceneError: the file cannot be read or is no valid scene.
        """
        path = Path(path)
        data, changes = read_table(path), list(overrides)
        for text in changes:
            if text.partition("=")[0].strip() == "fabric":
                apply_override(data, text)
        data = with_fabric(data, path)
        for text in (text for text in changes if text.partition("=")[0].strip() != "fabric"):
            apply_override(data, text)
        scene = cls.from_table(data, source=str(path))
        return scene if scene.stack.mesh is None else scene.with_mesh_beside(path)

    @classmethod
    def from_table(cls, data: dict[str, Any], source: str = "scene") -> Scene:
        """Scene from nested dictionaries, as a TOML file gives them.

        Raises:
            SceneError: a key or value is not valid.
        """
        data = with_fabric(data, Path(source))
        try:
            scene = cls.model_validate(data)
        except ValidationError as error:
            raise SceneError(f"{source}: {one_line(error)}") from error
        return scene.model_copy(update={"solver": scene.solver.with_friction()}) if scene.has_friction else scene

    def with_mesh_beside(self, path: Path) -> Scene:
        """The scene with the full path of its mesh, given relative to a scene file."""
        mesh = path.parent / str(self.stack.mesh)
        os.fsencode(mesh)  # where the locale has no such letter, that is what is wrong, not that the file is missing
        if not mesh.is_file():
            raise SceneError(f"{path}: stack.mesh = {self.stack.mesh!r}: no such file; expected a mesh file")
        stack = self.stack.model_copy(update={"mesh": str(mesh.resolve())})
        return self.model_copy(update={"stack": stack})

    def with_tools_over(self, position: tuple[float, float]) -> Scene:
        """The scene with a position (x, y) in m for tools and mould that have no position of their own."""
        tools, mould = tuple(_over(tool, position) for tool in self.tool), self.mould
        return self.model_copy(update={"tool": tools, "mould": None if mould is None else _over(mould, position)})

    def table(self) -> dict[str, Any]:
        """The scene with all defaults filled in, in SI, as nested tables: what it does not use is left out."""
        table: dict[str, Any] = without_none(self.model_dump())
        if self.laws.solid is not None:
            table["laws"] = {"solid": table["laws"]["solid"]}
        for key in GIVEN_BY_NODES if self.stack.nodes is not None else ():
            table["stack"].pop(key, None)
        if not self.stack.is_automatic:
            table["stack"].pop("mesh_error", None)
        if self.stack.mesh is not None:
            for key in GIVEN_BY_MESH:
                table["stack"].pop(key, None)
            tools = table.get("tool", [])
            written = [*(tools if isinstance(tools, list) else [tools]), table.get("mould")]
            for surface, keys in zip(self.rigid_surfaces, written, strict=False):
                if "position" not in surface.model_fields_set:
                    keys.pop("position")
        return table

    def to_toml(self) -> str:
        """That table as a file that reads back to the same scene."""
        return tomli_w.dumps(self.table())


def _over(surface: Surface, position: tuple[float, float]) -> Surface:
    return surface if "position" in surface.model_fields_set else surface.model_copy(update={"position": position})
