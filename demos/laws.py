"""Every law and cycle in one figure: dots are what the program computes, lines closed forms and sources.

Run: ``docker/run python3 demos/laws.py [RESULTS_FOLDER]`` or with ``mpirun -n 2`` before ``python3``.
"""

import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import ufl
from dolfinx import fem
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from mpi4py import MPI

from ncf_fenicsx import Scene, run
from ncf_fenicsx.contracts import number
from ncf_fenicsx.kinematics import Kinematics
from ncf_fenicsx.laws.as_printed import NeoHookeanAsPrinted
from ncf_fenicsx.laws.exponential import Exponential
from ncf_fenicsx.laws.fibre_families import FibreFamilies
from ncf_fenicsx.laws.gebart import Gebart
from ncf_fenicsx.laws.growing_shear import GrowingShear
from ncf_fenicsx.laws.kelly_rate import KellyRate
from ncf_fenicsx.laws.kozeny_carman import KozenyCarman
from ncf_fenicsx.laws.neo_hookean import NeoHookean
from ncf_fenicsx.mesh import build_mesh
from ncf_fenicsx.parts import kinds
from ncf_fenicsx.problem import Problem

HERE = Path(__file__).parent
KPA, MPA, GPA, MM_PER_MIN = 1e-3, 1e-6, 1e-9, 1e-3 / 60
VF0 = Scene.read(HERE / "single_element.toml").stack.initial_volume_fraction
SHARES, TIMES = (0.3, 0.2), (2.0, 30.0)
SET, EXPONENT = 0.5, 3.0
MEASURED_RATE = ((1, 23.7), (2, 40.0), (5, 85.8))  # kPa at Vf 0.60: the paper's Fig. 4 and Table 2
GEBART_1992 = ((0.4, 2.6409e-12, 5.4459e-13), (0.5, 9.7811e-13, 2.1202e-13), (0.6, 3.4777e-13, 7.5489e-14))


class Worst:
    """Largest difference of dots from lines, relative to the largest value of each line."""

    def __init__(self) -> None:
        self.of: dict[str, float] = {}

    def note(self, name: str, computed: np.ndarray, exact: np.ndarray) -> None:
        """Compare two curves at the same places."""
        self.of[name] = float(np.abs(computed - exact).max() / np.abs(exact).max())


def press(folder: Path, name: str, laws: dict[str, Any], path: list[dict[str, Any]]) -> tuple[np.ndarray, ...]:
    """Time (s), Vf and pressure (Pa) of one hexahedron under a plate on a path."""
    base = Scene.read(HERE / "single_element.toml")
    table = base.table() | {"laws": laws, "output": {"picture": False, "fields_every": 1000}}
    table["tool"]["path"] = path
    table["solver"]["largest_step"] = "2 s"
    result = run(Scene.from_table(table), folder / name, overwrite=True)
    assert result.done, result.reason
    area = base.stack.size[0] * base.stack.size[1] * base.stack.sides.copies
    columns = [np.array([row[key] for row in result.history]) for key in ("time", "vf_max", "tool_force")]
    return columns[0], columns[1], columns[2] / area


def down(millimetres: float, speed: str = "2 mm/min") -> dict[str, Any]:
    """A travel of the plate."""
    return {"travel": ["0 mm", "0 mm", f"{-millimetres} mm"], "speed": speed}


def draw_compaction(axes: Any, folder: Path, worst: Worst) -> None:
    """Every compaction law to Vf 0.62, and what the program gives."""
    vf = np.linspace(VF0, 0.62, 200)
    for kind, part in sorted(kinds("compaction").items()):
        law = part()
        (line,) = axes.plot(vf, KPA * law.pressure(vf, VF0), label=kind.replace("_", " "))
        _, at, pressure = press(folder, kind, {"compaction": {"kind": kind}, "rate": {"kind": "none"}}, [down(0.7)])
        axes.plot(at, KPA * pressure, "o", color=line.get_color(), markersize=3)
        worst.note(kind, pressure, law.pressure(at, VF0))
    axes.set(title="Compaction: laws at the speed of the fit", xlabel="fibre volume fraction", ylabel="pressure (kPa)")


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


