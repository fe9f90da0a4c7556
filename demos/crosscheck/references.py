"""Write the kit's files from its scenes: a neutral ``case.json``, and reference histories with error bars.

Run: ``docker/run python3 demos/crosscheck/references.py [--check] [CASE ...]``; with ``--check`` nothing is written:
each case is run again with steps 8 times finer, and all of its values must lie within the bars.

A reference is that of steps 16 times finer than 30 a piece of the path, with penalties 16 times larger than those of
steps 4 times finer. Its bar is the difference of these two, which is at least three times what is yet to come where the
error falls at least with the first power of the step; and no less than a millionth of the column's largest size.
"""

import argparse
import csv
import json
import re
import sys
import tempfile
from pathlib import Path

import numpy as np

from ncf_fenicsx import Scene, run
from ncf_fenicsx.report.reading import read_history

HERE = Path(__file__).parent
STEPS, COARSE, CHECK, FINE = 30, 4, 8, 16
LEAST_BAR = 1e-6
"""Share of a column's largest size: what round-off and Newton's tolerance may leave."""
PENALTY = 2000.0
"""Factor on the layer's own stiffness at the coarse level."""
SETTLED = 0.05
"""Share of a piece after a jump of the force in which a history is not judged: it may be sampled on either side."""
SPEEDS = {f"element_{speed}_mm_min": [f"tool.path.0.speed='{speed} mm/min'"] for speed in (1, 2, 5)}
HISTORIES = {"element": SPEEDS, "hold": {"hold": []}, "unloading": {"unloading": []}, "column": {"column": []}}
"""Histories of each case, with what they replace in its scene."""
JUDGED = ("tool_force", "vf_mean", "vf_mean_layer_1", "vf_mean_layer_2", "vf_mean_layer_3", "vf_mean_layer_4")
FORMULAS = {
    "volume_fraction": "Vf = Vf0 / lambda, lambda the thickness of a layer over its undeformed thickness",
    "compaction": "p(Vf) = s(Vf) - s(Vf0), s(Vf) = beta1^(beta2 Vf - beta3) + beta4, in Pa per undeformed area",
    "rate": "factor A(v) / A(v_ref) on the positive pressure of loading or unloading; "
    "A(v) = R - (alpha1 (v / v_ref)^alpha2 + (R - 1)^-alpha3)^(-1/alpha3), R = sigma_inf / sigma_0; v = 0 in opening; "
    "feed 'process': v is the speed of the plate downwards; "
    "feed 'local': v = reference_thickness * -d(lambda)/dt of each layer",
    "relaxation": "adds the sum of share e, de/dt + e / time = dp/dt, p the pressure of loading without the rate "
    "factor; none at the start, and where a stack rests under its weight",
    "unloading": "p(Vf - c D (1 - u^m)), D = Vf_max - Vf0, Vf_max the largest Vf so far, u = (Vf - Vf0 - c D) / "
    "((1 - c) D), cut to 0..1; c is set_share, m is exponent",
    "in_plane": "nothing moves in the plane: no law acts there in these cases",
}
BOUNDARIES = [
    "the bottom rests on a rigid plane and stays on it",
    "a rigid plate without friction presses on the top; it cannot pull",
    "layers touch without friction; in this case they never part",
    "the sides are free, and do not move",
]


def scenes(case):
    """Scene of each history of a case."""
    return {name: Scene.read(HERE / case / "scene.toml", changes) for name, changes in HISTORIES[case].items()}


def neutral(case):
    """What another code has to know of a case, in SI."""
    named = scenes(case)
    scene = next(iter(named.values()))
    laws = numbers(scene.laws.model_dump(mode="json", exclude_none=True))
    used = [name for name in ("compaction", "rate", "relaxation", "unloading") if name in laws]
    stack = scene.stack
    return {
        "title": scene.title,
        "units": "SI",
        "layers": stack.layers,
        "thickness": stack.thickness,
        "area": stack.size[0] * stack.size[1] * stack.sides.copies,
        "initial_volume_fraction": stack.initial_volume_fraction,
        "mass_per_area_of_a_layer": stack.areal_density,
        "gravity": scene.gravity,
        "laws": {name: {"formula": FORMULAS[name], **laws[name]} for name in used},
        "formulas": {name: FORMULAS[name] for name in ("volume_fraction", "in_plane")},
        "boundary_conditions": BOUNDARIES,
        "start": "at rest under its own weight; the plate is at the top of the undeformed stack",
        "may_be_left_out": "inertia; the plane of the fibres; transverse shear; friction; opening of layers",
        "judged": [name for name in JUDGED if stack.layers > 1 or "layer" not in name],
        "tolerance": 0.005,
        "histories": {name: history(one) for name, one in named.items()},
    }


