"""What Newton's method asks of the equations it solves."""

from __future__ import annotations

from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from ncf_fenicsx.contact.contacts import Contacts
from ncf_fenicsx.mechanics.scales import Scales
from ncf_fenicsx.mechanics.supports import Supports

Integers = NDArray[np.int64]


class System(Protocol):
    """What is solved: compiled forms, constraints, and contacts beside the forms.

    Attributes:
        displacement: unknown field, three components a node.
        last_iterate: field that the tangent reads the previous iterate from; None if it needs none.
        symmetric: whether the tangent is symmetric: LDL^T then, LU if not.
        supports: homogeneous Dirichlet conditions.
        contacts: forces between nodes beside the forms, and tools under force control.
        scales: sizes that increments and residuals are measured against.
    """

    displacement: Any
    last_iterate: Any
    symmetric: bool
    supports: Supports
    contacts: Contacts
    scales: Scales

    @property
    def residual_form(self) -> Any:
        """Compiled linear form."""

    @property
    def tangent_form(self) -> Any:
        """Compiled bilinear form."""

    @property
    def sublaminates(self) -> Integers:
        """Number of the sublaminate, layers that share nodes, of each owned node, 0 at the bottom."""
