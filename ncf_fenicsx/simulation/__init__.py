"""A scene from start to end."""

from ncf_fenicsx.simulation.simulation import Simulation, run

__all__ = ["Simulation", "run"]