def numbers(values):
    """The same with quantities as numbers; a scene writes them in SI with their unit."""
    if isinstance(values, dict):
        return {key: numbers(value) for key, value in values.items()}
    if isinstance(values, list):
        return [numbers(value) for value in values]
    quantity = re.fullmatch(r"([-+.\de]+) \S+", values) if isinstance(values, str) else None
    return float(quantity[1]) if quantity else values


def history(scene):
    """Path of the plate, and times that are not judged: just after the force jumps with the speed."""
    pieces = [
        {"down": -piece.travel[2] if piece.travel else 0.0, "duration": piece.duration} for piece in scene.segments
    ]
    ends = np.cumsum([piece["duration"] for piece in pieces]).tolist()
    jumps = [] if scene.laws.rate.kind == "none" else list(zip(ends[:-1], pieces[1:], strict=True))
    return {"path": pieces, "not_judged": [[end, end + SETTLED * piece["duration"]] for end, piece in jumps]}


def computed(case, name, level, folder):
    """Columns of the history of a level, by name."""
    shortest = min(piece.duration for piece in scenes(case)[name].segments)
    penalty = PENALTY * level / COARSE
    changes = [
        *HISTORIES[case][name],
        f"tool.penalty={penalty}",
        f"solver.first_step='{shortest / STEPS!r} s'",
        f"solver.largest_step='{shortest / STEPS!r} s'",
        f"solver.step_refinement={level}",
        "solver.time_tolerance=1",
        "solver.force_tolerance=1e-10",
        "solver.max_steps=100000",
        "output.picture=false",
        "output.report=false",
        "output.fields_every=100000",
    ]
    if case == "column":
        changes.append(f"interface.penalty={penalty}")
    result = run(Scene.read(HERE / case / "scene.toml", changes), folder / f"{name}_{level}")
    assert result.done, result.reason
    return read_history(result.folder / "history.csv")


def reference(case, name, folder):
    """Columns of a reference: values of the fine level at the times of the coarse one, and their bars."""
    coarse, fine = (computed(case, name, level, folder) for level in (COARSE, FINE))
    columns = {"time": coarse["time"], "tool_displacement": coarse["tool_displacement"]}
    for column in neutral(case)["judged"]:
        values = np.interp(coarse["time"], fine["time"], fine[column])
        columns[column] = values
        columns[f"{column}_bar"] = np.abs(values - coarse[column]) + LEAST_BAR * np.abs(values).max()
    return columns


def write(case, folder):
    """Write the files of a case."""
    (HERE / case / "case.json").write_text(json.dumps(neutral(case), indent=2) + "\n", encoding="utf-8")
    for name in HISTORIES[case]:
        columns = reference(case, name, folder)
        with (HERE / case / f"{name}.csv").open("w", newline="", encoding="utf-8") as file:
            writer = csv.writer(file, lineterminator="\n")
            writer.writerow(columns)
            writer.writerows([f"{value:.9g}" for value in row] for row in zip(*columns.values(), strict=True))
        worst = {
            key[:-4]: float(columns[key].max() / np.abs(columns[key[:-4]]).max()) for key in columns if "_bar" in key
        }
        print(name, *(f"{key}: bar {100 * share:.2g} % at most" for key, share in worst.items()), sep="; ")


def repeats(case, name, folder):
    """Whether a run with steps 8 times finer gives each value of a reference within its bar."""
    stored = read_history(HERE / case / f"{name}.csv")
    again = computed(case, name, CHECK, folder)
    judged = neutral(case)["judged"]
    off = {key: np.abs(np.interp(stored["time"], again["time"], again[key]) - stored[key]) for key in judged}
    shares = {key: float((off[key] / stored[f"{key}_bar"]).max()) for key in judged}
    print(name, *(f"{key}: {share:.3f} bars off at most" for key, share in shares.items()), sep="; ")
    return max(shares.values()) <= 1.01  # written to nine digits


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("cases", nargs="*", metavar="CASE", help=", ".join(HISTORIES))
    parser.add_argument("--check", action="store_true", help="run again and hold against the bars")
    words = parser.parse_args()
    with tempfile.TemporaryDirectory() as place:
        for chosen in words.cases or HISTORIES:
            if not words.check:
                write(chosen, Path(place))
            elif not all(repeats(chosen, name, Path(place)) for name in HISTORIES[chosen]):
                sys.exit(f"{chosen}: a value is not within its bar")
