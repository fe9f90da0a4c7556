"""Shear, bending, friction and permeability: measured curves to the law of each."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import isotonic_regression

from ncf_fenicsx.calibration.fitting import least_squares
from ncf_fenicsx.calibration.free_parameters import FREE, parameters, value_of, with_values
from ncf_fenicsx.calibration.histories import Laws
from ncf_fenicsx.calibration.raw_files import RawTest
from ncf_fenicsx.errors import SceneError
from ncf_fenicsx.kinds import kinds
from ncf_fenicsx.laws.bending import MomentTable
from ncf_fenicsx.laws.permeability import PermeabilityLaw
from ncf_fenicsx.laws.shear import ShearTable

Floats = NDArray[np.float64]
MOST_NODES = 12


@dataclass(frozen=True)
class Curve:
    """What a family is measured as.

    Attributes:
        x: quantity along the abscissa.
        y: quantity over it.
        kind: of the law unless another is asked for.
    """

    x: str
    y: str
    kind: str


FRICTION = ("normal_force", "force")
CURVES = {
    "shear": Curve("angle", "shear_stress", "table"),
    "bending": Curve("curvature", "moment", "table"),
    "friction": Curve(*FRICTION, "coulomb"),
    "permeability": Curve("volume_fraction", "permeability", "kozeny_carman"),
}


@dataclass(frozen=True)
class CurveFit:
    """A fitted curve.

    Attributes:
        family: of the law.
        table: of the law, as a scene has it.
        values: fitted numbers with their standard errors, by name; empty for a table of measured points.
        x: measured, in the units of the law.
        y: measured, in SI.
        model: of the law at x.
        x_name: quantity of x.
        y_name: quantity of y.
    """

    family: str
    table: dict[str, Any]
    values: dict[str, tuple[float, float]]
    x: Floats
    y: Floats
    model: Floats
    x_name: str
    y_name: str


def family_of(raw: RawTest) -> str | None:
    """Family that a test measures, by its columns; None for one of compaction."""
    if {"position", "deflection"} <= set(raw.columns):
        return "bending"
    for family, curve in CURVES.items():
        named = {curve.x, curve.y} <= set(raw.columns)
        if named or (family == "shear" and {"angle", "pressure"} <= set(raw.columns)):
            return family
    return None


def fit_curve(family: str, tests: list[RawTest], kind: str | None) -> CurveFit:
    """Law of a family that meets all tests of it.

    Raises:
        SceneError: no such law, or the points do not rise.
    """
    curve = CURVES[family]
    y_name = curve.y if curve.y in tests[0].columns else "pressure"
    x, y = (np.concatenate([np.abs(test.columns[name]) for test in tests]) for name in (curve.x, y_name))
    order = np.argsort(x)
    x, y, kind = x[order], y[order], kind or curve.kind
    if family == "friction":
        return _friction(x, y)
    if kind == "table":
        return _table(family, x, y)
    if (family, kind) not in FREE:
        known = ", ".join(other for name, other in FREE if name == family)
        raise SceneError(f"--law {family}={kind}: expected table, or one of {known}")
    return _formula(family, kind, x, y)


def _table(family: str, x: Floats, y: Floats) -> CurveFit:
    """A table through the points: made to rise, and thinned to a dozen by equal shares of the points."""
    curve, rising = CURVES[family], isotonic_regression(y).x
    nodes: list[tuple[float, float]] = []
    for group in np.array_split(np.flatnonzero(x > 0), min(MOST_NODES, np.count_nonzero(x > 0))):
        node = float(x[group].mean()), float(rising[group].mean())
        if node[1] > 0 and (not nodes or (node[0] > nodes[-1][0] and node[1] > nodes[-1][1])):
            nodes.append(node)
    if not nodes:
        raise SceneError(f"calibrate: {family}: no point above 0; expected values that rise from the origin")
    across, up = (tuple(column) for column in zip(*nodes, strict=True))
    if family == "shear":
        shear = ShearTable.model_validate({"angle": across, "stress": [f"{value!r} Pa" for value in up]})
        model = np.asarray(shear.shear_stress(np.tan(np.radians(x))))
        return CurveFit(family, {"kind": "table", **shear.model_dump()}, {}, x, y, model, curve.x, curve.y)
    texts = {"curvature": [f"{value!r} 1/m" for value in across], "moment": [f"{value!r} N" for value in up]}
    bending = MomentTable.model_validate(texts)
    return CurveFit(
        family, {"kind": "table", **bending.model_dump()}, {}, x, y, np.asarray(bending.moment_at(x)), curve.x, curve.y
    )


def _friction(normal: Floats, force: Floats) -> CurveFit:
    """Coefficient of Coulomb's law: forces over normal forces, each pair with the same relative error."""
    ratios = force[normal > 0] / normal[normal > 0]
    error = float(ratios.std(ddof=1) / math.sqrt(len(ratios)))
    coefficient = float(ratios.mean())
    found = {"coefficient": (coefficient, error)}
    return CurveFit("friction", {"coefficient": coefficient}, found, normal, force, coefficient * normal, *FRICTION)


def _formula(family: str, kind: str, x: Floats, y: Floats) -> CurveFit:
    """Numbers of a formula, for residuals relative to the measured values."""
    law = kinds(family)[kind]()
    laws: Laws = {family: law}  # type: ignore[dict-item]
    names = [f"{family}.{name}" for name in FREE[family, kind]]

    def model(values: Floats) -> Floats:
        made: Any = with_values(laws, dict(zip(names, values, strict=True)))[family]
        if isinstance(made, PermeabilityLaw):
            return np.asarray(made.along(x))
        return np.asarray(made.small_strain_modulus * np.tan(np.radians(x)))

    used = y > 0
    values, covariance, _ = least_squares(lambda trial: (model(trial) / y - 1)[used], parameters(laws, names))
    fitted = with_values(laws, dict(zip(names, values, strict=True)))
    errors = np.sqrt(np.diag(covariance))
    found = {
        name.split(".")[1]: (value_of(fitted, name), float(error)) for name, error in zip(names, errors, strict=True)
    }
    return CurveFit(
        family,
        {"kind": kind, **fitted[family].model_dump()},
        found,
        x,
        y,
        model(values),
        CURVES[family].x,
        CURVES[family].y,
    )
