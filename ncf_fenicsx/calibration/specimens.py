"""Compaction tests: what was pressed, how thick it was and under which pressure, from a raw file and what is given."""

from __future__ import annotations

import re
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import uniform_filter1d

from ncf_fenicsx.calibration.raw_files import RawTest
from ncf_fenicsx.errors import SceneError
from ncf_fenicsx.parameters.units import parse_number, parse_quantity

Floats = NDArray[np.float64]

GIVEN = {
    "layers": ("1", "layers lagen couches capas strati plies", "2"),
    "length": ("m", "length lange longueur longitud lunghezza", "152 mm"),
    "width": ("m", "width breite largeur ancho larghezza", "152 mm"),
    "area": ("m^2", "area flache surface aire", "23104 mm^2"),
    "thickness": ("m", "thickness dicke epaisseur espesor spessore", "4 mm"),
    "areal_density": ("kg/m^2", "areal grammage flachengewicht", "1425 g/m^2"),
    "fibre_density": ("kg/m^3", "fibre\\sdensity fiber\\sdensity faserdichte", "1.79e6 g/m^3"),
    "speed": ("m/s", "speed geschwindigkeit vitesse velocidad velocita", "1 mm/min"),
}
"""What a test may be given by a remark in its file or on the command line: SI unit, words, and an example."""
HOLD = 0.02
"""Speed over a test's largest below which it is held."""
WINDOW = 5
"""Rows that a speed is the mean over: differences of neighbours are noise."""


@dataclass(frozen=True)
class Machine:
    """What of the travel is not the specimen's.

    Attributes:
        compliance: travel of the machine itself over its force in m/N.
        slack: travel before the specimen is touched in m.
    """

    compliance: float = 0.0
    slack: float = 0.0


@dataclass(frozen=True)
class Compaction:
    """One compaction test.

    Attributes:
        name: for messages and legends.
        time: in s.
        apparent: thickness in m by the travel, that of the machine included.
        force: on the specimen in N.
        area: of the specimen in m2.
        initial_thickness: of the specimen in m, all layers together.
        layers: number.
        fibres: thickness in m that the fibres alone would have: areal density x layers over fibre density.
        areal_density: of a layer in kg/m2.
        fibre_density: in kg/m3.
    """

    name: str
    time: Floats
    apparent: Floats
    force: Floats
    area: float
    initial_thickness: float
    layers: int
    fibres: float
    areal_density: float
    fibre_density: float

    @property
    def pressure(self) -> Floats:
        """In Pa."""
        return np.asarray(self.force / self.area, dtype=np.float64)

    @property
    def initial_volume_fraction(self) -> float:
        """Vf0."""
        return self.fibres / self.initial_thickness

    def thickness(self, machine: Machine) -> Floats:
        """Thickness of the specimen in m."""
        return np.asarray(self.apparent + machine.compliance * self.force + machine.slack)

    def volume_fraction(self, machine: Machine) -> Floats:
        """Vf."""
        return np.asarray(self.fibres / self.thickness(machine), dtype=np.float64)

    def closing_speed(self, machine: Machine) -> Floats:
        """Closing speed of the specimen in m/s, mean over a few rows."""
        speed = -np.gradient(self.thickness(machine), self.time)
        return np.asarray(uniform_filter1d(speed, WINDOW, mode="nearest") if len(speed) > WINDOW else speed)

    @cached_property
    def speed(self) -> Floats:
        """That of the travel, the machine's included."""
        return self.closing_speed(Machine())

    @property
    def nominal_rate(self) -> float:
        """Closing speed over thickness in 1/s, of the fastest half of the press."""
        pressing = self.speed[self.speed > HOLD * self.speed.max()]
        return float(np.median(pressing) / self.initial_thickness)

    @property
    def has_hold(self) -> bool:
        """Whether the specimen is held at a thickness for a while."""
        held = np.abs(self.speed) < HOLD * self.speed.max()
        return bool(np.sum(np.gradient(self.time)[held & (self.pressure > 0.05 * self.pressure.max())]) > 0)

    @property
    def has_unloading(self) -> bool:
        """Whether it is opened again."""
        return bool(np.any(self.speed < -5 * HOLD * self.speed.max()))

    @property
    def loading(self) -> NDArray[np.bool_]:
        """Rows at which the specimen is thinner than ever before."""
        least = np.minimum.accumulate(self.apparent)
        return np.asarray((self.apparent <= least) & (self.speed > HOLD * self.speed.max()))


def given_values(texts: list[str]) -> dict[str, dict[str, float]]:
    """What ``KEY=VALUE`` or ``FILE:KEY=VALUE`` give, in SI, by file name; "" for all files.

    Raises:
        SceneError: no such key, or its value is no such quantity.
    """
    given: dict[str, dict[str, float]] = {}
    for text in texts:
        left, _, value = text.partition("=")
        file, _, key = left.rpartition(":")
        if key not in GIVEN:
            raise SceneError(f"--given {text}: expected one of {', '.join(GIVEN)}, such as layers=2")
        given.setdefault(file, {})[key] = _read(f"--given {text}", key, value)
    return given


