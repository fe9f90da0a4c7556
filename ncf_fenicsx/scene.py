"""The case as frozen, validated data: read from TOML, quantities converted to SI, errors in one line."""

from __future__ import annotations

import tomllib
from collections.abc import Iterable
from pathlib import Path
from typing import Annotated, Any, Literal, Self

import tomli_w
from pydantic import Field, PositiveInt, ValidationError, model_validator

from ncf_fenicsx.contracts import CompactionLaw, InPlaneLaw, RateLaw, ShearLaw, Tool
from ncf_fenicsx.motion import Segment
from ncf_fenicsx.parts import Choice, Part, Settings, parameter
from ncf_fenicsx.scene_errors import SceneError, one_line
from ncf_fenicsx.units import (
    Acceleration,
    ArealDensity,
    Density,
    Length,
    NonNegativeStiffness,
    Penalty,
    PositiveLength,
    PositiveTime,
)

GIVEN_BY_MESH = {"size", "divisions", "through", "grading", "focus"}
Side = Literal["free", "fixed", "symmetry"]
Grading = Annotated[float, Field(ge=0, lt=1)]


class Sides(Settings):
    """How each lateral side of the modelled stack is held; at a symmetry plane the scene stands for its mirror too."""

    x_min: Side = parameter("symmetry", description="side at the lowest x")
    x_max: Side = parameter("free", description="side at the highest x")
    y_min: Side = parameter("symmetry", description="side at the lowest y")
    y_max: Side = parameter("free", description="side at the highest y")

    @model_validator(mode="after")
    def _cannot_slide_away(self) -> Self:
        held_x = {self.x_min, self.x_max} - {"free"}
        held_y = {self.y_min, self.y_max} - {"free"}
        if "fixed" not in held_x | held_y and not (held_x and held_y):
            raise ValueError(
                "nothing keeps the layers from sliding away; expected a fixed side, or a symmetry plane in x and in y"
            )
        return self

    @property
    def copies(self) -> int:
        """Number of mirror images the model stands for: the factor from its forces to those of the whole."""
        planes = (self.x_min, self.x_max, self.y_min, self.y_max).count("symmetry")
        return 2**planes


class Stack(Settings):
    """The layers of fabric, and their mesh."""

    layers: PositiveInt = parameter(4, description="number of layers")
    thickness: PositiveLength = parameter("2 mm", description="thickness of each layer")
    size: tuple[PositiveLength, PositiveLength] = parameter(
        ("76 mm", "76 mm"), description="modelled extent in x and y (a quarter, by symmetry)"
    )
    areal_density: ArealDensity = parameter("1425 g/m^2", description="mass per area of each layer")
    fibre_density: Density = parameter("1.79e6 g/m^3", description="density of the fibres")
    divisions: tuple[PositiveInt, PositiveInt] = parameter((40, 24), description="elements along x and y")
    through: PositiveInt | tuple[PositiveInt, ...] = parameter(
        1, description="elements through each layer, one number or one a layer"
    )
    grading: tuple[Grading, Grading] = parameter(
        (0.8, 0.8), description="refinement towards the focus in x and y: 0 is uniform, near 1 is strong"
    )
    focus: tuple[Length, Length] | None = parameter(
        None, description="x and y that the mesh is refined towards; the tool's position unless given"
    )
    mesh: str | None = parameter(
        None, description="gmsh file to use instead of size, divisions, through, grading, focus; relative to the scene"
    )
    sides: Sides = parameter(Sides(), description="how the lateral sides are held")

    @model_validator(mode="after")
    def _consistent(self) -> Self:
        given = self.model_fields_set & GIVEN_BY_MESH
        if self.mesh is not None and given:
            raise ValueError(f"the mesh file gives {', '.join(sorted(given))}; expected only one of both")
        if isinstance(self.through, tuple) and len(self.through) != self.layers:
            raise ValueError(f"through has {len(self.through)} numbers; expected one for each of {self.layers} layers")
        if self.initial_volume_fraction >= 1:
            raise ValueError(
                f"areal_density / (fibre_density thickness) gives Vf0 = {self.initial_volume_fraction:.3f}; "
                "expected less than 1"
            )
        return self

    @property
    def initial_volume_fraction(self) -> float:
        """Vf0 = areal density / (fibre density * thickness) (paper, second Eq. 4)."""
        return float(self.areal_density / (self.fibre_density * self.thickness))

    @property
    def elements_through(self) -> tuple[int, ...]:
        """Number of elements through each layer, from the bottom up."""
        return self.through if isinstance(self.through, tuple) else (self.through,) * self.layers


