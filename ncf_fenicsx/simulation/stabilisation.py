"""Adaptive viscous stabilisation: a viscosity that comes where steps fail again and again, and goes where they hold.

Past a loss of stability the stack may have no equilibrium near by, whatever the step: it snaps to another one.
A force against its motion makes a path of that snap. It need not be large: over a step that has been cut small it is a
stiffness, viscosity over time step, that only has to outweigh what the tangent lacks. Pure control: it knows no mesh.
"""

from __future__ import annotations

from dataclasses import dataclass

from ncf_fenicsx.scene import Scene

SHARE = 5e-5
"""First viscosity times the speed of the tools, over a layer's natural stiffness."""
TROUBLE, PLAIN_TROUBLE, DEEP_TROUBLE = 0.2, 0.01, 1e-3
"""Shares of the first step of a piece of the path: where smaller ones fail, the viscosity comes if stability has been
lost, comes if not (contact and friction have troubles of their own), and grows."""
UNTOLD_TROUBLE, UNTOLD_DEEP_TROUBLE = 0.03, 0.005
"""Those where the tangent is not symmetric, as with friction: no pivots tell of a loss of stability then."""
RAISE, LOWER = 4.0, 0.7
EASE = 0.9
"""Factor after a step that held in trouble, where no pivots tell when a snap is over: a viscosity that stayed would
resist what the stack does on its way."""
LEAST = 1e-3
"""Share of the first viscosity below which there is none."""


@dataclass
class Stabilisation:
    """Viscosity of a run.

    Attributes:
        first: the viscosity that comes first, in Pa s/m2; 0 to have none come.
        value: the present one in Pa s/m2.
        stability_lost: whether the run has lost stability.
        told: whether a loss of stability would be told.
    """

    first: float
    value: float = 0.0
    stability_lost: bool = False
    told: bool = True

    @classmethod
    def of_scene(cls, scene: Scene) -> Stabilisation:
        """That of a scene."""
        speed = max((segment.speed or 0.0 for segment in scene.segments), default=0.0)
        speed = speed or scene.stack.thickness / scene.milestones[-1]
        first = SHARE * scene.natural_stiffness / speed if scene.solver.may_stabilise else 0.0
        return cls(first, told=scene.symmetric)

    def in_trouble(self, share: float) -> bool:
        """Whether a step is such a share of its piece's first one only where steps have failed again and again."""
        return share < self._trouble

    def start(self) -> None:
        """Have it come, if it is not there yet."""
        self.value = self.value or self.first

    def failed(self, share: float) -> None:
        """Raise it after a step failed that was such a share of its piece's first one, if that is in trouble."""
        if not self.value:
            if share < (PLAIN_TROUBLE if self.told and not self.stability_lost else self._trouble):
                self.start()
        elif share < (DEEP_TROUBLE if self.told else UNTOLD_DEEP_TROUBLE):
            self.value *= RAISE

    @property
    def _trouble(self) -> float:
        return TROUBLE if self.told else UNTOLD_TROUBLE

    def held(self, share: float) -> None:
        """Lower it after a step held that was such a share of its piece's first one."""
        least = LEAST * self.first
        if not self.in_trouble(share):
            self.value = LOWER * self.value if self.value > least else 0.0
        elif self.value > least and not self.told:
            self.value *= EASE
