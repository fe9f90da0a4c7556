"""What the levels that are done tell together: each quantity with its error bar, in numbers and in words."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import Self

from ncf_fenicsx.accuracy.cost import Cost
from ncf_fenicsx.accuracy.extrapolation import Basis, Estimate, estimate, of_differences
from ncf_fenicsx.accuracy.quantities import FIELD, QUANTITIES, measure
from ncf_fenicsx.report.reading import read_history, read_record
from ncf_fenicsx.report.reference_solution import VfField
from ncf_fenicsx.scene import Scene


@dataclass(frozen=True)
class Level:
    """A level that is done.

    Attributes:
        number: counted from 0.
        folder: with its results.
        cost: what it took.
        wall: the same with the compilation of forms, in s.
        values: of the quantities in SI, but of the field.
        lost: time in s at which the stack lost its stability; None if it never did.
    """

    number: int
    folder: Path
    cost: Cost
    wall: float
    values: dict[str, float]
    lost: float | None

    @classmethod
    def read(cls, number: int, folder: Path, quantities: tuple[str, ...]) -> Self:
        """A level from its folder."""
        record = read_record(folder)
        wall = cls.wall_before(folder)
        cost = Cost(record["unknowns"], max(wall - record["seconds"]["forms"], 1e-3), 1e6 * record["peak_memory_mb"])
        lost = record["loss_of_stability"]
        values = {name: measure(folder, name) for name in quantities if name != FIELD}
        return cls(number, folder, cost, wall, values, None if lost is None else lost["time"])

    @staticmethod
    def is_done(folder: Path) -> bool:
        """Whether a folder holds a run that reached the end of its path."""
        return (folder / "run.json").is_file() and read_record(folder)["ending"] == "done"

    @staticmethod
    def wall_before(folder: Path) -> float:
        """Wall time in s of what a folder holds so far."""
        history = folder / "history.csv"
        if not history.is_file():
            return 0.0
        times = read_history(history)
        return float(times["wall_time"][-1]) if times.dtype.names and len(times) else 0.0


@dataclass(frozen=True)
class Answer:
    """Levels, and what they tell.

    Attributes:
        quantities: whose error is bounded.
        tolerance: of the bars, over the size of each.
        levels: that are done, from the coarsest on.
        changes: of the field of Vf from each level to the next, a norm, and the last one's own change from rest.
    """

    quantities: tuple[str, ...]
    tolerance: float
    levels: tuple[Level, ...] = ()
    changes: tuple[float, ...] = ()
    size: float = 0.0

    def with_level(self, number: int, folder: Path, scene: Scene) -> Answer:
        """The answer with one more level, whose results are in a folder."""
        level = Level.read(number, folder, self.quantities)
        changes, size = self.changes, self.size
        if FIELD in self.quantities:
            rest, field = scene.stack.initial_volume_fraction, VfField(folder)
            size = field.change(rest)
            if self.levels:
                changes = (*changes, size * VfField(self.levels[-1].folder).off(field, rest))
        return replace(self, levels=(*self.levels, level), changes=changes, size=size)

    def until(self, number: int) -> Answer:
        """What the levels up to one told, counted from 0; the change of the field from rest is that of the last."""
        return replace(self, levels=self.levels[: number + 1], changes=self.changes[:number])

    @cached_property
    def estimates(self) -> dict[str, Estimate]:
        """Of each quantity, in SI; empty before the first level."""
        return {name: self._estimate(name) for name in self.quantities} if self.levels else {}

    def _estimate(self, name: str) -> Estimate:
        if name == FIELD:
            return of_differences(self.size, self.changes)
        return estimate([level.values[name] for level in self.levels], self.branches)

    @property
    def branches(self) -> bool:
        """Whether the last levels may stand on different branches: some have lost their stability, others have not.

        Where all of them have, at times that come no closer to each other, they may too.
        """
        lost = [level.lost for level in self.levels[-3:]]
        if None in lost or len(lost) < 3:
            return any(time is not None for time in lost) and None in lost
        first, second, third = (float(time or 0.0) for time in lost)
        return abs(third - second) > max(abs(second - first), 0.02 * third)

    @property
    def met(self) -> bool:
        """Whether all bars are inside the tolerance."""
        return all(one.relative <= self.tolerance for one in self.estimates.values())

    @property
    def expected_bars(self) -> dict[str, float]:
        """Relative bars that the next level can be expected to have, by column of the history."""
        if len(self.levels) < 2:
            return {}
        columns = {name: QUANTITIES[name].column for name in self.quantities}
        return {columns[name]: one.relative / 2 for name, one in self.estimates.items() if columns[name]}

    @property
    def lines(self) -> list[str]:
        """What is known of each quantity, in words."""
        lines = [f"{QUANTITIES[name].title}: {words_of(name, one)}" for name, one in self.estimates.items()]
        lost = [level for level in self.levels if level.lost is not None]
        if lost:
            when = ", ".join(f"at {level.lost:.4g} s in level {level.number}" for level in lost)
            spread = ": levels may follow different branches, so bars are the spread of the answers"
            lines.append(f"stability is lost {when}{spread if self.branches else ''}")
        return lines


def words_of(name: str, one: Estimate) -> str:
    """An estimate in words: value, bar, where the bar is from, and the limit that values tend to."""
    words = f"{_shown(name, one.value)} {bar_words(name, one)}"
    return words if math.isnan(one.limit) or name == FIELD else f"{words}, extrapolated {_shown(name, one.limit)}"


def bar_words(name: str, one: Estimate) -> str:
    """A bar in words, and where it is from."""
    if one.basis is Basis.NONE:
        return "with no error bar yet"
    order = f" {one.order:.2g}" if one.basis is Basis.ORDER else ""
    bar = f"+- {100 * one.relative:.2g} % ({_shown(name, one.bar, 2)})"
    return f"{bar}, {one.levels} levels, {one.basis.value}{order}"


def _shown(name: str, value: float, digits: int = 5) -> str:
    quantity = QUANTITIES[name]
    return f"{quantity.factor * value:.{digits}g} {quantity.unit}".rstrip()
