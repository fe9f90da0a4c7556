"""A viscosity that comes where steps fail again and again, and goes where they hold: pure control.

Past a loss of stability the stack may have no equilibrium near by, whatever the step: it snaps to another one.
A force against its motion makes a path of that snap. It need not be large: over a step that has been cut small it is a
stiffness, viscosity over time step, that only has to outweigh what the tangent lacks.
"""

from __future__ import annotations

from dataclasses import dataclass

from ncf_fenicsx.scene import Scene

SHARE = 5e-5
"""First viscosity times the speed of the tools, over a layer's natural stiffness."""
TROUBLE, DEEP_TROUBLE = 0.2, 1e-3
"""Shares of a run's first step: where smaller ones fail, the viscosity comes, and grows."""
RAISE, LOWER = 4.0, 0.7
LEAST = 1e-3
"""Share of the first viscosity below which there is none."""


@dataclass
class Steadying:
    """Viscosity of a run.

    Measured on long rollers 2.5 and 4 mm into 8 mm, which stop without it: shares from 1e-5 to 1e-4 and factors from
    0.25 to 0.7 end nearly all; later or earlier first trouble costs up to three times the iterations.

    Attributes:
        first: the viscosity that comes first, in Pa s/m2; 0 to have none come.
        first_step: the run's first time step in s.
        constant: viscosity that the scene asks for at all times, 0 for none.
        raised: the present one beside that.
    """

    first: float
    first_step: float
    constant: float = 0.0
    raised: float = 0.0

    @classmethod
    def of_scene(cls, scene: Scene, first_step: float) -> Steadying:
        """That of a scene whose run begins with a step of a size (s)."""
        settings = scene.solver
        speed = max((segment.speed or 0.0 for segment in scene.segments), default=0.0)
        speed = speed or scene.stack.thickness / scene.milestones[-1]
        first = SHARE * scene.natural_stiffness / speed if settings.steadying == "automatic" else 0.0
        return cls(first, first_step, settings.viscosity or 0.0)

    @property
    def value(self) -> float:
        """Present viscosity in Pa s/m2."""
        return self.constant + self.raised

    def start(self) -> None:
        """Have it come, if it is not there yet."""
        self.raised = self.raised or self.first

    def failed(self, size: float) -> None:
        """Raise it after a step of a size (s) that failed, if that is in trouble."""
        if size < TROUBLE * self.first_step and not self.raised:
            self.start()
        elif size < DEEP_TROUBLE * self.first_step:
            self.raised *= RAISE

    def held(self, size: float) -> None:
        """Lower it after a step of a size (s) that held, out of trouble."""
        if size >= TROUBLE * self.first_step:
            self.raised = LOWER * self.raised if self.raised > LEAST * self.first else 0.0
