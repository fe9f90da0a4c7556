"""Files of testing machines to a fabric: which laws, their fit, and what it comes to in words."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from itertools import combinations
from pathlib import Path

import numpy as np
from scipy.optimize import isotonic_regression

from ncf_fenicsx.calibration.cantilever import fit_shape
from ncf_fenicsx.calibration.curve_laws import CurveFit, family_of, fit_curve
from ncf_fenicsx.calibration.fitting import Fit, Weight, fit_compaction
from ncf_fenicsx.calibration.free_parameters import free_of
from ncf_fenicsx.calibration.histories import Laws
from ncf_fenicsx.calibration.raw_files import RawTest, read_tests
from ncf_fenicsx.calibration.specimens import Compaction, Machine, compaction_test
from ncf_fenicsx.errors import SceneError
from ncf_fenicsx.laws.law import Law, Measured
from ncf_fenicsx.laws.monotone_cubic import Tabulated
from ncf_fenicsx.parameters.kinds import kinds, nearest

FAMILIES = ("compaction", "rate", "relaxation", "unloading", "shear", "bending", "friction", "permeability")
APART = 1.2
"""Ratio of two rates of closing from which on they are two."""
CROSSING = 0.1
"""Relative difference of two pressures that noise does not make."""
HEAD_START = 10.0
"""Akaike's criterion by which a table has to be ahead of all formulas: it can follow any curve, also one of chance."""
LEAST_PRESSURE = 1e-3
"""Pa: what a law begins from is above 0."""


@dataclass(frozen=True)
class Wishes:
    """What is asked for.

    Attributes:
        kinds: of the laws, by family; "auto" for compaction lets Akaike's criterion choose.
        free: numbers to fit beside the usual ones.
        fixed: usual ones that keep their values.
        machine: compliance and slack.
        fitted: "machine.compliance" and "machine.slack" where they are to be fitted.
        weight: what residuals are of.
    """

    kinds: dict[str, str]
    free: tuple[str, ...] = ()
    fixed: tuple[str, ...] = ()
    machine: Machine = field(default_factory=Machine)
    fitted: tuple[str, ...] = ()
    weight: Weight = "thickness"


@dataclass(frozen=True)
class Calibration:
    """What the files came to.

    Attributes:
        files: that were read.
        tests: of compaction.
        fit: of the laws of compaction; None without such tests.
        curves: of the other laws.
    """

    files: list[Path]
    tests: list[Compaction]
    fit: Fit | None
    curves: list[CurveFit]


def calibrate(files: list[Path], given: dict[str, dict[str, float]], wishes: Wishes) -> Calibration:
    """Laws that meet the tests of some files.

    Raises:
        SceneError: a file cannot be read, what a specimen was is not known, or no laws meet the tests.
    """
    raw = [test for file in files for test in read_tests(file)]
    by_family: dict[str, list[RawTest]] = {}
    for test in raw:
        by_family.setdefault(family_of(test) or "compaction", []).append(test)
    tests = [compaction_test(test, given) for test in by_family.pop("compaction", [])]
    shapes = [test for test in by_family.get("bending", []) if "deflection" in test.columns]
    if len(shapes) > 1 or (shapes and len(by_family["bending"]) > 1):
        raise SceneError(f"{shapes[-1].path}: several tests of bending with a shape; expected one shape, or curvatures")
    curves = [fit_shape(test, given) for test in shapes]
    for family, found in by_family.items():
        if not (shapes and family == "bending"):
            curves += fit_curve(family, found, wishes.kinds.get(family), given)
    return Calibration(files, tests, fit_tests(tests, wishes) if tests else None, curves)


def wished_kinds(texts: list[str]) -> dict[str, str]:
    """Kinds of laws by family, from ``FAMILY=KIND`` or ``auto``.

    Raises:
        SceneError: no such family or kind.
    """
    found = {}
    for text in texts:
        family, equals, kind = text.partition("=")
        if text == "auto":
            family, kind = "compaction", "auto"
        elif not equals or family not in FAMILIES:
            raise SceneError(f"--law {text}: expected FAMILY=KIND, such as compaction=gutowski, or auto")
        known = [*kinds(family), "none", "auto", *(["coulomb"] if family == "friction" else [])]
        if kind not in known:
            raise SceneError(f"--law {text}: no such kind; {nearest(kind, known)}")
        found[family] = kind
    return found


