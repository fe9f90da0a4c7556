"""The multiplier of a contact, which takes over from its penalty update by update, and the penalty that it raises."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np
from dolfinx import fem

from ncf_fenicsx.contact.deformed_body import DeformedBody
from ncf_fenicsx.laws.contact import AugmentedLagrangian, Enforcement, Touch
from ncf_fenicsx.mesh.faces import Face
from ncf_fenicsx.mesh.state_fields import Location, StateField, field_on_face

SLOW = 0.25
"""Share of the deepest penetration that an update may leave. Above it the penalty is too soft: updates converge
linearly, with a rate that is the body's stiffness over that of both."""
RAISE, MOST = 10.0, 1e4
"""Factor on the penalty after such an update, and the largest factor on that of the scene."""


class Multiplier:
    """Contact pressure of the last update, at the nodes of a face, and what its updates have made of the penalty.

    A penalty is raised between updates where they converge slowly (Bertsekas 1982, section 2.3), and stays so: where
    penetration has gone, the pressure is the multiplier's whatever the penalty.

    Args:
        name: of the contact in a scene.
        way: its tolerance and limit.
        body: the fabric.

    Attributes:
        way: how the contact is enforced.
        state: what is remembered; empty until `follow`.
    """

    def __init__(self, name: str, way: AugmentedLagrangian, body: DeformedBody) -> None:
        self._name, self.way = name, way
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
            return False
        self.state[0].advance()
        if deepest > SLOW * self._deepest:
            self._factor.value[0] = min(RAISE * self._factor.value[0], MOST)
        self._deepest = deepest
        return True


def multiplier_of(name: str, way: Enforcement, body: DeformedBody) -> Multiplier | None:
    """The multiplier of a contact with a way of enforcing it; None if that keeps none."""
    return Multiplier(name, way, body) if isinstance(way, AugmentedLagrangian) else None
