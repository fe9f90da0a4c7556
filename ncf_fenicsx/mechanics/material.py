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
from ncf_fenicsx.mesh.elements import Element

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Clock:
    """Constants of what a time step tells the laws.

    Attributes:
        time_step: size of the step in s; the stack takes for ever to settle.
        inverse_time_step: its inverse in 1/s, 0 then.
        process_speed: speed at which the tool moves down in m/s, negative upwards.
    """

    time_step: Expression
    inverse_time_step: Expression
    process_speed: Expression


@dataclass(frozen=True)
class Volumes:
    """Measures of the reference volume.

    Attributes:
        all: over the whole volume.
        mid_plane: over the mid-planes of the elements, each standing for its element's thickness.
    """

    all: Any
    mid_plane: Any

    @classmethod
    def on(cls, mesh: Any, element: Element) -> Volumes:
        """Those of a DOLFINx mesh; the third axis of an element is that of its thickness."""

        def measure(points: Floats, weights: Floats) -> Any:
            rule = {"quadrature_rule": "custom", "quadrature_points": points, "quadrature_weights": weights}
            return ufl.Measure("dx", domain=mesh, metadata={"quadrature_degree": 2 * element.order} | rule)

        return cls(all=measure(*element.volume_rule), mid_plane=measure(*element.mid_plane_rule))


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

    def updated_states(self, displacement: Any) -> dict[str, Expression]:
        """States at the end of a step, by name."""
        del displacement
        return {}


class Solid(Material):
    """An isotropic elastic solid.

    Args:
        law: its energy.
    """

    def __init__(self, law: Any) -> None:
        self.law = law

    def kinematics(self, displacement: Any) -> Kinematics:
        """Strains of a displacement field; a solid has no fibres."""
        return Kinematics(deformation_gradient(displacement))

    def internal_work(self, displacement: Any, variation: Any, volumes: Volumes) -> ufl.Form:
        """Variation of the energy (J)."""
        return ufl.derivative(self.law.energy(self.kinematics(displacement)) * volumes.all, displacement, variation)

    def normal_stress(self, kinematics: Kinematics) -> Expression:
        """That of the energy in Pa."""
        return normal_stress_of(self.law.energy, kinematics)


def normal_stress_of(energy: Callable[[Kinematics], Expression], kinematics: Kinematics) -> Expression:
    """Cauchy stress n . sigma n in Pa of an energy: (dW/dF N) . n / J_s, by Nanson's n J_s = J F^-T N."""
    F = ufl.variable(kinematics.deformation_gradient)
    strained = replace(kinematics, deformation_gradient=F)
    first_piola_kirchhoff = ufl.diff(energy(strained), F)
    return ufl.dot(first_piola_kirchhoff[:, 2], strained.area_vector) / strained.area_stretch**2
