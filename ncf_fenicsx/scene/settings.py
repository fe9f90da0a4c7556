"""How a scene is run: its time steps and Newton's method, what it writes, how it is marched explicitly."""

from __future__ import annotations

from typing import Annotated, ClassVar, Literal, Self

from pydantic import PositiveInt, model_validator

from ncf_fenicsx.laws.permeability import PermeabilityLaw
from ncf_fenicsx.parameters.kinds import Choice, Settings, parameter
from ncf_fenicsx.parameters.units import PositiveLength, PositiveMemory, PositiveShare, PositiveTime

QuantityName = Literal["force", "vf", "vf_field", "void_volume", "wrinkle_height"]


class Solver(Settings):
    """Time steps and Newton's method."""

    renamed: ClassVar[dict[str, str]] = {"steadying": "stabilisation", "travel_cap": "sliding_increment_cap"}
    first_step: PositiveTime | None = parameter(
        None, description="first time step of each piece of the path; its duration / 30 unless given"
    )
    largest_step: PositiveTime | None = parameter(
        None, description="largest time step; duration of the piece / 8 unless given"
    )
    smallest_step: PositiveTime | None = parameter(None, description="step at which a run stops; first_step / 1e4")
    step_refinement: float = parameter(
        1.0, gt=0, description="factor that first and largest steps, given or not, are divided by"
    )
    max_steps: PositiveInt = parameter(1000, description="number of accepted steps at which a run stops")
    time_tolerance: float = parameter(
        0.005,
        gt=0,
        description="local error in time over the largest pressure so far above which a step is taken again, smaller; "
        "for laws that follow time (a local speed, relaxation). 1 or more for none",
    )
    target_iterations: PositiveInt = parameter(
        6, description="Newton iterations that keep the step size as it is; 12 with friction unless given"
    )
    max_iterations: PositiveInt = parameter(
        15, description="Newton iterations at which a step is cut; 55 with friction unless given"
    )
    growth: float = parameter(1.5, ge=1, description="largest factor from one step to the next")
    cut: float = parameter(0.4, gt=0, lt=1, description="factor on a step that failed")
    tangent: Literal["extrapolated", "plain"] = parameter(
        "extrapolated", description="membrane stress in the tangent: extrapolated from the last iterate, or the current"
    )
    line_search: Literal["full", "work", "critical_point", "error_oriented", "residual", "trust_region"] = parameter(
        "full",
        description="length of Newton's steps: whole; whole unless the work of the forces out of balance turns over "
        "along it (work: with friction unless given); to where the residual is across the step (PETSc's cp); by the "
        "next simplified correction (nleqerr); by the residual's norm (bt); within a trust region (newtontr)",
    )
    factors: Literal["automatic", "kept", "new", "layers", "multigrid"] = parameter(
        "automatic",
        description="factors of the tangent: kept while GMRES converges fast with them; new for each correction; of "
        "each layer and of all heights, made exact by GMRES; for solids none, but multigrid. Kept from "
        "20,000 unknowns on, else new, unless given",
    )
    force_tolerance: float = parameter(1e-7, gt=0, lt=1, description="residual over the support force at convergence")
    increment_tolerance: float = parameter(1e-4, gt=0, lt=1, description="next increment over the layer's thickness")
    increment_cap: float = parameter(0.3, gt=0, description="largest nodal increment over the layer's thickness")
    step_travel: float = parameter(
        0.5, gt=0, description="largest travel of a tool in a step over the layer's thickness"
    )
    sliding_increment_cap: float = parameter(
        0.02,
        gt=0,
        description="largest nodal increment over the layer's thickness while a tool travels along the surface; "
        "increment_cap with friction unless given",
    )
    stabilisation: Literal["automatic", "none"] = parameter(
        "automatic",
        description="adaptive viscous stabilisation: a viscosity where steps fail again and again, or none",
    )
    viscous_share: float = parameter(
        0.5, gt=0, description="energy that the viscosity has taken, over the work of the tools, at which a run stops"
    )
    perturbation: PositiveLength | None = parameter(
        None, description="largest displacement of a push along the critical mode, where stability is lost first"
    )

    def with_friction(self) -> Self:
        """These settings, with what friction asks for where nothing is given.

        Fronts between stick and slip pass from node to node, one in each iteration, however short the step is. How many
        it takes then depends on round-off; whether the step holds must not.
        """
        asked = {
            "target_iterations": 12,
            "max_iterations": 55,
            "line_search": "work",
            "sliding_increment_cap": self.increment_cap,
        }
        given = self.model_fields_set
        return self.model_copy(update={name: value for name, value in asked.items() if name not in given})

    @property
    def searches(self) -> bool:
        """Whether corrections are searched along; how many iterations that takes depends on round-off."""
        return self.line_search == "work"

    @property
    def may_stabilise(self) -> bool:
        """Whether a viscosity may be added."""
        return self.stabilisation == "automatic"

    @model_validator(mode="after")
    def _steps_in_order(self) -> Self:
        given = [step for step in (self.smallest_step, self.first_step, self.largest_step) if step is not None]
        if given != sorted(given):
            raise ValueError("expected smallest_step <= first_step <= largest_step")
        return self