def draw_relaxation(axes: Any, folder: Path, worst: Worst) -> None:
    """Press fast, hold: two branches."""
    branches = [{"share": share, "time": f"{time} s"} for share, time in zip(SHARES, TIMES, strict=True)]
    laws = {"rate": {"kind": "none"}, "relaxation": {"branches": branches}}
    time, vf, pressure = press(folder, "relaxation", laws, [down(0.6, "1000 mm/min"), {"hold": "60 s"}])
    slow = Exponential().pressure(vf, VF0)
    exact = slow + hereditary(time, slow)
    t = np.linspace(0.036, 60, 300)
    held = slow[-1] * (1 + sum(s * np.exp(-t / tau) for s, tau in zip(SHARES, TIMES, strict=True)))
    axes.plot(t, KPA * held, label="exact after a jump: p (1 + 0.3 exp(-t/2 s) + 0.2 exp(-t/30 s))")
    axes.axhline(KPA * slow[-1], color="grey", linestyle=":", label="slow loading")
    axes.plot(time, KPA * pressure, "o", color="C0", markersize=4, label="computed")
    worst.note("relaxation", pressure, exact)
    axes.set(title="Press, then hold", xlabel="time (s)", ylabel="pressure (kPa)")


def hereditary(time: np.ndarray, slow: np.ndarray) -> np.ndarray:
    """Sum of share integral exp(-(t - s)/tau) dp(s), for a pressure p piecewise linear in time."""
    total = np.zeros_like(slow)
    for share, tau in zip(SHARES, TIMES, strict=True):
        for n in range(1, len(time)):
            h = (time[n] - time[n - 1]) / tau
            piece = (slow[n] - slow[n - 1]) * -np.expm1(-h) / h
            total[n:] += share * piece * np.exp(-(time[n:] - time[n]) / tau)
    return total


def draw_unloading(axes: Any, folder: Path, worst: Worst) -> None:
    """Two cycles of pressing and lifting, over the closed form."""
    path = [down(0.5), down(-0.5), down(0.65), down(-0.65), down(0.6)]
    laws = {"rate": {"kind": "none"}, "unloading": {"set_share": SET, "exponent": EXPONENT}}
    _, vf, pressure = press(folder, "unloading", laws, path)
    largest = np.maximum.accumulate(vf)
    exact = np.array([unloading(v, top) for v, top in zip(vf, largest, strict=True)])
    curve = np.linspace(VF0, largest[-1], 300)
    axes.plot(curve, KPA * Exponential().pressure(curve, VF0), "k-", label="loading")
    for number_, top in enumerate(sorted({round(t, 6) for t in largest[pressure > 0]} & peaks(vf))):
        curve = np.linspace(VF0, top, 200)
        values = [KPA * max(unloading(v, top), 0) for v in curve]
        axes.plot(curve, values, "-", color=f"C{number_ + 1}", label=f"unloading and reloading from {top:.3f}")
    axes.plot(vf, KPA * pressure, "o", color="C0", markersize=3, label="computed")
    worst.note("unloading", pressure, np.maximum(exact, 0))
    axes.set(title="Unloading with permanent set", xlabel="fibre volume fraction", ylabel="pressure (kPa)")


def peaks(vf: np.ndarray) -> set[float]:
    """Vf at which pressing turned to lifting."""
    return {round(b, 6) for a, b, c in zip(vf, vf[1:], vf[2:], strict=False) if a < b > c}


def unloading(vf: float, top: float) -> float:
    """Pressure (Pa) below the largest Vf."""
    gain = top - VF0
    u = min(max((vf - VF0 - SET * gain) / max((1 - SET) * gain, 1e-12), 0.0), 1.0)
    return float(Exponential().pressure(vf - SET * gain * (1 - u**EXPONENT), VF0))


def draw_cycle(axes: Any, folder: Path) -> None:
    """All effects at once: closing speed, relaxation, set."""
    branches = [{"share": share, "time": f"{time} s"} for share, time in zip(SHARES, TIMES, strict=True)]
    laws = {"rate": {}, "relaxation": {"branches": branches}, "unloading": {}}
    path = [down(0.5), {"hold": "20 s"}, down(-0.3), down(0.45, "5 mm/min"), {"hold": "20 s"}, down(-0.7)]
    _, vf, pressure = press(folder, "cycle", laws, path)
    axes.plot(vf, KPA * pressure, "o-", markersize=3, label="press, hold, lift; press faster, hold, lift")
    curve = np.linspace(VF0, vf.max(), 100)
    axes.plot(curve, KPA * Exponential().pressure(curve, VF0), "k:", label="loading at the speed of the fit")
    axes.set(title="All together, local speed", xlabel="fibre volume fraction", ylabel="pressure (kPa)")


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


