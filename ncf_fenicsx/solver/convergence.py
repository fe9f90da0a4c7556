"""Whether Newton's method has converged, goes back and forth, or should be given up."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
from mpi4py import MPI
from numpy.typing import NDArray

from ncf_fenicsx.mechanics.time_step import USUAL, Effort
from ncf_fenicsx.mesh.hexahedra import point_in_words
from ncf_fenicsx.scene.settings import Solver as Settings
from ncf_fenicsx.solver.equations import System

Floats = NDArray[np.float64]

FLOOR_INCREMENT = 1e-3
CARRIED_FLOOR = 0.1
"""Excess of force on a tool, over the forces that round-off leaves, that is taken for none: ten times what is seen."""
RUNAWAY = 4.0
"""Factor over the first increment from which on an increment shows that the step is too large.

The first is the one after layers were last caught: that they hold on to each other hinders what has to move.
"""
RUNAWAY_FROM = 0.005
"""Increment over the length that is no sign of that yet."""
SEEN, LATEST = 6, 3
"""A solve wanders if, after so many corrections or more, none of the latest ones is smaller than all before them."""
UNCHANGED = 2
"""Iterations in a row that leave contact as it is, from which on the last two corrections were made in the same one.

That holds for the first one, too, which is made in the contact of the step before: it has not changed since.
"""
CYCLES = 0.5
"""Share of the increment two iterations ago that one above, in the same contact, is taken for a cycle."""
FALLS, OVER, LONGER = 0.1, 4, 2
"""Share of the increment so many iterations ago that the last one is where corrections that were shortened have ended
their search of what sticks: they converge now, and may go on for this multiple of the iterations; but not where a
shorter step is to be tried soon."""


class Convergence:
    """Follows the iterations of one solve after another.

    Args:
        system: what is solved.
        settings: tolerances and limits.

    Attributes:
        converged: whether forces balance and the increments have died away.
        polished: corrections, one or none, of a state that had balanced already.
        given_up: in words, why to give up; empty while there is hope.
        cycling: whether contact is where it was two iterations ago, and not where it was between.
        wandered: whether it is given up because corrections did not get smaller.
    """

    def __init__(self, system: System, settings: Settings) -> None:
        self.system, self.settings = system, settings
        self.comm: MPI.Comm = system.displacement.function_space.mesh.comm
        self.begin(USUAL)

    def begin(self, effort: Effort) -> None:
        """Forget the solve before; the next one may take an effort."""
        self._tolerance = min(self.settings.force_tolerance, effort.force_tolerance)
        self.converged, self.given_up, self.cycling, self.wandered = False, "", False, False
        self._patience, self._increments, self._first = effort.patience, [0.0], 1
        self._may_wander, self._must_shrink = effort.may_wander, effort.must_shrink
        self._unchanged = 0
        self._polishes, self._balanced, self.polished = effort.polishes, False, 0
        self._touching: list[NDArray[np.bool_]] = [self.system.contacts.touching()]

    def start(self, residual: float, load: float) -> None:
        """Judge the start of a solve: nothing is to be done where no more than round-off (N) is out of balance."""
        balanced = residual <= min(self.system.scales.force_floor, self._tolerance * load) and self._carried
        self.converged = balanced and not self.system.contacts.holding

    def follow(self, iteration: int, residual: float, load: float, update: Floats) -> None:
        """Judge an iteration.

        Args:
            iteration: its number, from 1.
            residual: norm of the forces that are out of balance in N.
            load: forces that carry the body in N.
            update: the last increment in m, of this rank's owned dofs.
        """
        increment = float(self.comm.allreduce(np.abs(update).max(initial=0.0), MPI.MAX))
        self._increments.append(increment)
        balanced = self._small(residual, load) and not self.system.contacts.holding
        self.converged = balanced and (self._balanced or not self._polishes)
        self._balanced, self.polished = balanced, int(self.converged and self._polishes)
        self._first = iteration + 1 if self.system.contacts.holding_layers else self._first
        self._note_contact()
        self.given_up = "" if balanced else self._no_progress(iteration, update)

    def _note_contact(self) -> None:
        touching, before = self.system.contacts.touching(), self._touching[-2:]
        self._touching = [*before, touching]
        alike = self.comm.allgather([np.array_equal(touching, earlier) for earlier in before])
        *ago, still = (all(ranks) for ranks in zip(*alike, strict=True))
        self._unchanged = self._unchanged + 1 if still else 0
        back = any(ago) and not still
        self.cycling = back and self._increments[-1] > CYCLES * self._increments[-3]

    def _no_progress(self, iteration: int, update: Floats) -> str:
        """In words, why to give up after an iteration; empty to go on."""
        first = max([RUNAWAY_FROM * self.system.scales.length, *self._increments[self._first : self._first + 1]])
        if self._first <= iteration and self._increments[-1] > RUNAWAY * max(self._patience, 1.0) * first:
            return "Newton's increments grow"
        self.wandered = self._wanders
        if self.wandered:
            return "Newton's corrections do not get smaller"
        most = round(self._patience * self.settings.max_iterations)
        if iteration < most or (iteration < LONGER * most and self._falls and self._patience >= 1):
            return ""
        if self.cycling:
            return f"contact opens and closes in turns, most at {self.position_of_largest(update)}"
        return f"Newton's method did not converge in {iteration} iterations"

    @property
    def _wanders(self) -> bool:
        """Whether small corrections do not get smaller, as where the tangent is nearly singular.

        Near a solution each is far smaller than the one before. Where the stack is about to lose stability they are
        not: they are short, and lead from one state that nearly balances to another, on whichever branch. Large ones
        may be a search for what is in contact.
        """
        if self._must_shrink and self._grows:
            return True
        sizes = self._increments[self._first :]
        if self._may_wander or len(sizes) < SEEN or not (self._must_shrink or self._is_small):
            return False
        latest = sizes[-LATEST:]
        falls = all(after < before for before, after in pairwise(latest))
        return min(latest) > min(sizes[:-LATEST]) and not falls

    @property
    def _grows(self) -> bool:
        """Whether the last correction is small, and larger than the one before it in the same contact."""
        sizes = self._increments[self._first :]
        alike = self._unchanged >= UNCHANGED and len(sizes) > 1
        return alike and self._is_small and sizes[-2] < sizes[-1]

    @property
    def _is_small(self) -> bool:
        """Whether the last correction is one of a search near a solution, and more than round-off."""
        return FLOOR_INCREMENT * self._allowed < self._increments[-1] < RUNAWAY_FROM * self.system.scales.length

    @property
    def _falls(self) -> bool:
        """Whether corrections that are shortened where they do too much work converge now."""
        enough = self.settings.searches and len(self._increments) > OVER
        return enough and self._increments[-1] <= FALLS * self._increments[-1 - OVER]

    @property
    def _allowed(self) -> float:
        """Increment in m that is small."""
        return self.settings.increment_tolerance * self.system.scales.length

    @property
    def nearly(self) -> bool:
        """Whether the next increment would be small, should they go on to die away as the last one did."""
        if len(self._increments) < 2:
            return False
        before, last = self._increments[-2:]
        return last * (min(last / before, 1.0) if before else 1.0) <= self._allowed

    @property
    def _carried(self) -> bool:
        """Whether tools under control carry their forces, as far as round-off lets them."""
        wanted = [(control, control.target) for control in self.system.contacts.controls]
        least = CARRIED_FLOOR * self.system.scales.force_floor
        return all(
            abs(control.excess()) <= max(self._tolerance * target, least)
            for control, target in wanted
            if target is not None
        )

    def _small(self, residual: float, load: float) -> bool:
        """Whether forces balance, those under control included, and the next increment would be small.

        Where round-off alone is above the force tolerance, the increment has to be smaller by as much as it takes for
        the next one, with quadratic convergence, to vanish in round-off too.
        """
        if residual <= self._tolerance * load:
            return self.nearly and self._carried
        small = residual <= self.system.scales.force_floor and self._increments[-1] <= FLOOR_INCREMENT * self._allowed
        return small and self._carried

    def position_of_largest(self, values: Floats) -> str:
        """Undeformed position, in words, of the node with the largest of some values at this rank's owned dofs."""
        largest = np.abs(values.reshape(-1, 3)).max(axis=1)
        found = (0.0, [0.0, 0.0, 0.0])
        if len(largest):
            node = int(largest.argmax())
            points = self.system.displacement.function_space.tabulate_dof_coordinates()
            found = (float(largest[node]), points[node].tolist())
        return point_in_words(np.array(max(self.comm.allgather(found))[1]))
