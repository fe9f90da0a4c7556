"""Panels of ``laws.py`` for which a law is evaluated at given strains, over closed forms and sources."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import ufl
from dolfinx import fem
from laws_compared import Worst
from mpi4py import MPI

from ncf_fenicsx import Scene
from ncf_fenicsx.laws.compaction import Exponential
from ncf_fenicsx.laws.in_plane import FibreFamilies, NeoHookean, NeoHookeanAsPrinted
from ncf_fenicsx.laws.kinematics import Kinematics
from ncf_fenicsx.laws.law import number
from ncf_fenicsx.laws.permeability import Gebart, KozenyCarman
from ncf_fenicsx.laws.rate import KellyRate
from ncf_fenicsx.laws.shear import GrowingShear
from ncf_fenicsx.mechanics.problem import Problem
from ncf_fenicsx.mesh import build_mesh

SCENE = Path(__file__).with_name("single_element.toml")
KPA, MPA, GPA, MM_PER_MIN = 1e-3, 1e-6, 1e-9, 1e-3 / 60
VF0 = Scene.read(SCENE).stack.initial_volume_fraction
MEASURED_RATE = ((1, 23.7), (2, 40.0), (5, 85.8))  # kPa at Vf 0.60: Table 2; at 2 mm/min about sigma_beta(0.60)
GEBART_BY_HAND = ((0.4, 2.6409e-12, 5.4459e-13), (0.5, 9.7811e-13, 2.1202e-13), (0.6, 3.4777e-13, 7.5489e-14))


def draw_toe(axes: Any) -> None:
    """The exponential law near the undeformed state."""
    vf = np.linspace(0.39, 0.47, 200)
    for toe in ("raw", "clip", "shift"):
        axes.plot(vf, Exponential(toe=toe).pressure(vf, VF0), label={"raw": "as printed (raw)"}.get(toe, toe))
    axes.plot([VF0, 0.429852], [-962, 0], "kx", label="-962 Pa at Vf0; zero at 0.4299")
    axes.axvline(VF0, color="grey", linestyle=":")
    axes.set(title="Eq. 3 near rest: tension as printed", xlabel="fibre volume fraction", ylabel="pressure (Pa)")


def draw_rate(axes: Any) -> None:
    """Stress at Vf 0.60 over speed, as printed and as meant."""
    speed = np.linspace(-1, 6, 200)
    at_60 = KPA * Exponential().as_printed(0.60)
    for label, rate in {
        "as meant: A(v)/A(v_ref), -1/alpha3": KellyRate(),
        "A(v) not normalised": KellyRate(normalised="lowest_speed"),
        "as printed: A(v), +1/alpha3": KellyRate(normalised="lowest_speed", exponent="as_printed"),
    }.items():
        axes.plot(speed, at_60 * rate.factor(speed * MM_PER_MIN), label=label)
    axes.set_ylim(0, 190)
    axes.plot(*zip(*MEASURED_RATE, strict=True), "ks", markersize=4, label="measured (paper)")
    axes.set(title="Eq. 4: stress at Vf 0.60 over speed", xlabel="closing speed (mm/min)", ylabel="pressure (kPa)")


def stress(law: Any, gradient: np.ndarray) -> float:
    """S_11 (Pa) of a law."""
    return number(law.stress(Kinematics(ufl.as_matrix(gradient.tolist()), ufl.as_ufl(VF0)))[0, 0])


def draw_fibres(axes: Any, worst: Worst) -> None:
    """Stress along x over stretch along x, the sides held."""
    stretch = np.linspace(0.995, 1.005, 11)
    fine = np.linspace(0.995, 1.005, 201)
    lame, mu = 242e9 * 0.2 / 0.96, 242e9 / 2.4
    ply = FibreFamilies(plies=(0.0,), transition=1e-3)

    def family(x: np.ndarray) -> np.ndarray:
        e = (x**2 - 1) / 2
        tension = np.where(e < 1e-3, np.maximum(e, 0) ** 2 / 2e-3, e - 5e-4)
        return 24.2e9 * e + (242e9 - 24.2e9) * tension + 1e6 * e

    cases: dict[str, tuple[Any, Callable[[np.ndarray], np.ndarray]]] = {
        "neo-Hookean": (NeoHookean(), lambda x: mu * (1 - x**-2) + lame * np.log(x) * x**-2),
        "one ply, softer in compression": (ply, family),
    }
    for name, (law, exact) in cases.items():
        (line,) = axes.plot(fine, GPA * exact(fine), label=name)
        computed = np.array([stress(law, np.diag([x, 1, 1])) for x in stretch])
        axes.plot(stretch, GPA * computed, "o", color=line.get_color(), markersize=4)
        worst.note(name, computed, exact(stretch))
    axes.set(title="Fibres: stress along the ply", xlabel="stretch", ylabel="S11 (GPa)")


def draw_printed(axes: Any, worst: Worst) -> None:
    """Stress in the plane that compaction alone gives."""
    compaction = np.linspace(0, 0.1, 11)
    law = NeoHookeanAsPrinted()
    computed = np.array([stress(law, np.diag([1, 1, 1 - e])) for e in compaction])
    exact = -law.lame * compaction * (1 - compaction)
    (line,) = axes.plot(
        100 * compaction, GPA * exact / (1 - compaction), label="Eq. 1 as printed: lambda (J - 1), nu = 0.3"
    )
    axes.plot(100 * compaction, GPA * computed / (1 - compaction), "o", color=line.get_color(), markersize=4)
    axes.plot(6.25, -8.7, "kx", label="-8.7 GPa at 6.25 %")
    axes.plot(
        100 * compaction, [stress(NeoHookean(), np.diag([1, 1, 1 - e])) for e in compaction], label="in-plane J_s"
    )
    worst.note("as printed", computed, exact)
    axes.set(title="Eq. 1: compaction presses the fibres", xlabel="compaction (%)", ylabel="in-plane stress (GPa)")


def draw_shear(axes: Any, worst: Worst) -> None:
    """Transverse shear modulus over Vf."""
    vf = np.linspace(VF0, 0.65, 12)
    for exponent in (0.0, 5.0):
        law = GrowingShear(exponent=exponent)
        exact = 0.1 * (vf / VF0) ** exponent
        (line,) = axes.plot(vf, exact, label="constant" if not exponent else f"growing, exponent {exponent:g}")
        computed = []
        for v in vf:
            gradient = np.array([[1, 0, 0.1], [0, 1, 0], [0, 0, VF0 / v]])
            energy = number(law.energy(Kinematics(ufl.as_matrix(gradient.tolist()), ufl.as_ufl(VF0))))
            computed.append(2 * MPA * energy / 0.1**2)
        axes.plot(vf, computed, "o", color=line.get_color(), markersize=4)
        worst.note(f"shear, exponent {exponent:g}", np.array(computed), exact)
    axes.set(title="Transverse shear", xlabel="fibre volume fraction", ylabel="G_t (MPa)")


def draw_permeability(axes: Any) -> None:
    """Permeability over Vf."""
    vf = np.linspace(VF0, 0.75, 200)
    for name, law in {"Gebart, hexagonal": Gebart(), "Kozeny-Carman": KozenyCarman()}.items():
        (line,) = axes.semilogy(vf, law.along(vf), label=f"{name}, along")
        axes.semilogy(vf, law.across(vf), "--", color=line.get_color(), label=f"{name}, across")
    for at, along, across in GEBART_BY_HAND:
        axes.plot([at, at], [along, across], "kx")
    axes.set(title="Permeability, fibre radius 3.6 um", xlabel="fibre volume fraction", ylabel="permeability (m$^2$)")


def draw_bending(axes: Any, worst: Worst) -> None:
    """Bending rigidity of a layer over its bending modulus: work of the fibres bent to a cylinder."""
    moduli, curvature, thickness = np.geomspace(1e6, 242e9, 7), 1e-4, 2e-3
    computed = []
    for modulus in moduli:
        scene = Scene.read(SCENE, [f"laws.bending.modulus={modulus} Pa", "stack.divisions=[8,1]"])
        problem = Problem(scene, build_mesh(scene, MPI.COMM_WORLD))
        problem.displacement.interpolate(
            lambda x: np.stack([-curvature * x[0] * (x[2] - thickness / 2), 0 * x[0], curvature * x[0] ** 2 / 2])
        )
        work = fem.form(ufl.action(problem.terms["internal"], problem.displacement))
        area = scene.stack.size[0] * scene.stack.size[1]
        computed.append(MPI.COMM_WORLD.allreduce(fem.assemble_scalar(work)) / (curvature**2 * area))
    exact = moduli * thickness**3 / (12 * (1 - 0.2**2))
    axes.loglog(moduli, exact, label="modulus t^3 / (12 (1 - nu^2))")
    axes.loglog(moduli, computed, "o", color="C0", markersize=4)
    axes.axhspan(1e-3, 50e-3, color="C2", alpha=0.2, label="1 to 50 N mm: the order of dry plies")
    worst.note("bending", np.array(computed), exact)
    axes.set(title="Bending apart from the membrane", xlabel="bending modulus (Pa)", ylabel="rigidity (N m)")
