"""Fibre families: plies with their angles, stiffer in tension than in compression."""

from __future__ import annotations

import math
from typing import Annotated, Any, Self

import ufl
from pydantic import PlainValidator, PrivateAttr, model_validator

from ncf_fenicsx.kinds import impossible, parameter
from ncf_fenicsx.laws.elasticity import HyperelasticInPlaneLaw
from ncf_fenicsx.laws.kinematics import Expression
from ncf_fenicsx.units import PositiveStress


def _read_plies(value: Any) -> Any:
    """Angles as floats, in one list or in a list for each layer.

    Raises:
        ValueError: neither of both, or an empty list.
    """
    entries = list(value) if isinstance(value, list | tuple) else []
    nested = [isinstance(entry, list | tuple) for entry in entries]
    if entries and all(nested):
        return tuple(_read_angles(entry) for entry in entries)
    return _read_angles(entries)


def _read_angles(entries: Any) -> tuple[float, ...]:
    if not entries or not all(isinstance(angle, int | float) and math.isfinite(angle) for angle in entries):
        raise ValueError("expected angles in degrees, such as [0, 45, 90], or such a list for each layer")
    return tuple(float(angle) for angle in entries)


class FibreFamilies(HyperelasticInPlaneLaw):
    """Mean over the plies of a fibre energy in their strain, and a shear energy of the layer.

    With E = (C_s - I)/2 and e = a . E a the strain of a ply's fibres (angle from the x axis):
    W = mean_i [modulus_compression e_i^2 / 2 + (modulus - modulus_compression) f(e_i)] + G (E : E - (tr E)^2 / 2),
    where f'(e) is zero in compression, e - transition/2 past the transition, and a parabola between, so that stress and
    tangent are continuous. G gives G gamma in simple shear, and is all that holds a layer across a single direction.
    """

    kind = "fibre_families"
    plies: Annotated[tuple[Any, ...], PlainValidator(_read_plies)] = parameter(
        (45.0, -45.0, 0.0, 90.0, 0.0, -45.0, 45.0),
        description="angles of the plies of every layer in degrees from x, or a list of them for each layer",
    )
    modulus: PositiveStress = parameter("242 GPa", description="fibre modulus in tension, of a ply along its fibres")
    modulus_compression: PositiveStress = parameter("24.2 GPa", description="the same in compression, not larger")
    transition: float = parameter(1e-5, gt=0, lt=0.1, description="strain over which compression turns into tension")
    shear_modulus: PositiveStress = parameter("1 MPa", description="in-plane shear modulus G of the layer")

    _bound: list[tuple[Any, Any]] | None = PrivateAttr(default=None)

    @model_validator(mode="after")
    def _softer_in_compression(self) -> Self:
        if self.modulus_compression > self.modulus:
            expected = f"expected at most modulus = {self.modulus:g} Pa"
            raise impossible("modulus_compression", self.modulus_compression, expected)
        return self

    def check(self, scene: Any) -> None:
        """Raise unless there is a list of plies for each layer, where there are several."""
        count, layers = len(self._stacks), scene.stack.layers
        if self._per_layer and count != layers:
            raise impossible("laws.in_plane.plies", self.plies, f"expected a list for each of {layers} layers")

    @property
    def _per_layer(self) -> bool:
        return isinstance(self.plies[0], tuple)

    @property
    def _stacks(self) -> tuple[Any, ...]:
        return self.plies if self._per_layer else (self.plies,)

    def families(self) -> list[tuple[float, tuple[float, ...]]]:
        """Each direction in degrees, in [0, 180), with its share of the plies, one for all layers or one for each."""
        stacks = [[angle % 180 for angle in stack] for stack in self._stacks]
        angles = sorted({angle for stack in stacks for angle in stack})
        return [(angle, tuple(stack.count(angle) / len(stack) for stack in stacks)) for angle in angles]

    def with_symbols(self, symbols: Any) -> Self:
        """Copy with symbols for its numbers; shares that differ from layer to layer become fields."""
        copy = super().with_symbols(symbols).model_copy(update={"plies": self.plies})
        share = symbols.by_layer if self._per_layer else lambda shares: symbols(shares[0])
        copy._bound = [(symbols(angle), share(shares)) for angle, shares in self.families()]
        return copy

    def energy(self, in_plane_cauchy_green: Expression) -> Expression:
        """W in J/m3; that of the lowest layer where it has not been given symbols."""
        E = (in_plane_cauchy_green - ufl.Identity(2)) / 2
        families = self._bound or [(angle, shares[0]) for angle, shares in self.families()]
        shear = self.shear_modulus * (ufl.inner(E, E) - ufl.tr(E) ** 2 / 2)
        return shear + sum(share * self._fibre_energy(_along(E, angle)) for angle, share in families)

    def _fibre_energy(self, strain: Expression) -> Expression:
        """Energy of one family over its strain."""
        d = self.transition
        stretched = ufl.max_value(strain, 0.0)
        beyond = ufl.max_value(strain - d, 0.0)
        tension = (stretched**3 - beyond**3) / (6 * d)
        return self.modulus_compression * strain**2 / 2 + (self.modulus - self.modulus_compression) * tension

    @property
    def stiffness(self) -> Expression:
        """Fibre modulus in tension in Pa."""
        return self.modulus


def _along(E: Expression, angle: Any) -> Expression:
    """Strain a . E a along a direction at an angle in degrees."""
    radians = angle * (math.pi / 180)
    c, s = ufl.cos(radians), ufl.sin(radians)
    return c * c * E[0, 0] + s * s * E[1, 1] + c * s * (E[0, 1] + E[1, 0])
