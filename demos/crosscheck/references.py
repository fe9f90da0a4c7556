"""Write the kit's files from its scenes: a neutral ``case.json``, and reference histories with error bars.

Run: ``docker/run python3 demos/crosscheck/references.py [--check] [CASE ...]``; with ``--check`` nothing is written:
each case is run again at a level between the two of its reference, and all of its values must lie within the bars.

A reference is a run of a fine level; its bar is the difference from a coarse one, and no less than a millionth of the
column's largest size. Where nothing moves in the plane, steps are 4 and 16 times finer than 30 a piece of the path, and
penalties grow as they shrink. Elsewhere elements and steps are halved and penalties doubled from one level to the
other; a bar is then 1.5 times the largest difference so far, for two histories may cross.
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
"""Share of a column's largest size that round-off may leave."""
FIRST_ORDER = 1.5
"""Factor on a difference by the mesh, whose error may fall with the first power of the elements' size alone."""
PENALTY = 2000.0
"""Factor on the layer's own stiffness at the coarse level."""
SETTLED = 0.05
"""Share of a piece after a jump of the force in which a history is not judged: it may be sampled on either side."""
FIELDS = {
    "long_roller": ("tool_force", "vf_mean", "vf_max"),
    "finite_roller": ("tool_force", "vf_mean", "vf_max"),
    "sliding": ("tool_force", "tool_force_x", "mould_force_x", "slip_max_1"),
    "ruck": ("support_force_x", "wrinkle_height_1"),
}
"""Cases where layers move in the plane too, with the columns that are judged."""
REST = 5.0
"""Time in s at the end of a ruck's path in which it is judged: before, it snaps up and comes to rest."""
SPEEDS = {f"element_{speed}_mm_min": [f"tool.path.0.speed='{speed} mm/min'"] for speed in (1, 2, 5)}
HISTORIES = {"element": SPEEDS, "hold": {"hold": []}, "unloading": {"unloading": []}, "column": {"column": []}} | {
    case: {case: []} for case in FIELDS
}
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
    "in_plane": "of the fibres, isotropic: W = mu/2 (C11 + C22 - 2 - ln det C) + lambda/8 (ln det C)^2 of the 2 x 2 "
    "stretches C in the plane of the layer, lambda and mu of plane stress from modulus and poisson",
    "shear": "modulus times the transverse shear strain 2 E_13, 2 E_23",
    "bending": "in place of what the in_plane law of a solid sheet would give: modulus h^3 / 12 / (1 - poisson^2) per "
    "width on the curvature of the mid-plane",
}
BOUNDARIES = [
    "the bottom rests on a rigid plane and stays on it",
    "a rigid plate without friction presses on the top; it cannot pull",
    "layers touch without friction; in this case they never part",
    "the sides are free, and do not move",
]


CONTACTS = [
    "layers, tools and moulds are rigid to each other: no penetration, and no pull but that of the stitches",
    "stitches: a spring on the opening of two layers, yarn_stiffness / (yarn_length pitch_x pitch_y) in Pa/m",
    "friction is Coulomb's: coefficient times the pressure, against the slip",
    "a cylinder lies along y, width long about its position, with sharp ends; a presser foot is flat, its edges "
    "rounded with the radius edge; both start on the top of the undeformed stack",
    "a side of symmetry is a plane of mirror images, a fixed side moves nowhere, a free side is free",
]


def scenes(case):
    """Scene of each history of a case."""
    return {name: Scene.read(HERE / case / "scene.toml", changes) for name, changes in HISTORIES[case].items()}


def neutral(case):
    """What another code has to know of a case, in SI."""
    named, scene = scenes(case), next(iter(scenes(case).values()))
    laws, stack = numbers(scene.laws.model_dump(mode="json", exclude_none=True)), scene.stack
    laws = {name: {"formula": FORMULAS[name], **laws[name]} for name in used_laws(case, laws)}
    return {
        "title": scene.title,
        "units": "SI",
        "uniform": case not in FIELDS,
        "layers": stack.layers,
        "thickness": stack.thickness,
        "area": stack.size[0] * stack.size[1] * stack.sides.copies,
        "initial_volume_fraction": stack.initial_volume_fraction,
        "mass_per_area_of_a_layer": stack.areal_density,
        "gravity": scene.gravity,
        "laws": laws,
        **(geometry(scene) if case in FIELDS else UNIFORM),
        "judged": list(judged(case)),
        "tolerance": 0.01 if case in FIELDS else 0.005,
        "histories": {name: history(one, case) for name, one in named.items()},
    }


