"""[laws.bending]: bending of a layer apart from its membrane stiffness."""

from __future__ import annotations

from abc import abstractmethod
from typing import Self

import ufl
from pydantic import model_validator

from ncf_fenicsx.laws.in_plane import HyperelasticInPlaneLaw, plane_stress_energy
from ncf_fenicsx.laws.kinematics import Expression, Kinematics
from ncf_fenicsx.laws.law import Conditions, Law
from ncf_fenicsx.laws.monotone_cubic import MonotoneCubic, Tabulated
from ncf_fenicsx.parameters.kinds import impossible, parameter
from ncf_fenicsx.parameters.units import Curvature, LineMoment, PositiveLength, PositiveStress

ALIKE = 0.02
"""Relative difference of two thicknesses that is none."""
LEAST_CURVATURE = 1e-6
"""Curvature in 1/m that sizes are rounded off with: they have no derivative where they vanish."""


class BendingLaw(Law):
    """Bending of a layer apart from its membrane: the fibres act at its mid-plane, and this law on what varies."""

    family = "bending"

    def check(self, conditions: Conditions) -> None:
        """Raise where a layer has several elements through it."""
        most = max(conditions.elements_through)
        if most > 1:
            raise impossible("stack.through", most, "expected 1 with laws.bending, taken at mid-plane")

    @abstractmethod
    def stiffness_per_width(self, thickness: float) -> float:
        """Moment per width over curvature in N m of a layer at rest, of a thickness in m."""

    def moments(self, kinematics: Kinematics) -> Expression | None:
        """Moments per width in N, shape (2, 2); None of a law whose stress varies across the layer instead."""
        del kinematics
        return None


class MidPlane(BendingLaw, HyperelasticInPlaneLaw):
    """A neo-Hookean sheet with a bending modulus; the fibres' own stress is that at the mid-plane.

    A layer's yarns slide past each other as it bends, so its bending stiffness is far below that of a solid sheet of
    the fibres' modulus: per width it is modulus t^3 / (12 (1 - poisson^2)) here, whatever the fibres' law and strain.
    Its work over the volume is counted less that at the mid-plane, so that a uniform strain meets the fibres alone.
    """

    kind = "mid_plane"
    modulus: PositiveStress = parameter("0.1 GPa", description="modulus in bending (not in the paper)")
    poisson: float = parameter(0.2, gt=-1, lt=1, description="Poisson's ratio in bending (not in the paper)")

    def check(self, conditions: Conditions) -> None:
        """Raise where a layer has several elements through it, or is stiffer in bending than in its plane."""
        super().check(conditions)
        stiffest = conditions.fibre_modulus
        if self.modulus > stiffest:
            raise impossible("laws.bending.modulus", self.modulus, f"expected at most the fibres' {stiffest:g} Pa")

    def energy(self, in_plane_cauchy_green: Expression) -> Expression:
        """W in J/m3."""
        return plane_stress_energy(in_plane_cauchy_green, self.modulus, self.poisson)

    def stiffness_per_width(self, thickness: float) -> float:
        """Modulus t^3 / (12 (1 - poisson^2)) in N m."""
        return self.modulus * thickness**3 / (12 * (1 - self.poisson**2))

    @property
    def stiffness(self) -> Expression:
        """Bending modulus in Pa."""
        return self.modulus


