"""An explicit code of its own for the cross-check, to show how another one takes part: numpy and ``case.json`` alone.

Run: ``python3 demos/crosscheck/march.py OUT [LAW.CONSTANT=FACTOR ...]``, then ``ncf-fenicsx crosscheck OUT``. A factor
changes a constant of a law in all cases, as ``compaction.beta2=1.05``: the judge has to see it.

Layers are a chain of masses, marched by central differences with damping. Its files have names and units of its own.
"""

import csv
import json
import sys
from pathlib import Path

import numpy as np

SAFETY, STIFFEST, DAMPING, LAG = 0.4, 2e7, 0.5, 0.1
"""Step over the stable one; modulus in Pa that it is for; damping over that of the slowest swing of soft fabric; time
in s over which the speed of a layer is averaged, without which the rate law would ask for far smaller steps."""
STEPS, ROWS = 30_000, 150
COLUMNS = {
    "t (ms)": "time [ms]",
    "plate (mm)": "tool_displacement [mm]",
    "RF3 (kN)": "-tool_force [kN]",
    "vf": "vf_mean",
    **{f"vf {number}": f"vf_mean_layer_{number}" for number in (1, 2, 3, 4)},
}


class Fabric:
    """The laws of a case for all of its layers at once, with what they remember."""

    def __init__(self, case):
        self.laws, self.vf0 = case["laws"], case["initial_volume_fraction"]
        count = case["layers"]
        self.old, self.largest = np.full(count, self.vf0), np.full(count, self.vf0)
        branches = self.laws.get("relaxation", {}).get("branches", [])
        self.branches, self.ahead, self.speed = branches, np.zeros((len(branches), count)), np.zeros(count)

    def loading(self, vf):
        """Pressure of monotone loading in Pa."""
        law = self.laws["compaction"]
        curve = [law["beta1"] ** (law["beta2"] * one - law["beta3"]) for one in (vf, self.vf0)]
        return curve[0] - curve[1]

    def slow(self, vf):
        """Pressure in Pa of loading and unloading at rest."""
        law = self.laws.get("unloading")
        if law is None:
            return self.loading(vf)
        self.largest = np.maximum(self.largest, vf)
        gain, c = self.largest - self.vf0, law["set_share"]
        u = np.clip((vf - self.vf0 - c * gain) / np.maximum((1 - c) * gain, 1e-12), 0, 1)
        return self.loading(vf - c * gain * (1 - u ** law["exponent"]))

    def rate(self, speed):
        """Factor at a speed in m/s, over that at the speed of the fit."""
        law = self.laws["rate"]
        if law["kind"] == "none":
            return 1.0
        ratio = law["sigma_inf"] / law["sigma_0"]
        inner = (
            law["alpha1"] * (np.array([*np.atleast_1d(speed), law["v_ref"]]).clip(0) / law["v_ref"]) ** law["alpha2"]
        )
        growth = ratio - (inner + (ratio - 1) ** -law["alpha3"]) ** (-1 / law["alpha3"])
        return growth[:-1] / growth[-1]

    def pressure(self, vf, dt, plate_speed):
        """Pressure in Pa after a step; ``dt`` None for a stack at rest, where all that relaxes has relaxed."""
        law, speed, slow = self.laws["rate"], np.zeros_like(vf), self.slow(vf)
        if dt is not None and law.get("feed") == "process":
            speed = np.full_like(vf, plate_speed)
        elif dt is not None and law.get("feed") == "local":
            raw = law["reference_thickness"] * self.vf0 * (1 / self.old - 1 / vf) / dt
            self.speed = speed = self.speed + (raw - self.speed) * dt / LAG
        at_rest = self.rate(np.zeros_like(vf))
        total = at_rest * slow + (self.rate(speed) - at_rest) * np.maximum(slow, 0)
        for number, branch in enumerate(self.branches if dt is not None else ()):
            half = dt / branch["time"] / 2
            gain = self.loading(vf) - self.loading(self.old)
            self.ahead[number] = ((1 - half) * self.ahead[number] + gain) / (1 + half)
            total = total + branch["share"] * self.ahead[number]
        self.old = vf
        return total


def march(case, path):
    """Rows of a history: time, plate, force, mean Vf, Vf of the layers, in the units of ``COLUMNS``."""
    count, h, fabric = case["layers"], case["thickness"], Fabric(case)
    duration = sum(piece["duration"] for piece in path)
    dt = duration / STEPS
    mass = STIFFEST / h * (dt / SAFETY) ** 2  # per area: as much as the step is stable with, far more than the real one
    damping = DAMPING * np.sqrt(1e4 / h / mass) / count
    weight = case["mass_per_area_of_a_layer"] * case["gravity"]
    loads = weight * np.array([*np.ones(count - 1), 0.5])  # half of a layer's weight at each of its faces
    undeformed = h * np.arange(1, count + 1)
    z, v = undeformed.copy(), np.zeros(count)

    def step(dt_laws, plate, plate_speed):
        """Move the upper faces of the layers; pressure of the plate in Pa."""
        nonlocal z, v
        vf = fabric.vf0 * h / np.diff(z, prepend=0.0)
        p = fabric.pressure(vf, dt_laws, plate_speed)
        force = p - np.append(p[1:], 0.0) - loads
        half = damping * dt / 2
        v = (v * (1 - half) + dt * force / mass) / (1 + half)
        too_fast = 0.0 if plate is None else max(v[-1] - (plate - z[-1]) / dt, 0.0)
        v[-1] -= too_fast
        pushed = mass * (1 + half) * too_fast / dt
        z = z + dt * v
        return pushed, vf

    for _ in range(STEPS if weight else 0):
        step(None, None, 0.0)
    v[:], rows, time, travelled, every = 0.0, [], 0.0, 0.0, STEPS // ROWS
    for piece in path:
        speed, steps = piece["down"] / piece["duration"], round(piece["duration"] / dt)
        for number in range(1, steps + 1):
            time, travelled = time + dt, travelled + speed * dt
            pushed, vf = step(dt, undeformed[-1] - travelled, speed)
            if number % every == 0:
                force, mean = case["area"] * pushed, vf.mean()
                rows.append([1e3 * time, 1e3 * travelled, -1e-3 * force, mean, *vf])
    return rows


def main(out, factors):
    """March all cases of the kit."""
    out.mkdir(parents=True, exist_ok=True)
    lines = [f'"{name}" = "{meaning}"' for name, meaning in COLUMNS.items()]
    (out / "columns.toml").write_text("\n".join(lines) + "\n", encoding="utf-8")
    for file in sorted(Path(__file__).parent.glob("*/case.json")):
        case = json.loads(file.read_text(encoding="utf-8"))
        if not case["uniform"]:
            continue
        for key, factor in factors.items():
            law, constant = key.split(".")
            places = case["laws"].get(law, {})
            for place in (places, *places.get("branches", [])):
                if constant in place:
                    place[constant] *= factor
        for name, history in case["histories"].items():
            with (out / f"{name}.csv").open("w", newline="", encoding="utf-8") as written:
                writer = csv.writer(written)
                writer.writerow(list(COLUMNS)[: 4 + case["layers"]])
                writer.writerows(march(case, history["path"]))


if __name__ == "__main__":
    main(Path(sys.argv[1]), {key: float(value) for key, value in (word.split("=") for word in sys.argv[2:])})