def _read(where: str, key: str, text: str) -> float:
    symbol, _, example = GIVEN[key]
    value = parse_number(text) if symbol == "1" else parse_quantity(text.replace(",", "."), symbol)
    if value is None or value <= 0:
        raise SceneError(f"{where}: {key} = {text!r}: expected something like {example}")
    return value


def compaction_test(raw: RawTest, given: dict[str, dict[str, float]]) -> Compaction:
    """A compaction test of a raw file.

    Raises:
        SceneError: what the specimen was is not known, or the file has no force or no thickness.
    """
    known = _pressed(raw, given)
    force, travel = _signed(raw, known)
    layers = int(known.get("layers", 1))
    initial = known.get("thickness") or float(raw.columns.get("thickness", [0.0])[0])
    if not initial:
        raise SceneError(f"{raw.path}: no initial thickness; expected --given thickness='4 mm', of all layers together")
    apparent = raw.columns.get("thickness", initial - travel)
    areal, density = (_needed(raw, known, key) for key in ("areal_density", "fibre_density"))
    time = raw.columns.get("time")
    if time is None:
        time = np.abs(apparent - apparent[0]) / _needed(raw, known, "speed")
    order = np.concatenate([[True], np.diff(time) > 0])
    if np.any(np.diff(time) < 0):
        row = int(np.argmax(np.diff(time) < 0)) + 1
        raise SceneError(f"{raw.path}: line {raw.lines[row]}, column time = {time[row]:g} s: expected times that grow")
    fibres = layers * areal / density
    _check_press(raw, apparent, force, fibres)
    return Compaction(
        name=raw.name,
        time=time[order],
        apparent=apparent[order],
        force=force[order],
        area=known["area"],
        initial_thickness=initial,
        layers=layers,
        fibres=fibres,
        areal_density=areal,
        fibre_density=density,
    )


def _check_press(raw: RawTest, apparent: Floats, force: Floats, fibres: float) -> None:
    """Refuse what is no press: no force, no closing, or a thickness that the fibres alone would not fit in."""
    if force.max() <= 0 or apparent.min() >= apparent[0]:
        what = "force" if force.max() <= 0 else "thickness"
        raise SceneError(f"{raw.path}: {raw.name}: {what} does not change; expected a test that presses")
    if apparent.min() <= fibres:
        row = int(np.argmax(apparent <= fibres))
        raise SceneError(
            f"{raw.path}: line {raw.lines[row]}: a thickness of {1e3 * apparent[row]:.4g} mm, and fibres of "
            f"{1e3 * fibres:.4g} mm; expected Vf below 1: other layers, areal density or initial thickness"
        )


def specimen(raw: RawTest, given: dict[str, dict[str, float]], needed: tuple[str, ...] = ()) -> dict[str, float]:
    """What is known of a specimen in SI: from its file, overridden by what is given for all, and for its file.

    Raises:
        SceneError: a remark is no such quantity, or what is needed is not known.
    """
    known: dict[str, float] = {}
    for key, (_, words, _) in GIVEN.items():
        for name, text in raw.remarks.items():
            if any(re.search(rf"\b{word}\b", name) for word in words.split()):
                known.setdefault(key, _read(f"{raw.path}: {name}", key, text))
    known |= given.get("", {}) | given.get(raw.path.name, {})
    for key in needed:
        _needed(raw, known, key)
    return known


def _pressed(raw: RawTest, given: dict[str, dict[str, float]]) -> dict[str, float]:
    """The same with the area that is pressed."""
    known = specimen(raw, given)
    if "area" not in known and {"length", "width"} <= set(known):
        known["area"] = known["length"] * known["width"]
    if "pressure" in raw.columns:
        known.setdefault("area", 1.0)
    if "area" not in known:
        raise SceneError(f"{raw.path}: no size of a specimen; expected --given area='23104 mm^2', or length, width")
    return known


def _needed(raw: RawTest, known: dict[str, float], key: str) -> float:
    if key not in known:
        raise SceneError(f"{raw.path}: no {key.replace('_', ' ')}; expected --given {key}='{GIVEN[key][2]}'")
    return known[key]


def _signed(raw: RawTest, known: dict[str, float]) -> tuple[Floats, Floats]:
    """Force in N and travel in m, both positive in compaction whatever the machine's signs."""
    columns = raw.columns
    force = columns["force"] if "force" in columns else columns.get("pressure", np.zeros(0)) * known["area"]
    if not len(force) or not {"travel", "thickness"} & set(columns):
        found = ", ".join(columns)
        raise SceneError(f"{raw.path}: has {found}; expected force or pressure, with travel or thickness")
    travel = columns.get("travel", np.zeros(len(force)))
    largest = int(np.argmax(np.abs(force)))
    travel = travel - travel[0]
    return force * np.sign(force[largest] or 1.0), travel * np.sign(travel[largest] or 1.0)
