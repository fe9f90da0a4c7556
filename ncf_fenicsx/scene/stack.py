"""The stack of a scene: its layers, their mesh, and how they are held."""

from __future__ import annotations

from itertools import pairwise
from typing import Annotated, Any, Literal, Self, cast

from pydantic import BeforeValidator, Field, PlainSerializer, PositiveInt, model_validator

from ncf_fenicsx.errors import SceneError
from ncf_fenicsx.parameters.kinds import Settings, parameter
from ncf_fenicsx.parameters.units import ArealDensity, Density, Length, PositiveLength, Thickness

GIVEN_BY_NODES = {"divisions", "grading", "focus", "mesh_error"}
GIVEN_BY_MESH = {"size", "through", "nodes", *GIVEN_BY_NODES}
AUTOMATIC = "automatic"
SAME = 1e-6
"""Difference of two lengths over their size that is round-off."""
Order = Literal[1, 2]
RESOLVED = 4
"""Elements through a layer that are taken to resolve what happens in it."""
Side = Literal["free", "fixed", "symmetry"]
Bottom = Literal["plane", "free"]
Grading = Annotated[float, Field(ge=0, lt=1)]


def _none_if_automatic(value: Any) -> Any:
    if isinstance(value, str) and value != AUTOMATIC:
        raise ValueError(f'expected two whole numbers, or "{AUTOMATIC}"')
    return None if value == AUTOMATIC else value


Count = Annotated[int, Field(gt=0, strict=True)]
Divisions = tuple[Count, Count]
DivisionsOrNone = Annotated[
    Divisions | tuple[Divisions, ...] | None,
    BeforeValidator(_none_if_automatic),
    PlainSerializer(lambda value: AUTOMATIC if value is None else value),
]
"""None is the word "automatic"."""
Nodes = Annotated[tuple[Length, ...], Field(min_length=2)]


class Sides(Settings):
    """How each side of the modelled stack is held; at a symmetry plane the scene stands for its mirror too."""

    x_min: Side = parameter("symmetry", description="side at the lowest x")
    x_max: Side = parameter("free", description="side at the highest x")
    y_min: Side = parameter("symmetry", description="side at the lowest y")
    y_max: Side = parameter("free", description="side at the highest y")
    bottom: Bottom = parameter(
        "plane",
        description="bottom: on a rigid plane that holds it down (or on a mould), or free, to hang over an edge",
    )

    @model_validator(mode="after")
    def _cannot_fall(self) -> Self:
        if self.bottom == "free" and "fixed" not in self._held(("x", "y")):
            raise ValueError("nothing keeps the layers from falling; expected a fixed side with bottom = 'free'")
        return self

    @property
    def hold(self) -> bool:
        """Whether the sides alone keep the layers from sliding away."""
        return "fixed" in self._held(("x", "y")) or bool(self._held("x") and self._held("y"))

    def _held(self, axes: tuple[str, ...] | str) -> set[Side]:
        return {getattr(self, f"{axis}_{end}") for axis in axes for end in ("min", "max")} - {"free"}

    @property
    def copies(self) -> int:
        """Number of mirror images the model stands for: the factor from its forces to those of the whole."""
        planes = (self.x_min, self.x_max, self.y_min, self.y_max).count("symmetry")
        return 2**planes


