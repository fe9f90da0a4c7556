"""Panels of ``laws.py`` for which one hexahedron is pressed by a plate, over closed forms."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from laws_compared import Worst
from scipy.interpolate import PchipInterpolator

from ncf_fenicsx import Scene, run
from ncf_fenicsx.laws.compaction import Exponential

SCENE = Path(__file__).parents[1] / "single_element.toml"
KPA, MPA = 1e-3, 1e-6
VF0 = Scene.read(SCENE).stack.initial_volume_fraction
SHARES, TIMES = (0.3, 0.2), (2.0, 30.0)
SET, EXPONENT = 0.5, 3.0
POINTS = (0.38, 0.40, 0.42, 0.46, 0.50, 0.55, 0.60, 0.65), (-350, 45, 605, 2527, 6396, 17142, 42908, 104689)
TABLE = PchipInterpolator(*POINTS)


def rounded(vf: np.ndarray) -> np.ndarray:
    """Vf - Vf0 with a hyperbola of width 0.005 at its corner."""
    return (vf - VF0 + np.hypot(vf - VF0, 0.01)) / 2


CURVES: dict[str, Callable[[np.ndarray], np.ndarray]] = {
    "exponential": lambda vf: 96605 ** (1.5238 * vf + 0.0176) - 96605 ** (1.5238 * VF0 + 0.0176),
    "power": lambda vf: 6.97455e6 * (vf**9.93265 - VF0**9.93265),
    "offset_power": lambda vf: (225.8515 * rounded(vf)) ** 2.791795 - (225.8515 * 0.005) ** 2.791795,
    "gutowski": lambda vf: 107.906 * (np.sqrt(vf / VF0) - 1) / (np.sqrt(0.8 / vf) - 1) ** 4,
    "table": lambda vf: TABLE(vf) - TABLE(VF0),
}
"""The default of each compaction law, written out once more."""


def press(folder: Path, name: str, laws: dict[str, Any], path: list[dict[str, Any]]) -> tuple[np.ndarray, ...]:
    """Time (s), Vf and pressure (Pa) of one hexahedron under a plate on a path."""
    base = Scene.read(SCENE)
    table = base.table() | {"laws": laws, "output": {"picture": False, "report": False, "fields_every": 1000}}
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
    for kind, curve in CURVES.items():
        (line,) = axes.plot(vf, KPA * curve(vf), label=kind.replace("_", " "))
        _, at, pressure = press(folder, kind, {"compaction": {"kind": kind}, "rate": {"kind": "none"}}, [down(0.7)])
        axes.plot(at, KPA * pressure, "o", color=line.get_color(), markersize=3)
        worst.note(kind, pressure, curve(at))
    axes.set(title="Compaction: laws at the speed of the fit", xlabel="fibre volume fraction", ylabel="pressure (kPa)")


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


def draw_solids(axes: Any, folder: Path, worst: Worst) -> None:
    """A block of each solid, pressed with its sides held: stress over stretch."""
    mu, lame, bulk = 1 / 2.4, 0.2 / (1.2 * 0.6), 1 / 1.8  # MPa, at E = 1 MPa and nu = 0.2
    exact: dict[str, Callable[[np.ndarray], np.ndarray]] = {
        "logarithmic": lambda x: mu * (x - 1 / x) + lame * np.log(x) / x,
        "split": lambda x: mu * (2 / 3 * x ** (1 / 3) - 2 / 3 * x ** (-5 / 3)) + bulk * (x - 1),
    }
    sides = {"x_min": "symmetry", "y_min": "symmetry", "x_max": "symmetry", "y_max": "symmetry"}
    for kind, curve in exact.items():
        scene = Scene.read(SCENE, [f"laws={{solid={{kind='{kind}'}}}}", "output.picture=false", "output.report=false"])
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
