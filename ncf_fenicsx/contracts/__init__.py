"""What every law and tool of a kind owes the rest of the program.

A law pairs a strain with a stress, by an energy where it has one. Parameters are fields of the part, and named
constants in the compiled forms.
"""

from ncf_fenicsx.contracts.compaction import (
    CompactionLaw,
    CompactionStep,
    RateLaw,
    RelaxationLaw,
    StatefulLaw,
    UnloadingLaw,
    positive,
)
from ncf_fenicsx.contracts.elasticity import BendingLaw, HyperelasticInPlaneLaw, InPlaneLaw, ShearLaw, SolidLaw
from ncf_fenicsx.contracts.law import Law, number, real
from ncf_fenicsx.contracts.permeability import PermeabilityLaw
from ncf_fenicsx.contracts.tool import Mould, RigidSurface, Tool

__all__ = [
    "BendingLaw",
    "CompactionLaw",
    "CompactionStep",
    "HyperelasticInPlaneLaw",
    "InPlaneLaw",
    "Law",
    "Mould",
    "PermeabilityLaw",
    "RateLaw",
    "RelaxationLaw",
    "RigidSurface",
    "ShearLaw",
    "SolidLaw",
    "StatefulLaw",
    "Tool",
    "UnloadingLaw",
    "number",
    "positive",
    "real",
]
