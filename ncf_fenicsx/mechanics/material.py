"""What a material owes the equation that is solved: virtual work, stress, states. Pure UFL."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import ufl
from numpy.typing import NDArray

from ncf_fenicsx.laws.kinematics import Expression, Kinematics, deformation_gradient
from ncf_fenicsx.mechanics.form_constants import FormConstants
from ncf_fenicsx.mesh import compat
from ncf_fenicsx.mesh.elements import Element

Floats = NDArray[np.float64]


FOREVER = 1e30
"""Time in s that a stack at rest has had: all that relaxes has relaxed."""


class Clock:
    """Constants of what a time step tells the laws; at rest when made.

    Args:
        constants: makes constants.

    Attributes:
        time_step: size of the step in s; the stack takes for ever to settle.
        inverse_time_step: its inverse in 1/s, 0 then.
        process_speed: speed at which the tool moves down in m/s, negative upwards.
    """

    def __init__(self, constants: FormConstants) -> None:
        self.time_step, self.inverse_time_step, self.process_speed = (constants(0.0) for _ in range(3))
        self.set(0.0, 0.0)

    def set(self, size: float, process_speed: float) -> None:
        """Take the size of a step (s), 0 at rest, and how fast the tools move down in it (m/s)."""
        self.time_step.value = size or FOREVER
        self.inverse_time_step.value = 1 / size if size else 0.0
        self.process_speed.value = process_speed


@dataclass(frozen=True)
class Volumes:
    """Measures of the reference volume.

    Attributes:
        all: over the whole volume.
        mid_plane: over the mid-planes of the elements, each standing for its element's thickness.
        reduced_mid_plane: the same by so few points that neither a change of volume nor a stiff membrane locks there.
        shear: over the whole volume, for transverse shear along each axis of an element in its plane: so that none
            locks in bending.
        axes: directions of those axes in the plane, unit vectors of shape (2,), square to each other.
    """

    all: Any
    mid_plane: Any
    reduced_mid_plane: Any
    shear: tuple[Any, Any]
    axes: tuple[Expression, Expression]

    @classmethod
    def on(cls, mesh: Any, element: Element) -> Volumes:
        """Those of a DOLFINx mesh; the third axis of an element is that of its thickness."""

        def measure(points: Floats, weights: Floats) -> Any:
            return ufl.Measure("dx", domain=mesh, metadata=compat.rule_metadata(points, weights, 2 * element.order))

        shear = measure(*element.shear_rule(0)), measure(*element.shear_rule(1))
        J = ufl.Jacobian(mesh)
        edge = ufl.as_vector([J[0, 0], J[1, 0]])
        first = edge / ufl.sqrt(ufl.dot(edge, edge))
        return cls(
            all=measure(*element.volume_rule),
            mid_plane=measure(*element.mid_plane_rule),
            reduced_mid_plane=measure(*element.reduced_mid_plane_rule),
            shear=shear,
            axes=(first, ufl.perp(first)),
        )


class Material(ABC):
    """The laws of a scene with constants for their parameters."""

    @abstractmethod
    def kinematics(self, displacement: Any) -> Kinematics:
        """Strains of a displacement field."""

    @abstractmethod
    def internal_work(self, displacement: Any, variation: Any, volumes: Volumes) -> ufl.Form:
        """Virtual work (J) of all stresses."""

    @abstractmethod
    def normal_stress(self, kinematics: Kinematics) -> Expression:
        """Cauchy stress across the layer, n . sigma n, in Pa, negative in compaction."""

    def normal_stress_integral(self, kinematics: Kinematics, weight: Expression, volumes: Volumes) -> ufl.Form:
        """Integral (N m) of the normal stress times a weight, where the stresses do their work."""
        return self.normal_stress(kinematics) * weight * volumes.all

    def updated_states(self, displacement: Any) -> dict[str, Expression]:
        """States at the end of a step, by name."""
        del displacement
        return {}


class Solid(Material):
    """An isotropic elastic solid.

    Args:
        law: its energy.
        shift: vector in m to where strains are taken, from where they are asked for; None for there.
    """

    def __init__(self, law: Any, shift: Expression = None) -> None:
        self.law, self._shift = law, shift

    def kinematics(self, displacement: Any) -> Kinematics:
        """Strains of a displacement field; a solid has no fibres."""
        return Kinematics(deformation_gradient(displacement, self._shift))

    def internal_work(self, displacement: Any, variation: Any, volumes: Volumes) -> ufl.Form:
        """Variation of the energy (J): of the change of shape, and of that of volume."""
        kinematics, dilatation = self.kinematics(displacement), self._dilatation(volumes)
        shape = self.law.shape_energy(kinematics) * volumes.all
        volume = self.law.volume_energy(kinematics.volume_ratio) * dilatation
        return ufl.derivative(shape + volume, displacement, variation)

    def _dilatation(self, volumes: Volumes) -> Any:
        """Measure of the energy of a change of volume."""
        return volumes.all if self.law.volume_integration == "full" else volumes.reduced_mid_plane

    def normal_stress(self, kinematics: Kinematics) -> Expression:
        """That of the energy in Pa, at one point: near incompressibility it swings within an element."""
        return normal_stress_of(self.law.energy, kinematics)

    def normal_stress_integral(self, kinematics: Kinematics, weight: Expression, volumes: Volumes) -> ufl.Form:
        """Integral (N m) of the normal stress times a weight: of shape, and of volume, the same in all directions."""
        shape = normal_stress_of(self.law.shape_energy, kinematics)
        volume_ratio = ufl.variable(kinematics.volume_ratio)
        volume = ufl.diff(self.law.volume_energy(volume_ratio), volume_ratio)
        return shape * weight * volumes.all + volume * weight * self._dilatation(volumes)


def normal_stress_of(energy: Callable[[Kinematics], Expression], kinematics: Kinematics) -> Expression:
    """Cauchy stress n . sigma n in Pa of an energy: (dW/dF N) . n / J_s, by Nanson's n J_s = J F^-T N."""
    F = ufl.variable(kinematics.deformation_gradient)
    strained = replace(kinematics, deformation_gradient=F)
    first_piola_kirchhoff = ufl.diff(energy(strained), F)
    return ufl.dot(first_piola_kirchhoff[:, 2], strained.area_vector) / strained.area_stretch**2