def fit_tests(tests: list[Compaction], wishes: Wishes) -> Fit:
    """The laws of compaction that meet the tests; where asked, those of the kind that does so best.

    Raises:
        SceneError: curves of two speeds cross, or no laws meet the tests.
    """
    asked = wishes.kinds.get("compaction", "exponential")
    if asked != "auto":
        return _fit(tests, wishes, asked)
    fits: dict[str, Fit] = {}
    for kind in kinds("compaction"):
        try:
            fits[kind] = _fit(tests, wishes, kind)
        except SceneError as error:
            if "cross" in str(error):
                raise
    if not fits:
        raise SceneError("calibrate: no law of compaction can be evaluated on these tests")
    best = min(
        fits, key=lambda kind: fits[kind].criterion + HEAD_START * issubclass(kinds("compaction")[kind], Tabulated)
    )
    behind = {kind: fit.criterion - fits[best].criterion for kind, fit in fits.items()}
    return replace(fits[best], compared=behind)


def _fit(tests: list[Compaction], wishes: Wishes, compaction: str) -> Fit:
    laws = _chosen(tests, wishes.kinds, compaction)
    if laws["rate"].kind != "none":
        check_crossings(tests, wishes.machine)
    known = [name for name in (*wishes.free, *wishes.fixed) if name.split(".")[0] in laws or not _is_family(name)]
    measured = _measured(tests, wishes.machine)
    laws = {family: law.first_guess(measured) for family, law in laws.items()}
    free = free_of(laws, [n for n in wishes.free if n in known], [n for n in wishes.fixed if n in known])
    return fit_compaction(tests, laws, free, wishes.machine, list(wishes.fitted), wishes.weight)


def _is_family(name: str) -> bool:
    return name.split(".")[0] in FAMILIES


def _chosen(tests: list[Compaction], wished: dict[str, str], compaction: str) -> Laws:
    """The laws asked for, else those of which the tests have something."""
    rates = [test.nominal_rate for test in tests]
    usual = {
        "rate": "kelly" if max(rates) > APART * min(rates) else "none",
        "relaxation": "maxwell" if any(test.has_hold for test in tests) else "none",
        "unloading": "permanent_set" if any(test.has_unloading for test in tests) else "none",
    }
    found = {"compaction": compaction} | usual | {key: kind for key, kind in wished.items() if key in usual}
    laws: Laws = {}
    for family, kind in found.items():
        if kind == "none" and family != "rate":
            continue
        law = kinds(family)[kind]()
        assert isinstance(law, Law)
        laws[family] = law
    return laws


def _measured(tests: list[Compaction], machine: Machine) -> Measured:
    """What the laws begin from."""
    curves = [_loading_curve(test, machine) for test in tests]
    vf, pressure = (np.concatenate([curve[place] for curve in curves]) for place in (0, 1))
    order = np.argsort(vf)
    rates: list[float] = []
    for rate in sorted(test.nominal_rate for test in tests):
        if not rates or rate > APART * rates[-1]:
            rates.append(rate)
    return Measured(
        volume_fraction=vf[order],
        pressure=isotonic_regression(np.maximum(pressure[order], LEAST_PRESSURE)).x,
        initial_volume_fraction=tests[0].initial_volume_fraction,
        closing_rates=tuple(rates),
        durations=(
            min(float(np.median(np.diff(test.time))) for test in tests),
            max(float(np.ptp(test.time)) for test in tests),
        ),
    )


def check_crossings(tests: list[Compaction], machine: Machine) -> None:
    """Refuse curves of two speeds of which each is above the other somewhere: no factor of speed does that.

    Raises:
        SceneError: two cross; it says where.
    """
    for slow, fast in combinations(sorted(tests, key=lambda test: test.nominal_rate), 2):
        if fast.nominal_rate < APART * slow.nominal_rate:
            continue
        curves = [_loading_curve(test, machine) for test in (slow, fast)]
        low, high = (pick(curve[0][end] for curve in curves) for pick, end in ((max, 0), (min, -1)))
        if high <= low:
            continue
        vf = np.linspace(low, high, 60)
        slower, faster = (np.interp(vf, *curve) for curve in curves)
        ahead = np.where(slower > 0.1 * slower.max(), np.log(np.maximum(faster, 1e-9) / np.maximum(slower, 1e-9)), 0)
        ahead = np.convolve(ahead, np.ones(5) / 5, mode="valid")
        if ahead.max() > CROSSING and ahead.min() < -CROSSING:
            first = int(np.argmax(np.abs(ahead) > CROSSING))
            place = vf[2:-2][first + int(np.argmax(np.sign(ahead[first:]) != np.sign(ahead[first])))]
            raise SceneError(
                f"calibrate: the curves of {slow.name} ({60 * slow.nominal_rate:.3g} of its thickness a minute) and "
                f"{fast.name} ({60 * fast.nominal_rate:.3g}) cross at Vf {place:.3f}; expected the faster one above"
            )


def _loading_curve(test: Compaction, machine: Machine) -> tuple[np.ndarray, np.ndarray]:
    """Vf and pressure (Pa) of the press, in the order of Vf."""
    rows = test.loading
    vf = test.volume_fraction(machine)[rows]
    order = np.argsort(vf)
    return vf[order], test.pressure[rows][order]
