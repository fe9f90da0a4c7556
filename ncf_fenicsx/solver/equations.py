"""What Newton's method asks of the equations it solves, and what it answers; it knows no PETSc."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from ncf_fenicsx.mechanics.supports import Supports

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]


class Contacts(Protocol):
    """Forces between nodes, beside the compiled forms, and unknown heights of tools.

    Attributes:
        controls: equations of tools whose height is an unknown at some time.
    """

    @property
    def keeping(self) -> bool:
        """Whether contact is kept where it was, whatever the gap."""

    @property
    def catching(self) -> bool:
        """Whether it is so because layers would touch nowhere."""

    @property
    def pairings(self) -> int:
        """How often nodes were paired anew: links change with it."""

    @property
    def controls(self) -> Sequence[Control]: ...  # noqa: D102

    def refresh(self) -> None:
        """Follow the present displacement."""

    def release(self, solves: int) -> None:
        """Keep nothing in contact any more that is kept for no more than a number of linear solves."""

    def touching(self) -> NDArray[np.bool_]:
        """Where there is contact now, on this rank; the same places in the same order at each call."""

    def residual(self) -> Iterator[tuple[Integers, Floats]]:
        """Global node numbers, and residuals in N of shape (nodes, 3)."""

    def tangent(self) -> Iterator[tuple[Integers, Integers, Floats]]:
        """Global node numbers of rows (n, a) and columns (n, b), and blocks in N/m of shape (n, 3 a, 3 b)."""

    def links(self) -> Iterator[tuple[Integers, Integers]]:
        """Global numbers of the nodes that the tangent couples, rows (n, a) and columns (n, b)."""


class Control(Protocol):
    """Equation of one tool's height."""

    @property
    def active(self) -> bool:
        """Whether the height is an unknown of the step."""

    @property
    def target(self) -> float | None:
        """Force in N that the tool has to carry; None if its height is given."""

    def excess(self) -> float:
        """Force on the tool above the target in N."""

    def column(self) -> Floats:
        """Derivative of the residual by the height in N/m, of the owned dofs."""

    def row(self) -> Floats:
        """Derivative of the force by the displacement in N/m, of the owned dofs."""

    def stiffness(self) -> float:
        """Derivative of the force by the height in N/m."""

    def shift(self, height: float) -> None:
        """Raise the tool by a height in m."""


class System(Protocol):
    """What is solved: compiled forms, constraints, and contacts beside the forms.

    Attributes:
        displacement: unknown field, three components a node.
        last_iterate: field that the tangent reads the previous iterate from; None if it needs none.
        residual_form: compiled linear form.
        symmetric: whether the tangent is symmetric: LDL^T then, LU if not.
        supports: homogeneous Dirichlet conditions.
        length: length in m that increments are measured against.
    """

    displacement: Any
    last_iterate: Any
    residual_form: Any
    symmetric: bool
    supports: Supports
    length: float

    @property
    def tangent_form(self) -> Any:
        """Compiled bilinear form."""

    @property
    def packs(self) -> Integers:
        """Pack of layers that share nodes, of each owned node, 0 at the bottom."""

    @property
    def force_floor(self) -> float:
        """Norm of the forces in N that round-off leaves unbalanced."""

    @property
    def increment_cap(self) -> float:
        """Largest increment in m of a component of the displacement in one of Newton's steps."""

    @property
    def contacts(self) -> Contacts:
        """Forces between nodes beside the forms, and controls."""

    def load(self, residual: Floats) -> float:
        """Forces in N that carry the body, given the residual in N of the owned dofs."""


@dataclass(frozen=True)
class Outcome:
    """How a solve ended.

    Attributes:
        converged: whether the solution holds.
        iterations: Newton iterations.
        reason: in words, why it ended.
        hopeless: whether no smaller step would hold either.
        negative_pivots: of the last factors, or a mode found without them; more than none in equilibrium is a loss of
            stability. None with LU.
    """

    converged: bool
    iterations: int
    reason: str
    hopeless: bool = False
    negative_pivots: int | None = None

    def followed_by(self, later: Outcome) -> Outcome:
        """This solve and one after it, as one."""
        return replace(later, iterations=self.iterations + later.iterations)
