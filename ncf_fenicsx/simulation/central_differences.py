"""Central differences: the same forces as in equilibrium, and the inertia of lumped masses, step by step."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
import ufl
from dolfinx import fem
from numpy.typing import NDArray

from ncf_fenicsx.mechanics.problem import Problem
from ncf_fenicsx.mechanics.time_step import USUAL, Effort, Outcome, move_tools
from ncf_fenicsx.mesh import compat
from ncf_fenicsx.scene.settings import Explicit
from ncf_fenicsx.simulation.stable_step import StableStep
from ncf_fenicsx.solver import Residual

Floats = NDArray[np.float64]

LISTENING = 100
"""Steps after which the march looks whether it should end."""


class CentralDifferences:
    """Marches a problem in the time of its scene.

    Tools that move f times faster than in the scene, over laws that keep the scene's time, are tools at the scene's
    speed on a fabric f^2 times as heavy: inertia sees speed by its square alone. So one clock will do, and the density
    takes both scalings.

    Args:
        problem: what is marched; damping adds a term to it.
        settings: scaling, damping, and share of the stable step.
        interrupted: in words, why to end at once, on all ranks; None to go on.

    Attributes:
        density: scaled, in kg/m3.
        steps: central differences so far.
    """

    def __init__(
        self, problem: Problem, settings: Explicit, interrupted: Callable[[], str | None] = lambda: None
    ) -> None:
        self.problem, self.settings, self._interrupted = problem, settings, interrupted
        stack = problem.scene.stack
        self.density = stack.areal_density / stack.thickness * settings.mass_scaling * settings.time_scaling**2
        masses = self._lumped_masses()
        self._mass: Floats = np.repeat(masses[: problem.contacts.body.spaces.owned], 3)
        self._velocity = fem.Function(problem.space)
        self._free = np.ones(len(self._mass))
        self._free[problem.supports.dofs[problem.supports.dofs < len(self._mass)]] = 0.0
        self.stable = StableStep(problem, self.density, masses)
        wave_speed = math.sqrt(problem.scene.natural_stiffness * stack.thickness / self.density)
        self.lowest_frequency = 0.5 * math.pi * wave_speed / (stack.thickness * stack.layers)
        self._decay = 2 * settings.damping * self.lowest_frequency
        if settings.bulk_viscosity:
            problem.add_term("bulk_viscosity", self._bulk_viscosity(wave_speed))
        self._residual = Residual(problem)
        self._damped, self.steps = 0.0, 0
        self.forces: Floats = self._residual.values()

    def _lumped_masses(self) -> Floats:
        """Of this rank's local nodes in kg, ghosts included."""
        problem = self.problem
        ones = fem.Constant(problem.mesh, np.ones(3))
        weight = problem.constants(self.density) * ufl.inner(ones, problem.variation) * problem.volumes.all
        spaces, field = problem.contacts.body.spaces, problem.contacts.body.spaces.scalar()
        field.x.array[: spaces.owned] = spaces.forces(compat.compile_form(weight))[:, 0]
        field.x.scatter_forward()
        masses: Floats = field.x.array.copy()
        return masses

    def _bulk_viscosity(self, wave_speed: float) -> ufl.Form:
        """Virtual work (J) of a pressure b rho c h (dJ/dt)/J against changes of volume.

        After von Neumann and Richtmyer (1950). The wave is that across the layers: with the one along the fibres, a
        million times stiffer, the damping would outweigh the fabric's own pressure.
        """
        problem, stack = self.problem, self.problem.scene.stack
        height = stack.thickness / max(stack.elements_through)
        coefficient = problem.constants(self.settings.bulk_viscosity * self.density * wave_speed * height)
        volume_ratio = problem.material.kinematics(problem.displacement).volume_ratio
        rate = ufl.derivative(volume_ratio, problem.displacement, self._velocity)
        change = ufl.derivative(volume_ratio, problem.displacement, problem.variation)
        return coefficient * rate / volume_ratio * change * problem.volumes.all

    @property
    def kinetic_energy(self) -> float:
        """Of the modelled part in J, on all ranks."""
        speeds = self._velocity.x.array[: len(self._mass)]
        return float(self.problem.comm.allreduce(0.5 * self._mass @ speeds**2))

    @property
    def damped(self) -> float:
        """Energy that the damping of all motion has taken, of the modelled part in J, on all ranks."""
        return float(self.problem.comm.allreduce(self._damped))

    def largest_step(self) -> float:
        """Step in s that the settings allow at the present displacement, with the damping that they ask for."""
        share = self.settings.bulk_viscosity + self.settings.damping
        damped = math.sqrt(1 + share**2) - share
        return self.settings.safety * damped * 2 / self.stable.update()

    def solve(self, start: float, size: float, effort: Effort = USUAL) -> Outcome:
        """March from a committed state at a time by a size (s); the trial state is that at its end."""
        del effort
        before, trouble = self.steps, self._march(start, size)
        return Outcome(trouble is None, self.steps - before, trouble or "end of the row reached")

    def _march(self, start: float, size: float) -> str | None:
        """The march; None, or in words why it ended on the way."""
        problem = self.problem
        count = math.ceil(size / self.largest_step())
        step = size / count
        with np.errstate(over="ignore", invalid="ignore"):
            for number in range(1, count + 1):
                self._accelerate(step)
                problem.displacement.x.array[:] += step * self._velocity.x.array
                move_tools(problem, start, number * step)
                self.forces = self._residual.values()
                self.steps += 1
                reason = self._trouble() if number % LISTENING == 0 or number == count else None
                if reason is not None:
                    return reason
        return None

    def _trouble(self) -> str | None:
        """In words, why to end."""
        if not math.isfinite(self.kinetic_energy):
            return "velocities grow without bound: expected a lower explicit.safety"
        return self._interrupted()

    def _accelerate(self, step: float) -> None:
        """Velocity half a step after the present displacement."""
        owned = self._velocity.x.array[: len(self._mass)]
        before = owned.copy()
        owned *= 1 - 0.5 * self._decay * step
        owned -= step * self._free * self.forces / self._mass
        owned /= 1 + 0.5 * self._decay * step
        self._damped += step * self._decay * float(self._mass @ (0.5 * (before + owned)) ** 2)
        self._velocity.x.scatter_forward()
