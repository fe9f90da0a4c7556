"""Every strain and stretch of a thin layer, once, in pure UFL.

The layer's fibres lie in the reference plane (1, 2); direction 3 is its thickness.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import ufl

Expression = Any  # UFL ships no types


@dataclass(frozen=True)
class Kinematics:
    """Strains of a displacement field.

    Args:
        deformation_gradient: F, shape (3, 3).
        initial_volume_fraction: fibre volume fraction Vf0 of the undeformed layer, if it has fibres.
        measure: what Vf follows, "thickness" (lambda_3) or "volume" (J).
    """

    deformation_gradient: Expression
    initial_volume_fraction: Expression = None
    measure: str = "thickness"

    @cached_property
    def right_cauchy_green(self) -> Expression:
        """C = F^T F, shape (3, 3)."""
        F = self.deformation_gradient
        return F.T * F

    @cached_property
    def in_plane_cauchy_green(self) -> Expression:
        """C_s, the 2x2 block of C in the plane of the fibres."""
        return in_plane(self.right_cauchy_green)

    @cached_property
    def transverse_shear(self) -> Expression:
        """(C_13, C_23): twice the Green-Lagrange shear strains between fibres and thickness."""
        C = self.right_cauchy_green
        return ufl.as_vector([C[0, 2], C[1, 2]])

    @cached_property
    def area_vector(self) -> Expression:
        """cof(F) N with N = (0, 0, 1): current normal of the layer times its area stretch J_s."""
        F = self.deformation_gradient
        return ufl.cross(F[:, 0], F[:, 1])

    @cached_property
    def area_stretch(self) -> Expression:
        """J_s = sqrt(det C_s)."""
        return ufl.sqrt(ufl.dot(self.area_vector, self.area_vector))

    @cached_property
    def thickness_stretch(self) -> Expression:
        """lambda_3 = J / J_s = n . F N: distance of the layer's faces over its reference thickness."""
        return self.volume_ratio / self.area_stretch

    @cached_property
    def curvature(self) -> Expression:
        """kappa_ab = sym(F_a . dF_b/dX_3) / lambda_3 in 1/m, shape (2, 2), positive where the upper face is stretched.

        dF_b/dX_3 is the slope along b of the vector across the layer: where it stays normal and the plane is not
        stretched, this is the curvature of the plane, whatever the thickness.
        """
        F = self.deformation_gradient
        across = ufl.grad(F)[:, :, 2]
        return in_plane(ufl.sym(F.T * across)) / self.thickness_stretch

    @cached_property
    def volume_ratio(self) -> Expression:
        """J = det F."""
        return ufl.dot(self.area_vector, self.deformation_gradient[:, 2])

    @cached_property
    def volume_fraction(self) -> Expression:
        """Vf0 / lambda_3 (paper, Eq. 5, with eps = -ln lambda_3), or Vf0 / J, which conserves the fibres' volume."""
        return self.initial_volume_fraction / (
            self.volume_ratio if self.measure == "volume" else self.thickness_stretch
        )

    def sheared_along(self, direction: Expression) -> ShearedOneWay:
        """The same, with the part of the transverse shear along a unit vector in the plane of the fibres alone."""
        return ShearedOneWay(self.deformation_gradient, self.initial_volume_fraction, self.measure, direction)

    def extrapolated_from(self, start: Expression) -> ExtrapolatedKinematics:
        """The same as the linear model at another state, with a deformation gradient ``start``, predicts them."""
        return ExtrapolatedKinematics(self.deformation_gradient, self.initial_volume_fraction, self.measure, start)


@dataclass(frozen=True)
class ShearedOneWay(Kinematics):
    """Strains whose transverse shear is the part along one direction in the plane of the fibres.

    Args:
        direction: unit vector, shape (2,).
    """

    direction: Expression = None

    @cached_property
    def transverse_shear(self) -> Expression:
        """The part of (C_13, C_23) along the direction."""
        return ufl.dot(super().transverse_shear, self.direction) * self.direction


@dataclass(frozen=True)
class ExtrapolatedKinematics(Kinematics):
    """Strains whose C is the one that the linear model at another state predicts for this one.

    Args:
        start: deformation gradient of that state; C = F^T F - (F - F_start)^T (F - F_start).
    """

    start: Expression = None

    @cached_property
    def right_cauchy_green(self) -> Expression:
        """C of ``start`` plus its first-order change."""
        F = self.deformation_gradient
        change = F - self.start
        return F.T * F - change.T * change


def deformation_gradient(displacement: Expression, shift: Expression = None) -> Expression:
    """F = I + grad u, or its value a shift in m away, to first order: F + grad F . shift."""
    F = ufl.Identity(3) + ufl.grad(displacement)
    return F if shift is None else F + ufl.dot(ufl.grad(ufl.grad(displacement)), shift)


def in_plane(tensor: Expression) -> Expression:
    """The 2x2 block of a tensor in the plane of the fibres."""
    return ufl.as_matrix([[tensor[0, 0], tensor[0, 1]], [tensor[1, 0], tensor[1, 1]]])