class Stack(Settings):
    """The layers of fabric, and their mesh."""

    layers: PositiveInt = parameter(4, description="number of layers")
    thickness: Thickness = parameter("2 mm", description="thickness of each layer")
    size: tuple[PositiveLength, PositiveLength] = parameter(
        ("76 mm", "76 mm"), description="modelled extent in x and y (a quarter, by symmetry)"
    )
    areal_density: ArealDensity = parameter("1425 g/m^2", description="mass per area of each layer")
    fibre_density: Density = parameter("1.79e6 g/m^3", description="density of the fibres")
    divisions: DivisionsOrNone = parameter(
        (120, 24),
        description='elements along x and y, or a pair for each layer; or "automatic": by a coarse run, for mesh_error',
    )
    mesh_error: float = parameter(
        0.01,
        gt=0,
        le=0.5,
        description="with automatic divisions, the error of the field of Vf by the mesh in the plane, over the field's "
        "change, that is aimed at",
    )
    nodes: tuple[Nodes, Nodes] | None = parameter(
        None,
        description="x and y of the nodes, from 0 to size, in place of divisions and grading; automatic divisions are "
        "written down so",
    )
    through: PositiveInt | tuple[PositiveInt, ...] | Literal["resolved"] = parameter(
        1,
        description="elements through each layer, one number or one a layer, which is part of the model; or resolved: "
        "4, and as many more or less as the mesh is refined for an accuracy",
    )
    order: Order = parameter(
        1, description="order of the displacement in the plane of the layers: 1, or 2 with nodes halfway too"
    )
    grading: tuple[Grading, Grading] = parameter(
        (0.9, 0.8), description="refinement towards the focus in x and y: 0 is uniform, near 1 is strong"
    )
    focus: tuple[Length, Length] | None = parameter(
        None, description="x and y that the mesh is refined towards; the tool's position unless given"
    )
    mesh: str | None = parameter(
        None,
        description="file of gmsh (.msh), Abaqus (.inp) or VTK (.vtk, .vtu) to use instead of size, divisions, "
        "through, grading, focus; relative to the scene",
    )
    sides: Sides = parameter(Sides(), description="how the lateral sides are held")

    @model_validator(mode="after")
    def _consistent(self) -> Self:
        by_nodes = sorted(self.model_fields_set & GIVEN_BY_NODES) if self.nodes is not None else []
        if by_nodes:
            raise ValueError(f"nodes give {', '.join(by_nodes)}; expected only one of both")
        given = self.model_fields_set & GIVEN_BY_MESH
        if self.mesh is not None and given:
            raise ValueError(f"the mesh file gives {', '.join(sorted(given))}; expected only one of both")
        if isinstance(self.through, tuple) and len(self.through) != self.layers:
            raise ValueError(f"through has {len(self.through)} numbers; expected one for each of {self.layers} layers")
        if not self.is_automatic and len(self.divisions_by_layer) != self.layers:
            found = len(self.divisions_by_layer)
            raise ValueError(f"divisions has {found} pairs; expected one for each of {self.layers} layers")
        return self

    @model_validator(mode="after")
    def _nodes_are_in_order(self) -> Self:
        for letter, positions, size in zip("xy", self.nodes or (), self.size, strict=False):
            if any(after <= before for before, after in pairwise(positions)):
                raise ValueError(f"nodes along {letter} are not in ascending order; expected each beyond the last")
            if abs(positions[0]) > SAME * size or abs(positions[-1] - size) > SAME * size:
                found = f"{1e3 * positions[0]:.6g} to {1e3 * positions[-1]:.6g} mm"
                raise ValueError(f"nodes along {letter} are at {found}; expected 0 to size = {1e3 * size:.6g} mm")
        return self

    @property
    def is_automatic(self) -> bool:
        """Whether a coarse run is to tell where the nodes are."""
        return self.divisions is None and self.nodes is None

    @property
    def divisions_by_layer(self) -> list[Divisions]:
        """Elements along x and y of each layer, from the bottom up.

        Raises:
            SceneError: they are automatic, and not known yet.
        """
        if self.nodes is not None:
            return [(len(self.nodes[0]) - 1, len(self.nodes[1]) - 1)] * self.layers
        if self.divisions is None:
            raise SceneError(
                f'stack.divisions = "{AUTOMATIC}": a run finds them; expected two numbers for what is no plain run'
            )
        by_layer = isinstance(self.divisions[0], tuple)
        return list(cast(Any, self.divisions if by_layer else [self.divisions] * self.layers))

    def with_nodes(self, nodes: tuple[tuple[float, ...], tuple[float, ...]]) -> Self:
        """The stack with nodes at x and y in m in place of divisions."""
        default = type(self)()
        return self.model_copy(update={"nodes": nodes} | {key: getattr(default, key) for key in GIVEN_BY_NODES})

    @property
    def initial_volume_fraction(self) -> float:
        """Vf0 = areal density / (fibre density * thickness) (paper, second Eq. 4)."""
        return float(self.areal_density / (self.fibre_density * self.thickness))

    @property
    def elements_through(self) -> tuple[int, ...]:
        """Number of elements through each layer, from the bottom up."""
        if isinstance(self.through, tuple):
            return self.through
        return (RESOLVED if self.through == "resolved" else self.through,) * self.layers