def judged(case):
    """Columns of a case that count."""
    layers = next(iter(scenes(case).values())).stack.layers
    return FIELDS.get(case) or [name for name in JUDGED if layers > 1 or "layer" not in name]


def used_laws(case, laws):
    """Names of the laws that another code needs for a case."""
    names = ("compaction", "rate", "relaxation", "unloading")
    return [name for name in (*names, *(("in_plane", "shear", "bending") if case in FIELDS else ())) if name in laws]


UNIFORM = {
    "formulas": {
        "volume_fraction": FORMULAS["volume_fraction"],
        "in_plane": "nothing moves in the plane: no law acts there in these cases",
    },
    "boundary_conditions": BOUNDARIES,
    "start": "at rest under its own weight; the plate is at the top of the undeformed stack",
    "may_be_left_out": "inertia; the plane of the fibres; transverse shear; friction; opening of layers",
}


def geometry(scene):
    """What a case has beside laws where layers move in the plane: sizes, sides, tools, contact, elements."""
    table = numbers(scene.model_dump(mode="json", exclude_none=True))
    stack = table["stack"]
    tool = table["tool"]
    kept = {
        key: tool[key] for key in ("kind", "radius", "width", "size", "edge", "position", "friction") if key in tool
    }
    return {
        "modelled_size": stack["size"],
        "sides": stack["sides"],
        "forces_are_those_of": f"the modelled part and its mirror images: {scene.stack.sides.copies} times the part",
        "through": "one element through each layer, displacements linear across it, is part of the case",
        "mesh": "mesh.msh and mesh.inp are the coarse mesh, elements through a layer included",
        "interface": without_stiffness(
            {key: value for key, value in table["interface"].items() if key not in ("penalty", "contact")}
        ),
        "tool": without_stiffness(kept),
        "mould": without_stiffness({key: table["mould"][key] for key in ("kind", "friction") if key in table["mould"]})
        if "mould" in table
        else "a rigid plane that holds the bottom down, without friction",
        "formulas": {"volume_fraction": FORMULAS["volume_fraction"]},
        "boundary_conditions": CONTACTS,
        "start": "at rest under its own weight; the tool touches the top of the undeformed stack",
        "may_be_left_out": "inertia; weight in the sliding case, which has none",
    }


def without_stiffness(part):
    """The same without the stiffness of sticking friction, which is a means of this program's."""
    friction = part.get("friction")
    return part | ({"friction": {"coefficient": friction["coefficient"]}} if friction else {})


def numbers(values):
    """The same with quantities as numbers; a scene writes them in SI with their unit."""
    if isinstance(values, dict):
        return {key: numbers(value) for key, value in values.items()}
    if isinstance(values, list):
        return [numbers(value) for value in values]
    quantity = re.fullmatch(r"([-+.\de]+) \S+", values) if isinstance(values, str) else None
    return float(quantity[1]) if quantity else values


def history(scene, case):
    """Path of the tool, and times that are not judged: after the force jumps with the speed, before a ruck rests."""
    pieces = [
        {"down": 0.0 - piece.travel[2] if piece.travel else 0.0, "duration": piece.duration}
        | ({"along_x": piece.travel[0] if piece.travel else 0.0} if case in FIELDS else {})
        for piece in scene.segments
    ]
    ends = np.cumsum([piece["duration"] for piece in pieces]).tolist()
    jumps = [] if scene.laws.rate.kind == "none" else list(zip(ends[:-1], pieces[1:], strict=True))
    skipped = [[end, end + SETTLED * piece["duration"]] for end, piece in jumps]
    return {"path": pieces, "not_judged": [[0.0, ends[-1] - REST]] if case == "ruck" else skipped}