class Laws(Settings):
    """The constitutive laws, each chosen by ``kind``."""

    in_plane: Annotated[InPlaneLaw, Choice("in_plane", "neo_hookean")] = parameter({}, description="fibre elasticity")
    compaction: Annotated[CompactionLaw, Choice("compaction", "exponential")] = parameter(
        {}, description="pressure over fibre volume fraction"
    )
    rate: Annotated[RateLaw, Choice("rate", "kelly")] = parameter({}, description="dependence on the tool's speed")
    shear: Annotated[ShearLaw, Choice("shear", "constant")] = parameter({}, description="transverse shear")


class Bonded(Part):
    """Neighbouring layers share their nodes."""

    family = "interface"
    kind = "bonded"


class OneSided(Part):
    """Neighbouring layers touch without friction and can open."""

    family = "interface"
    kind = "one_sided"
    penalty: Penalty = parameter(
        10.0, description="contact stiffness in Pa/m, or a factor on the compaction tangent over the layer's thickness"
    )
    stitching: NonNegativeStiffness = parameter(
        "0 Pa/m", description="stiffness of the stitching yarns against opening; 0 is none"
    )


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
    force_tolerance: float = parameter(1e-7, gt=0, lt=1, description="residual over the support force at convergence")
    increment_tolerance: float = parameter(1e-4, gt=0, lt=1, description="last increment over the layer's thickness")
    increment_cap: float = parameter(0.3, gt=0, description="largest nodal increment over the layer's thickness")

    @model_validator(mode="after")
    def _steps_in_order(self) -> Self:
        given = [step for step in (self.smallest_step, self.first_step, self.largest_step) if step is not None]
        if given != sorted(given):
            raise ValueError("expected smallest_step <= first_step <= largest_step")
        return self


class Output(Settings):
    """What a run writes."""

    fields_every: PositiveInt = parameter(1, description="accepted steps between field files; the last is always one")
    picture: bool = parameter(True, description="draw summary.png")


class Scene(Settings):
    """One case: what is pressed by what, by which laws, and how it is solved and written."""

    title: str = parameter("untitled", min_length=1, description="name in pictures and reports")
    stack: Stack = parameter(Stack(), description="layers and mesh")
    laws: Laws = parameter({}, description="constitutive laws")
    interface: Annotated[Bonded | OneSided, Choice("interface", "one_sided")] = parameter(
        {}, description="how layers meet"
    )
    tool: Annotated[Tool, Choice("tool", "cylinder")] | None = parameter(
        None, description="rigid tool; none unless given"
    )
    duration: PositiveTime | None = parameter(
        None, description="duration of a scene without a tool; else its path gives it"
    )
    gravity: Acceleration = parameter("9.81 m/s^2", description="gravity, along -z")
    solver: Solver = parameter(Solver(), description="steps and Newton's method")
    output: Output = parameter(Output(), description="what is written")

    @model_validator(mode="after")
    def _lasts_some_time(self) -> Self:
        if (self.tool is None) == (self.duration is None):
            raise ValueError("expected either a [tool] with its path, or a duration")
        return self

    @property
    def path(self) -> tuple[Segment, ...]:
        """Path of the tool; empty without one."""
        return self.tool.path if self.tool is not None else ()

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

    def to_toml(self) -> str:
        """The scene with all defaults filled in, in SI, as a file that reads back to the same scene."""
        table = _without_none(self.model_dump())
        if self.stack.mesh is not None:
            for key in GIVEN_BY_MESH:
                table["stack"].pop(key, None)
        return tomli_w.dumps(table)


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
