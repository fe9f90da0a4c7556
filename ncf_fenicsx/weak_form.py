"""Virtual work of the laws, in pure UFL: each law's stress with the variation of its strain."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import ufl

from ncf_fenicsx.contracts import CompactionLaw, InPlaneLaw, ShearLaw
from ncf_fenicsx.kinematics import Expression, Kinematics, deformation_gradient, in_plane, linearised_cauchy_green


@dataclass(frozen=True)
class BoundLaws:
    """The laws of a scene with symbols for their parameters.

    Attributes:
        in_plane: fibre elasticity.
        compaction: pressure over fibre volume fraction.
        shear: transverse shear.
        rate_factor: dimensionless factor on the pressure.
        initial_volume_fraction: Vf0.
    """

    in_plane: InPlaneLaw
    compaction: CompactionLaw
    shear: ShearLaw
    rate_factor: Expression
    initial_volume_fraction: Expression

    def kinematics(self, displacement: Any) -> Kinematics:
        """Strains of a displacement field."""
        return Kinematics(deformation_gradient(displacement), self.initial_volume_fraction)

    def pressure(self, kinematics: Kinematics) -> Expression:
        """Compaction pressure in Pa, per reference area."""
        return self.rate_factor * self.compaction.pressure(kinematics.volume_fraction, self.initial_volume_fraction)

    def normal_stress(self, kinematics: Kinematics) -> Expression:
        """Cauchy stress across the layer in Pa, negative in compaction: n . sigma n = -pressure / J_s."""
        return -self.pressure(kinematics) / kinematics.area_stretch


def internal_work(laws: BoundLaws, displacement: Any, variation: Any, dx: Any) -> ufl.Form:
    """Virtual work (J) of all stresses of the laws."""
    kinematics = laws.kinematics(displacement)

    def change(strain: Expression) -> Expression:
        return ufl.derivative(strain, displacement, variation)

    fibres = ufl.inner(
        laws.in_plane.stress(kinematics.in_plane_cauchy_green), _in_plane_change(displacement, variation)
    )
    compaction = -laws.pressure(kinematics) * change(kinematics.thickness_stretch)
    shear = ufl.dot(laws.shear.stress(kinematics), change(kinematics.transverse_shear))
    return (fibres + compaction + shear) * dx


def extrapolated_membrane_tangent(
    laws: BoundLaws, displacement: Any, last_iterate: Any, variation: Any, increment: Any, dx: Any
) -> ufl.Form:
    """What to add to the plain tangent so that its geometric part uses the extrapolated membrane stress.

    The fibres are about a million times stiffer than the fabric across its thickness. A full Newton step in the
    deflection w adds a membrane strain w'^2 / 2, of second order, whose spurious stress wrecks the next tangent. Taking
    the stress at the strain that the last step's linear model predicted removes it from the tangent; the residual, and
    so the solution, stay as they are. (Magisano, Leonetti, Garcea 2017, "mixed integration point" Newton.)
    """
    F = deformation_gradient(displacement)
    predicted = in_plane(linearised_cauchy_green(F, deformation_gradient(last_iterate)))
    excess = laws.in_plane.stress(predicted) - laws.in_plane.stress(in_plane(F.T * F))
    second_change = ufl.sym(ufl.grad(variation).T * ufl.grad(increment))
    return ufl.inner(excess, in_plane(second_change)) * dx


def _in_plane_change(displacement: Any, variation: Any) -> Expression:
    """Variation of C_s / 2."""
    return in_plane(ufl.sym(deformation_gradient(displacement).T * ufl.grad(variation)))
