"""The multiplier of a contact, which takes over from its penalty update by update, and the penalty that it raises."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np
from dolfinx import fem

from ncf_fenicsx.contact.deformed_body import DeformedBody
from ncf_fenicsx.laws.contact import AugmentedLagrangian, Enforcement, Touch, most_raised
from ncf_fenicsx.mesh.faces import Face
from ncf_fenicsx.mesh.state_fields import Location, StateField, field_on_face
from ncf_fenicsx.parameters.units import PenaltyStiffness

SLOW = 0.25
"""Share of the deepest penetration that an update may leave. Above it the penalty is too soft: updates converge
linearly, with a rate that is the body's stiffness over that of both."""
RAISE = 10.0
"""Factor on the penalty after such an update."""


class Multiplier:
    """Contact pressure of the last update, at the nodes of a face, and what its updates have made of the penalty.

    A penalty is raised between updates where they converge slowly (Bertsekas 1982, section 2.3), and stays so for the
    rest of the run: where penetration has gone, the pressure is the multiplier's whatever the penalty.

    Args:
        name: of the contact in a scene.
        way: its tolerance and limit.
        body: the fabric.
        most: largest factor on the penalty.

    Attributes:
        way: how the contact is enforced.
        state: what is remembered; empty until `follow`.
    """

    def __init__(self, name: str, way: AugmentedLagrangian, body: DeformedBody, most: float) -> None:
        self._name, self.way, self._most = name, way, most
        self._allowed = way.tolerance * body.thickness
        self._pressure = body.spaces.scalar()
        self._factor = fem.Constant(body.spaces.mesh, np.ones(1))
        self._deepest = math.inf
        self.state: list[StateField] = []

    def on(self, touch: Touch) -> Touch:
        """What is known of a contact, with this multiplier and the penalty as it has raised it."""
        return replace(touch, stiffness=self._factor[0] * touch.stiffness, multiplier=self._pressure)

    def follow(self, face: Face, pressure: Any) -> None:
        """Take each update from the compiled density of the contact pressure over a face in Pa."""
        raised = StateField(f"{self._name}.penalty_factor", Location.EVERYWHERE, self._factor.value)
        self.state = [field_on_face(f"{self._name}.multiplier", self._pressure, face, pressure), raised]

    def begin(self) -> None:
        """Forget how deep the step before was."""
        self._deepest = math.inf

    def update(self, deepest: float) -> bool:
        """Update where a deepest penetration (m) is above the tolerance, and say whether it is."""
        if deepest <= self._allowed:
            self._deepest = math.inf  # it may grow again as other contacts are updated, for no fault of its penalty
            return False
        self.state[0].advance()
        if deepest > SLOW * self._deepest:
            self._factor.value[0] = min(RAISE * self._factor.value[0], self._most)
        self._deepest = deepest
        return True


def multiplier_of(
    name: str, way: Enforcement, body: DeformedBody, penalty: PenaltyStiffness, stiffest: float
) -> Multiplier | None:
    """The multiplier of a contact; None if its way of enforcing it keeps none.

    Args:
        name: of the contact in a scene.
        way: how it is enforced.
        body: the fabric.
        penalty: of the contact.
        stiffest: factor on a layer's own stiffness above which that is not raised.
    """
    if not isinstance(way, AugmentedLagrangian):
        return None
    natural = body.natural_stiffness
    return Multiplier(name, way, body, most_raised(stiffest, penalty.resolve(natural), natural))