class Output(Settings):
    """What a run writes."""

    fields_every: PositiveInt = parameter(1, description="accepted steps between field files; the last is always one")
    checkpoint_every: PositiveInt | None = parameter(
        None, description="accepted steps between checkpoints, beside those by time"
    )
    checkpoint_interval: PositiveTime = parameter("60 s", description="wall time between checkpoints; one at the end")
    critical_mode: bool = parameter(
        False, description="write the mode in which stability is lost first, where the tangent is symmetric"
    )
    picture: bool = parameter(True, description="draw summary.png")
    report: bool = parameter(True, description="write report.html, a page with the stack in 3-D")
    companion: bool = parameter(
        False,
        description="run half the mesh and half the steps after it, in folder companion, which tells errors",
    )
    permeability: Annotated[PermeabilityLaw, Choice("permeability", "gebart")] | None = parameter(
        None, description="permeability as fields; none unless given"
    )


class Accuracy(Settings):
    """What a sequence of runs, each finer than the last, is to reach, and where it ends without."""

    quantities: tuple[QuantityName, ...] = parameter(
        ("force",),
        min_length=1,
        description="whose error is to be bounded: force (the largest on a tool), vf (the largest), vf_field (at the "
        "end), void_volume (the largest of all voids), wrinkle_height (of the highest)",
    )
    tolerance: PositiveShare = parameter("1 %", description="largest error bar of each over its size")
    most_time: PositiveTime = parameter("1 h", description="wall time at which the best answer so far is taken")
    most_memory: PositiveMemory | None = parameter(
        None, description="memory that no run may need more than; four fifths of what is free unless given"
    )


class Explicit(Settings):
    """Marching by central differences, for ``ncf-fenicsx explicit``: an explicit code to compare with."""

    mass_scaling: float = parameter(5.0, ge=1, description="factor on the density")
    time_scaling: float = parameter(
        1000.0, ge=1, description="how much faster than in the scene the tools move; laws keep the scene's time"
    )
    bulk_viscosity: float = parameter(
        0.06, ge=0, lt=1, description="damping of changes of volume, over the critical one of the highest mode"
    )
    damping: float = parameter(
        0.02,
        ge=0,
        lt=1,
        description="damping of all motion, over the critical one of the stack's lowest mode across it",
    )
    safety: float = parameter(0.9, gt=0, le=1, description="step over the largest stable one")
    rows: PositiveInt = parameter(200, description="rows of the history; states of the laws go on with each")
    kinetic_share: float = parameter(
        0.05, gt=0, description="kinetic over internal energy above which a run is not called quasi-static"
    )
