"""The laws of a scene evaluated on a test: the same formulas as in a run, on arrays of numbers."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ncf_fenicsx.calibration.specimens import Compaction, Machine
from ncf_fenicsx.laws.compaction import CompactionLaw
from ncf_fenicsx.laws.law import CompactionStep, Law, StatefulLaw
from ncf_fenicsx.laws.rate import RateLaw

Floats = NDArray[np.float64]
Laws = dict[str, Law]
"""Laws by their family: compaction and rate, and relaxation or unloading where a test has something of them."""
FINE = 2000


class History:
    """The laws on one test.

    Args:
        laws: by family.
        test: whose motion they follow.
        machine: what of the travel is not the specimen's.

    Attributes:
        slow: pressure in Pa without effects of rate, at each row.
        factor: that of speed; not a number where the law has none.
        relaxing: pressure in Pa that relaxes, on top.
    """

    def __init__(self, laws: Laws, test: Compaction, machine: Machine) -> None:
        self.initial = test.initial_volume_fraction
        self.volume_fraction = test.volume_fraction(machine)
        compaction, rate = laws["compaction"], laws["rate"]
        assert isinstance(compaction, CompactionLaw)
        assert isinstance(rate, RateLaw)
        self.compaction, self._test = compaction, test
        durations = np.diff(test.time)
        self._duration = np.concatenate([durations[:1], durations])
        step = self._step(self.volume_fraction, self._duration, test.closing_speed(machine))
        speed = np.broadcast_to(rate.speed(step), self.volume_fraction.shape)
        factor = np.asarray(rate.factor(speed))
        factor = np.full_like(self.volume_fraction, np.nan) if np.iscomplexobj(factor) else factor
        self.factor = np.broadcast_to(factor, self.volume_fraction.shape)
        self.slow, self.relaxing = self._loading(self.volume_fraction), np.zeros_like(self.volume_fraction)
        stateful = [law for law in laws.values() if isinstance(law, StatefulLaw)]
        if stateful:
            self._march(stateful)

    @property
    def pressure(self) -> Floats:
        """In Pa: the factor acts on pressure alone, as in a run."""
        return np.asarray(np.where(self.slow > 0, self.factor, 1.0) * self.slow + self.relaxing, dtype=np.float64)

    def _loading(self, vf: Floats) -> Floats:
        return np.asarray(self.compaction.pressure(vf, self.initial))

    def _step(self, vf: Floats, duration: Floats, speed: Floats) -> CompactionStep:
        """A step that ends at a Vf with a closing speed."""
        stretch = self.initial / vf + speed * duration / self._test.initial_thickness
        return CompactionStep(vf, self.initial / stretch, self.initial, duration, 1 / duration, speed, self._loading)

    def _march(self, stateful: list[StatefulLaw]) -> None:
        """Row by row, with the states of the laws."""
        states = {name: value for law in stateful for name, value in law.initial_states(self.initial).items()}
        vf = self.volume_fraction
        before = self.initial
        for row, now in enumerate(vf):
            duration = self._duration[row]
            step = CompactionStep(now, before, self.initial, duration, 1 / duration, 0.0, self._loading)
            for law in stateful:
                target = self.slow if law.family == "unloading" else self.relaxing
                target[row] = law.pressure(step, states)
            states = {name: value for law in stateful for name, value in law.updated_states(step, states).items()}
            before = now

    def off_in_thickness(self, measured: Floats) -> Floats:
        """Thickness of the laws at the measured pressures over that of the test, less 1: what is to be zero.

        It is looked for on the curve of loading; where the laws unload, at the Vf that has the same pressure there.
        """
        return np.asarray(np.log(self._inverse(self.slow) / self._on_loading(measured)))

    def between(self, one: Floats, other: Floats) -> Floats:
        """The same between two pressures (Pa), each of the motion of the test."""
        return np.asarray(np.log(self._on_loading(one) / self._on_loading(other)))

    def _on_loading(self, pressure: Floats) -> Floats:
        """Vf at which slow loading alone has the part of a pressure that is neither of speed nor relaxing."""
        slow = pressure - self.relaxing
        return self._inverse(np.asarray(slow / np.where(slow > 0, self.factor, 1.0)))

    def _inverse(self, slow: Floats) -> Floats:
        """Vf of loading at pressures (Pa): from a grid, and a step of Newton's method."""
        limit = 0.999 * self.compaction.packing_limit
        highest = min(limit, 1.3 * float(self.volume_fraction.max()))
        grid: Floats = np.linspace(0.8 * self.initial, highest, FINE, dtype=np.float64)
        curve = np.maximum.accumulate(self._loading(grid))
        vf = np.interp(slow, curve, grid)
        slope = np.interp(vf, grid, np.gradient(curve, grid))
        inside = (slow > curve[0]) & (slow < curve[-1]) & (slope > 0)
        return np.asarray(np.where(inside, vf - (self._loading(vf) - slow) / np.where(inside, slope, 1.0), vf))
