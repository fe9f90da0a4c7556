"""What is measured of an accepted state: forces, fibre volume fractions, penetration, gaps."""

from __future__ import annotations

from typing import Any

import numpy as np
import ufl
from dolfinx import fem
from mpi4py import MPI
from numpy.typing import NDArray

from ncf_fenicsx.mechanics.problem import Problem
from ncf_fenicsx.mesh import compat
from ncf_fenicsx.output.contact_measures import OPENING_COLUMNS, RIGID_COLUMNS, ContactMeasures
from ncf_fenicsx.output.energies import COLUMNS as ENERGY_COLUMNS
from ncf_fenicsx.output.energies import Energies
from ncf_fenicsx.output.face_waves import WAVE_COLUMNS
from ncf_fenicsx.output.forces import FORCE_COLUMNS, Forces
from ncf_fenicsx.output.mould_void import VOID_COLUMNS
from ncf_fenicsx.output.vf_error import VfError

Floats = NDArray[np.float64]

COLUMNS = {
    "time": ("s", "time at the end of the step"),
    "time_step": ("s", "size of the step"),
    "tool_displacement": ("m", "how far the tool has moved down"),
    **FORCE_COLUMNS,
    "vf_min": ("1", "smallest fibre volume fraction, by cell"),
    "vf_mean": ("1", "mean fibre volume fraction over the undeformed volume"),
    "vf_max": ("1", "largest fibre volume fraction, by cell"),
    "vf_error": (
        "1",
        "estimated error of the field of Vf by the mesh, over the field's change, root mean squares; "
        "with laws.bending in the plane alone, as one element through each layer is then the model",
    ),
    "vf_error_in_plane": ("1", "the part of it that more elements along x and y would take away"),
    **ENERGY_COLUMNS,
    **RIGID_COLUMNS,
    **{f"{name}_N": meaning for name, meaning in (OPENING_COLUMNS | WAVE_COLUMNS).items()},
    **{f"mould_{name}": meaning for name, meaning in VOID_COLUMNS.items()},
    "negative_pivots": (
        "1",
        "of the step's last factors; those of the first loss are of its end. 0 is stable; where it is symmetric. "
        "With factors of layers no more than these, and 0 only where no mode is found",
    ),
    "time_error": (
        "1",
        "estimated local error in time of the step, over the largest pressure so far; where laws follow time",
    ),
    "newton_iterations": ("1", "Newton iterations of the step, without one that only polishes its solution"),
    "step_cuts": ("1", "attempts at the step that failed before"),
    "wall_time": ("s", "time since the start of the program's run"),
}
"""Columns of ``history.csv`` with unit and meaning; ``vf_mean_layer_1`` (bottom) and so on follow ``vf_max``.

A solid has no Vf, and none of its columns. Columns of tools are those of the first; ``tool_force_2`` and so on are of
the next ones, ``mould_...`` of the mould and of the face on it, which has its waves, too. Columns of waves that end
with N are of the upper face of layer N, the others of the interface above it; a bonded one has none of these.
"""


class Measures:
    """Evaluates a problem's state.

    Args:
        problem: what is measured.

    Attributes:
        cells: means over this rank's cells in the last observed state, by name: ``volume_fraction`` (1), ``stress_33``
            (Pa), ``permeability_along`` and ``permeability_across`` (m2), of which a scene has what it names.
        forces: of tools, mould and held sides.
        contacts: measures of contacts, with their fields at nodes.
        energies: work of the tools and of friction.
        error: estimated error of the field of Vf; None of a solid.
        state: what measures remember from step to step.
    """

    def __init__(self, problem: Problem) -> None:
        self.problem = problem
        scene, mesh = problem.scene, problem.mesh
        cells = fem.functionspace(mesh, ("DG", 0))
        indicator = ufl.TestFunction(cells)
        material, volumes = problem.material, problem.volumes
        kinematics = material.kinematics(problem.displacement)
        stress = material.normal_stress_integral(kinematics, indicator, volumes)
        integrals = {"volume": 1.0 * indicator * volumes.all, "stress_33": stress}
        self.has_fibres = scene.laws.solid is None
        if self.has_fibres:
            integrals["volume_fraction"] = kinematics.volume_fraction * indicator * volumes.all
        self.cells: dict[str, Floats] = {}
        self._forms = {name: compat.compile_form(integral) for name, integral in integrals.items()}
        self._volume = self._integrals("volume")
        weight = compat.compile_form(problem.terms["gravity"]) if "gravity" in problem.terms else None
        self.forces = Forces(problem, weight)
        self.contacts, self.energies = ContactMeasures(problem), Energies(problem)
        self.error = VfError(problem, self._volume) if self.has_fibres else None
        self.state = [*self.energies.state, *(self.error.state if self.error is not None else [])]

    def observe(self, residual: Floats, time: float) -> dict[str, float]:
        """Measured columns of the history in the trial state, before it is committed: stress follows the states before.

        Args:
            residual: out-of-balance forces in N of the owned dofs, reactions included.
            time: in s.
        """
        self.cells = {name: self._integrals(name) / self._volume for name in self._forms if name != "volume"}
        permeability = self.problem.scene.output.permeability
        if permeability is not None:
            vf = self.cells["volume_fraction"]
            self.cells |= {"permeability_along": permeability.along(vf), "permeability_across": permeability.across(vf)}
        forces, contacts = self.forces.observe(residual), self.contacts.observe()
        fractions = self._volume_fractions(self.cells["volume_fraction"]) if self.error is not None else {}
        return forces | fractions | self.energies.observe(time) | contacts

    def _volume_fractions(self, vf: Floats) -> dict[str, float]:
        comm, stack = self.problem.comm, self.problem.stack
        columns = {
            "vf_min": comm.allreduce(float(vf.min(initial=1.0)), MPI.MIN),
            "vf_mean": self._mean(vf, slice(None)),
            "vf_max": comm.allreduce(float(vf.max(initial=0.0)), MPI.MAX),
        }
        if self.error is not None:
            columns |= self.error.observe(vf, self.cells["stress_33"], self.contacts.nodes.get("contact_pressure"))
        for number in range(self.problem.scene.stack.layers):
            columns[f"vf_mean_layer_{number + 1}"] = self._mean(vf, stack.layer == number)
        return columns

    def _integrals(self, name: str) -> Floats:
        values: Any = fem.assemble_vector(self._forms[name]).array
        return values[: len(self.problem.stack.layer)].copy()

    def _mean(self, values: Floats, cells: NDArray[np.bool_] | slice) -> float:
        volume = self._volume[cells]
        total, weighted = self.problem.comm.allreduce(np.array([volume.sum(), values[cells] @ volume]))
        return float(weighted / total)