class MomentTable(Tabulated, BendingLaw):
    """Energy per area of the principal curvatures, each the integral of a measured table of moment over curvature.

    The curvature is that of the fibres' plane as the material across it turns, kappa_ab = sym(F_a . d F_3/dX_b) /
    lambda_3, positive where the upper face is stretched. Both principal curvatures have the same table and do not act
    on each other (Poisson's ratio 0), so that the moment is the same about any axis. The table is monotone and
    continuously differentiable, straight beyond its ends.

    A table of positive curvatures alone is that of both directions, and its stiffness at rest is that to the first
    entry. One with negative entries too is that of a sheet that bends otherwise downwards than upwards.
    """

    kind = "table"
    columns = ("curvature", "moment")
    curvature: tuple[Curvature, ...] = parameter(
        ("1 1/m", "2 1/m", "2.29 1/m", "5 1/m", "10 1/m", "15 1/m", "20 1/m"),
        min_length=1,
        description="curvatures, ascending; all positive, or of both signs",
    )
    moment: tuple[LineMoment, ...] = parameter(
        ("0.1192 N", "0.2384 N", "0.2735 N", "0.321 N", "0.349 N", "0.366 N", "0.383 N"),
        min_length=1,
        description="moment per width at each, ascending (Broberg et al. 2024: one ply of 1.0 mm)",
    )
    thickness: PositiveLength | None = parameter(
        None, description="of the layer that was measured; not known unless given"
    )

    @model_validator(mode="after")
    def _signs_agree(self) -> Self:
        for curvature, moment in zip(self.curvature, self.moment, strict=True):
            if curvature * moment <= 0:
                expected = "expected curvatures and moments of the same sign; no curvature has no moment"
                raise impossible("moment", list(self.moment), expected)
        if self.curvature[-1] < 0:
            raise impossible("curvature", list(self.curvature), "expected positive ones, or of both signs")
        return self

    def caution(self, conditions: Conditions) -> str | None:
        """A table holds for layers as thick as the one that was measured."""
        measured, here = self.thickness, conditions.layer_thickness
        if measured is None or abs(here / measured - 1) < ALIKE:
            return None
        ratio = here / measured
        factors = f"{ratio:.3g} (plies that slide) to {ratio**3:.3g} (a solid sheet)"
        return (
            f"the moments are those of a layer of {1e3 * measured:.4g} mm, and layers of {1e3 * here:.4g} mm have them "
            f"times {factors}"
        )

    @property
    def _symmetric(self) -> bool:
        return self.curvature[0] > 0

    @property
    def _curve(self) -> MonotoneCubic:
        if self._symmetric:
            return MonotoneCubic.from_origin(self.curvature, self.moment)
        split = sum(value < 0 for value in self.curvature)
        curvature = (*self.curvature[:split], 0.0, *self.curvature[split:])
        return MonotoneCubic.through(curvature, (*self.moment[:split], 0.0, *self.moment[split:]))

    def stiffness_per_width(self, thickness: float) -> float:
        """Slope of the table to its first positive curvature in N m, whatever the thickness."""
        del thickness
        first = sum(value < 0 for value in self.curvature)
        return self.moment[first] / self.curvature[first]

    def moment_at(self, curvature: Expression) -> Expression:
        """Moment per width in N at positive curvatures (1/m)."""
        return self._curve(curvature)

    def energy_per_area(self, curvature: Expression) -> Expression:
        """Energy in J/m2.

        Args:
            curvature: kappa in 1/m, shape (2, 2), symmetric.
        """
        mean, half = (curvature[0, 0] + curvature[1, 1]) / 2, (curvature[0, 0] - curvature[1, 1]) / 2
        radius = _root(half**2 + curvature[0, 1] * curvature[1, 0])
        return self._work(mean + radius) + self._work(mean - radius)

    def moments(self, kinematics: Kinematics) -> Expression:
        """Moments per width in N, shape (2, 2); their virtual work per area is moments : variation(kappa)."""
        curvature = ufl.variable(kinematics.curvature)
        return ufl.diff(self.energy_per_area(curvature), curvature)

    def _work(self, curvature: Expression) -> Expression:
        """Integral of the moment from 0 to a curvature, in J/m2."""
        curve = self._curve
        if self._symmetric:
            return curve.integral(_root(curvature**2))
        return curve.integral(curvature) - curve.integral(0.0)


def _root(square: Expression) -> Expression:
    """Square root with a derivative at 0."""
    return (square + LEAST_CURVATURE**2) ** 0.5