def level_of_time(case, name, level):
    """Settings of a level of a case where nothing moves in the plane."""
    shortest = min(piece.duration for piece in scenes(case)[name].segments)
    penalty = PENALTY * level / COARSE
    step = f"'{shortest / STEPS!r} s'"
    changes = [f"tool.penalty={penalty}", f"solver.first_step={step}", f"solver.largest_step={step}"]
    changes += [f"solver.step_refinement={level}", "solver.time_tolerance=1", "solver.force_tolerance=1e-10"]
    return changes + ([f"interface.penalty={penalty}"] if case == "column" else [])


def level_of_space(case, name, level):
    """Settings of a level elsewhere: elements and steps by the square root of a level's fineness, and penalties."""
    scene, finer = scenes(case)[name], (level / COARSE) ** 0.5
    more = finer if scene.stack.nodes is None else np.ceil(finer)  # of given nodes all are kept: one is at a tool's end
    divisions = [round(more * count) if count > 1 else 1 for count in scene.stack.divisions_by_layer[0]]
    changes = [f"stack.divisions={divisions}"]
    if scene.stack.nodes is not None:
        nodes = [
            [
                f"{place:.9g} m"
                for place in np.interp(np.linspace(0, len(given) - 1, count + 1), range(len(given)), given)
            ]
            for count, given in zip(divisions, scene.stack.nodes, strict=True)
        ]
        changes = [f"stack.nodes={nodes}"]
    changes += [f"solver.step_refinement={2 if level == COARSE else 4}"]
    changes += [f"tool.penalty={2000 * finer}", *([f"mould.penalty={2000 * finer}"] if scene.mould else [])]
    if case == "sliding":
        stiff = f"friction={{coefficient=0.5,stiffness={10 * finer}}}"
        changes += [f"tool.{stiff}", f"mould.{stiff}"]
        changes += [f"interface.friction={{coefficient=0.2,stiffness={10 * finer}}}"]
    return changes + ([f"interface.penalty={100 * finer}"] if scene.stack.layers > 1 else [])


def computed(case, name, level, folder):
    """Columns of the history of a level, by name."""
    changes = [
        *HISTORIES[case][name],
        *(level_of_space if case in FIELDS else level_of_time)(case, name, level),
        "solver.max_steps=100000",
        "output.picture=false",
        "output.report=false",
        "output.fields_every=100000",
    ]
    result = run(Scene.read(HERE / case / "scene.toml", changes), folder / f"{name}_{level}")
    assert result.done, result.reason
    return read_history(result.folder / "history.csv")


def skipped(case, name, times):
    """Which times are not judged, nor have a bar that tells anything: those before a ruck rests."""
    not_judged = history(scenes(case)[name], case)["not_judged"] if case == "ruck" else []
    return np.any([np.zeros(len(times)), *((times >= start) & (times < end) for start, end in not_judged)], axis=0)


def reference(case, name, folder):
    """Columns of a reference: values of the fine level at the times of the coarse one, and their bars."""
    coarse, fine = (computed(case, name, level, folder) for level in (COARSE, FINE))
    columns = {"time": coarse["time"], "tool_displacement": coarse["tool_displacement"]}
    for column in judged(case):
        values = np.interp(coarse["time"], fine["time"], fine[column])
        off = np.abs(values - coarse[column])
        if case in FIELDS:
            so_far = np.maximum.accumulate(np.where(skipped(case, name, coarse["time"]), 0.0, off))
            off = FIRST_ORDER * np.maximum(off, so_far)
        columns[column] = values
        columns[f"{column}_bar"] = off + LEAST_BAR * np.abs(values).max()
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
        kept = ~skipped(case, name, columns["time"])
        worst = {
            key[:-4]: columns[key][kept].max() / np.abs(columns[key[:-4]]).max() for key in columns if "_bar" in key
        }
        print(name, *(f"{key}: bar {100 * share:.2g} % at most" for key, share in worst.items()), sep="; ")


def repeats(case, name, folder):
    """Whether a run at a level between gives each value of a reference within its bar."""
    stored = read_history(HERE / case / f"{name}.csv")
    again = computed(case, name, CHECK, folder)
    left_out = skipped(case, name, stored["time"])
    off = {key: np.abs(np.interp(stored["time"], again["time"], again[key]) - stored[key]) for key in judged(case)}
    shares = {key: float((off[key] / stored[f"{key}_bar"])[~left_out].max()) for key in judged(case)}
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