def draw_solids(axes: Any, folder: Path, worst: Worst) -> None:
    """A block of each solid, pressed with its sides held: stress over stretch."""
    mu, lame, bulk = 1 / 2.4, 0.2 / (1.2 * 0.6), 1 / 1.8  # MPa, at E = 1 MPa and nu = 0.2
    exact: dict[str, Callable[[np.ndarray], np.ndarray]] = {
        "logarithmic": lambda x: mu * (x - 1 / x) + lame * np.log(x) / x,
        "split": lambda x: mu * (2 / 3 * x ** (1 / 3) - 2 / 3 * x ** (-5 / 3)) + bulk * (x - 1),
    }
    sides = {"x_min": "symmetry", "y_min": "symmetry", "x_max": "symmetry", "y_max": "symmetry"}
    for kind, curve in exact.items():
        scene = Scene.read(HERE / "single_element.toml", [f"laws={{solid={{kind='{kind}'}}}}", "output.picture=false"])
        stack = scene.stack.model_copy(update={"sides": type(scene.stack.sides)(**sides)})
        result = run(scene.model_copy(update={"stack": stack}), folder / kind, overwrite=True)
        down_, over, force = (
            np.array([row[key] for row in result.history])
            for key in ("tool_displacement", "penetration_max", "tool_force")
        )
        stretch = 1 - (down_ - over) / scene.stack.thickness
        pressure = force / (scene.stack.size[0] * scene.stack.size[1] * stack.sides.copies) * MPA
        (line,) = axes.plot(fine := np.linspace(0.66, 1, 100), -curve(fine), label=kind)
        axes.plot(stretch, pressure, "o", color=line.get_color(), markersize=4)
        worst.note(f"{kind} solid", pressure, -curve(stretch))
    axes.set(title="Isotropic solids, sides held, E = 1 MPa", xlabel="thickness stretch", ylabel="pressure (MPa)")


def draw_bending(axes: Any, worst: Worst) -> None:
    """Bending rigidity of a layer over its bending modulus: work of the fibres bent to a cylinder."""
    moduli, curvature, thickness = np.geomspace(1e6, 242e9, 7), 1e-4, 2e-3
    computed = []
    for modulus in moduli:
        scene = Scene.read(
            HERE / "single_element.toml", [f"laws.bending.modulus={modulus} Pa", "stack.divisions=[8,1]"]
        )
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


def draw_permeability(axes: Any) -> None:
    """Permeability over Vf."""
    vf = np.linspace(VF0, 0.75, 200)
    for name, law in {"Gebart, hexagonal": Gebart(), "Kozeny-Carman": KozenyCarman()}.items():
        (line,) = axes.semilogy(vf, law.along(vf), label=f"{name}, along")
        axes.semilogy(vf, law.across(vf), "--", color=line.get_color(), label=f"{name}, across")
    for at, along, across in GEBART_1992:
        axes.plot([at, at], [along, across], "kx")
    axes.set(title="Permeability, fibre radius 3.6 um", xlabel="fibre volume fraction", ylabel="permeability (m$^2$)")


def main(folder: Path) -> Worst:
    """Run the elements, draw the figure, return the differences."""
    worst, figure = Worst(), Figure(figsize=(17, 15), layout="constrained")
    axes = figure.subplots(4, 3).ravel()
    draw_compaction(axes[0], folder, worst)
    draw_toe(axes[1])
    draw_rate(axes[2])
    draw_relaxation(axes[3], folder, worst)
    draw_unloading(axes[4], folder, worst)
    draw_cycle(axes[5], folder)
    draw_fibres(axes[6], worst)
    draw_printed(axes[7], worst)
    draw_shear(axes[8], worst)
    draw_permeability(axes[9])
    draw_solids(axes[10], folder, worst)
    draw_bending(axes[11], worst)
    for panel in axes:
        panel.grid(alpha=0.3)
        panel.legend(fontsize="small")
    if MPI.COMM_WORLD.rank == 0:
        FigureCanvasAgg(figure).print_png(folder / "laws.png")
        print(*(f"{name}: {value:.1e} from its closed form" for name, value in worst.of.items()), sep="\n")
    return worst


if __name__ == "__main__":
    target = Path(sys.argv[1] if len(sys.argv) > 1 else "results/laws")
    if max(main(target).of.values()) > 1e-6:
        sys.exit("a law differs from its closed form")
