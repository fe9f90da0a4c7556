"""The fabric: its laws of fibres, compaction and shear at work together. Pure UFL."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from typing import Any

import ufl

from ncf_fenicsx.laws.in_plane import InPlaneLaw
from ncf_fenicsx.laws.kinematics import Expression, Kinematics, deformation_gradient, in_plane
from ncf_fenicsx.laws.law import CompactionStep
from ncf_fenicsx.mechanics.material import Clock, Material, Volumes, normal_stress_of
from ncf_fenicsx.scene.laws import Laws

LEAST_MEMBRANE = 1e-4
"""Share of the membrane at all points where it is looked at by few: with none, some motions in the plane are free."""


@dataclass(frozen=True)
class Fabric(Material):
    """The laws of a layer of fabric.

    Attributes:
        laws: with constants for their parameters.
        initial_volume_fraction: Vf0.
        thickness: of a layer in m.
        clock: what a step tells the laws.
        states: fields of the states at the start of a step, by name; Vf is always among them.
        shift: vector in m to where strains are taken, from where they are asked for; None for there.
    """

    laws: Laws
    initial_volume_fraction: Expression
    thickness: Expression
    clock: Clock
    states: dict[str, Any] = field(default_factory=dict)
    shift: Expression = None

    def kinematics(self, displacement: Any) -> Kinematics:
        """Strains of a displacement field."""
        F = deformation_gradient(displacement, self.shift)
        return Kinematics(F, self.initial_volume_fraction, self.laws.volume_fraction)

    def compaction_step(self, kinematics: Kinematics) -> CompactionStep:
        """What the laws of compaction are told."""
        vf0 = self.initial_volume_fraction
        return CompactionStep(
            volume_fraction=kinematics.volume_fraction,
            old_volume_fraction=self.states["volume_fraction"],
            initial_volume_fraction=vf0,
            time_step=self.clock.time_step,
            inverse_time_step=self.clock.inverse_time_step,
            process_speed=self.clock.process_speed,
            loading=lambda vf: self.laws.compaction.pressure(vf, vf0),
        )

    def pressure(self, kinematics: Kinematics) -> Expression:
        """Compaction pressure in Pa, per reference area: rate factor times slow pressure, plus what relaxes."""
        return self._pressure(self.compaction_step(kinematics), self.states)

    def _pressure(self, step: CompactionStep, states: dict[str, Expression]) -> Expression:
        laws, unloading, relaxation = self.laws, self.laws.unloading, self.laws.relaxation
        slow = step.loading(step.volume_fraction) if unloading is None else unloading.pressure(step, states)
        pressure = laws.rate.apply(step, slow)
        return pressure if relaxation is None else pressure + relaxation.pressure(step, states)

    def pressure_in_halves(self, kinematics: Kinematics, middle: Expression) -> Expression:
        """The same pressure where the step is taken in two halves, with a Vf between them.

        Args:
            kinematics: strains at the end of the step.
            middle: Vf in the middle of the step.
        """
        whole = self.compaction_step(kinematics)
        half = {"time_step": whole.time_step / 2, "inverse_time_step": 2 * whole.inverse_time_step}
        first = replace(whole, volume_fraction=middle, **half)
        states = {"volume_fraction": middle}
        for law in self.laws.stateful:
            states |= law.updated_states(first, self.states)
        return self._pressure(replace(whole, old_volume_fraction=middle, **half), states)

    def normal_stress(self, kinematics: Kinematics) -> Expression:
        """Of the pressure per reference area, and of a shear energy that follows the thickness, in Pa."""
        shear = normal_stress_of(self.laws.shear.energy, kinematics)
        return shear - self.pressure(kinematics) / kinematics.area_stretch

    def updated_states(self, displacement: Any) -> dict[str, Expression]:
        """Vf and the states of the laws at the end of a step."""
        step = self.compaction_step(self.kinematics(displacement))
        states = {"volume_fraction": step.volume_fraction}
        for law in self.laws.stateful:
            states |= law.updated_states(step, self.states)
        return states

    def internal_work(self, displacement: Any, variation: Any, volumes: Volumes) -> ufl.Form:
        """Virtual work (J) of all stresses of the laws."""
        kinematics = self.kinematics(displacement)
        stretch_change = ufl.derivative(kinematics.thickness_stretch, displacement, variation)
        compaction = -self.pressure(kinematics) * stretch_change * volumes.all
        shear = ufl.derivative(self._shear_energy(kinematics, volumes), displacement, variation)
        change = in_plane(ufl.sym(kinematics.deformation_gradient.T * ufl.grad(variation)))
        work = self._fibres(lambda law: ufl.inner(law.stress(kinematics), change), volumes) + compaction + shear
        moments = None if self.laws.bending is None else self.laws.bending.moments(kinematics)
        if moments is not None:
            bent = ufl.derivative(kinematics.curvature, displacement, variation)
            work += ufl.inner(moments, bent) / self.thickness * volumes.mid_plane
        return work

    def extrapolated_tangent(
        self, displacement: Any, last_iterate: Any, variation: Any, increment: Any, volumes: Volumes
    ) -> ufl.Form:
        """What to add to the plain tangent so that its geometric part uses the extrapolated membrane stress.

        The fibres are about a million times stiffer than the fabric across its thickness. A full Newton step in the
        deflection w adds a membrane strain w'^2 / 2, of second order, whose spurious stress wrecks the next tangent.
        Taking the stress at the strain that the last step's linear model predicted removes it from the tangent; the
        residual, and so the solution, stay as they are. (Magisano, Leonetti, Garcea 2017, "mixed integration point".)
        """
        now, start = self.kinematics(displacement), deformation_gradient(last_iterate)
        predicted = now.extrapolated_from(start)
        second_change = in_plane(ufl.sym(ufl.grad(variation).T * ufl.grad(increment)))
        return self._fibres(lambda law: ufl.inner(law.stress(predicted) - law.stress(now), second_change), volumes)

    def _fibres(self, density: Callable[[InPlaneLaw], Expression], volumes: Volumes) -> ufl.Form:
        """Integral of a density of the in-plane laws: the fibres' own, and that of bending off the mid-plane.

        Of a layer that bends apart from its membrane, this is looked at by so few points that it does not lock.
        """
        fibres, bending = density(self.laws.in_plane), self.laws.bending
        if bending is None:
            return fibres * volumes.all
        varying = density(bending) if isinstance(bending, InPlaneLaw) else None
        membrane = fibres if varying is None else fibres - varying
        at_few = (1 - LEAST_MEMBRANE) * membrane * volumes.reduced_mid_plane
        form = LEAST_MEMBRANE * membrane * volumes.mid_plane + at_few
        return form if varying is None else form + varying * volumes.all

    def _shear_energy(self, kinematics: Kinematics, volumes: Volumes) -> ufl.Form:
        """Energy (J) of transverse shear.

        Layers that bend apart from their membrane are thin, and their elements would lock: where one bends along an
        axis, it is free of transverse shear along it only half-way (order 1) or at two points (order 2). So each part
        of the shear is looked at by the rule of its axis (Hughes and Tezduyar 1981), and what both parts have together,
        in laws where they do not add up, by either rule in equal shares.
        """
        energy = self.laws.shear.energy
        if self.laws.bending is None:
            return energy(kinematics) * volumes.all
        parts = [energy(kinematics.sheared_along(axis)) for axis in volumes.axes]
        both = energy(kinematics) - parts[0] - parts[1]
        forms = [(part + both / 2) * rule for part, rule in zip(parts, volumes.shear, strict=True)]
        return forms[0] + forms[1]
