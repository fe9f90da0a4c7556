"""[laws.in_plane]: the fibres in their plane; second Piola-Kirchhoff stress S_s over C_s."""

from __future__ import annotations

import math
from abc import abstractmethod
from typing import Annotated, Any, Self

import ufl
from pydantic import PlainValidator, PrivateAttr, model_validator

from ncf_fenicsx.laws.kinematics import Expression, Kinematics
from ncf_fenicsx.laws.law import Conditions, Law
from ncf_fenicsx.parameters.kinds import impossible, parameter
from ncf_fenicsx.parameters.units import PositiveStress


class InPlaneLaw(Law):
    """Fibre elasticity: second Piola-Kirchhoff stress S_s in the fibres' plane."""

    family = "in_plane"

    @abstractmethod
    def stress(self, kinematics: Kinematics) -> Expression:
        """S_s in Pa, shape (2, 2); its virtual work is S_s : variation(C_s) / 2."""

    @property
    @abstractmethod
    def stiffness(self) -> Expression:
        """Largest in-plane modulus in Pa: it sets the forces that round-off leaves unbalanced."""


class HyperelasticInPlaneLaw(InPlaneLaw):
    """Fibre elasticity with an energy in C_s."""

    @abstractmethod
    def energy(self, in_plane_cauchy_green: Expression) -> Expression:
        """W in J/m3 of reference volume."""

    def stress(self, kinematics: Kinematics) -> Expression:
        """S_s = 2 dW/dC_s in Pa, shape (2, 2)."""
        C_s = ufl.variable(kinematics.in_plane_cauchy_green)
        return 2 * ufl.diff(self.energy(C_s), C_s)


class NeoHookean(HyperelasticInPlaneLaw):
    """W = mu/2 (tr C_s - 2 - 2 ln J_s) + lambda/2 (ln J_s)^2, so S_s = mu (I - C_s^-1) + lambda ln J_s C_s^-1.

    The paper's Eq. 1 uses the three-dimensional J, so that compaction across the thickness strains the fibres; here
    only the stretch of the fibres' plane does. mu and lambda are those of plane stress: a strip pulled in its
    plane has Young's modulus ``modulus`` and Poisson's ratio ``poisson``.
    """

    kind = "neo_hookean"
    modulus: PositiveStress = parameter("242 GPa", description="Young's modulus of the fibres")
    poisson: float = parameter(0.2, gt=-1, lt=1, description="Poisson's ratio in the plane (not in the paper)")

    def energy(self, in_plane_cauchy_green: Expression) -> Expression:
        """W in J/m3."""
        return plane_stress_energy(in_plane_cauchy_green, self.modulus, self.poisson)

    @property
    def stiffness(self) -> Expression:
        """Young's modulus in Pa."""
        return self.modulus


def plane_stress_energy(C_s: Expression, modulus: Expression, poisson: Expression) -> Expression:
    """Neo-Hookean energy in J/m3 of a sheet with a Young's modulus (Pa) and Poisson's ratio in its plane."""
    mu, lame = modulus / (2 * (1 + poisson)), modulus * poisson / (1 - poisson**2)
    log_area_stretch = ufl.ln(ufl.det(C_s)) / 2
    return mu / 2 * (ufl.tr(C_s) - 2 - 2 * log_area_stretch) + lame / 2 * log_area_stretch**2


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
    numbers = [angle for angle in entries if isinstance(angle, int | float) and not isinstance(angle, bool)]
    if not entries or len(numbers) < len(entries) or not all(map(math.isfinite, numbers)):
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

    def check(self, conditions: Conditions) -> None:
        """Raise unless there is a list of plies for each layer, where there are several."""
        count, layers = len(self._stacks), conditions.layers
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

    def with_constants(self, constants: Any) -> Self:
        """Copy with constants for its numbers; shares that differ from layer to layer become fields."""
        copy = super().with_constants(constants).model_copy(update={"plies": self.plies})
        share = constants.by_layer if self._per_layer else lambda shares: constants(shares[0])
        copy._bound = [(constants(angle), share(shares)) for angle, shares in self.families()]
        return copy

    def energy(self, in_plane_cauchy_green: Expression) -> Expression:
        """W in J/m3; that of the lowest layer where it has not been given constants."""
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


class NeoHookeanAsPrinted(InPlaneLaw):
    """sigma = mu/J (B - I) + lambda (J - 1) I with the three-dimensional J, of which the fibres' plane is kept.

    With P = I - n n, the stress P sigma P has the components mu (I + g g^T - C_s^-1) + lambda J (J - 1) C_s^-1 in the
    convected base of the plane, times 1/J; g = C_s^-1 (C_13, C_23). It is no derivative of an energy: compaction
    changes the stress in the plane, and a stretch of the plane does not change that across it.
    """

    kind = "as_printed"
    symmetric = False
    modulus: PositiveStress = parameter("242 GPa", description="Young's modulus of the fibres")
    poisson: float = parameter(0.3, gt=0, lt=0.5, description="Poisson's ratio (not in the paper)")

    def stress(self, kinematics: Kinematics) -> Expression:
        """S_s in Pa, shape (2, 2)."""
        inverse, J = ufl.inv(kinematics.in_plane_cauchy_green), kinematics.volume_ratio
        slope = ufl.dot(inverse, kinematics.transverse_shear)
        strain = ufl.Identity(2) + ufl.outer(slope, slope) - inverse
        return self.shear_modulus * strain + self.lame * J * (J - 1) * inverse

    @property
    def shear_modulus(self) -> Expression:
        """Mu in Pa."""
        return self.modulus / (2 * (1 + self.poisson))

    @property
    def lame(self) -> Expression:
        """Lambda in Pa."""
        return self.modulus * self.poisson / ((1 + self.poisson) * (1 - 2 * self.poisson))

    @property
    def stiffness(self) -> Expression:
        """Lambda + 2 mu in Pa."""
        return self.lame + 2 * self.shear_modulus

    def caution(self, conditions: Conditions) -> str | None:
        """Not symmetric, and unstable almost at once: where lambda times the compaction passes G_t, layers crimp."""
        modulus = conditions.shear_modulus
        return (
            f"the stress as printed has no energy, so the tangent is not symmetric (LU); compaction presses the fibres "
            f"in their plane by lambda = {self.lame / 1e9:.1f} GPa times its strain, and layers lose stability once "
            f"that passes G_t = {modulus / 1e6:.3g} MPa: from a compaction of {100 * modulus / self.lame:.2g} % on"
        )
