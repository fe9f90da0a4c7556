"""Shear, bending, friction and permeability: measured curves to the law of each."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import isotonic_regression

from ncf_fenicsx.calibration.free_parameters import free_of, named, unknowns, value_of, with_values
from ncf_fenicsx.calibration.histories import Laws
from ncf_fenicsx.calibration.least_squares import least_squares
from ncf_fenicsx.calibration.raw_files import RawTest
from ncf_fenicsx.calibration.specimens import specimen
from ncf_fenicsx.errors import SceneError
from ncf_fenicsx.laws.bending import MomentTable
from ncf_fenicsx.laws.permeability import PermeabilityLaw
from ncf_fenicsx.laws.shear import ShearTable
from ncf_fenicsx.parameters.kinds import kinds

Floats = NDArray[np.float64]
Rows = dict[str, tuple[Floats, Floats]]
"""Abscissas, ascending, and ordinates in SI, by the quantity of the ordinates."""
MOST_NODES = 12
ALIKE = 0.02
"""Relative difference in thickness of strips that are one fabric."""


@dataclass(frozen=True)
class Curve:
    """What a family is measured as.

    Attributes:
        x: quantity along the abscissa.
        ys: quantities over it, one or both.
        kind: of the law unless another is asked for.
    """

    x: str
    ys: tuple[str, ...]
    kind: str


CURVES = {
    "shear": Curve("angle", ("shear_stress",), "table"),
    "bending": Curve("curvature", ("moment",), "table"),
    "friction": Curve("normal_force", ("force",), "coulomb"),
    "permeability": Curve("volume_fraction", ("permeability", "permeability_across"), "kozeny_carman"),
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
    columns = set(raw.columns)
    if {"position", "deflection"} <= columns:
        return "bending"
    for family, curve in CURVES.items():
        named = curve.x in columns and columns & set(curve.ys)
        if named or (family == "shear" and {"angle", "pressure"} <= columns):
            return family
    return None


def fit_curve(
    family: str, tests: list[RawTest], kind: str | None, given: dict[str, dict[str, float]]
) -> list[CurveFit]:
    """Law of a family that meets all tests of it, held against each quantity that was measured.

    Args:
        family: of the law.
        tests: of it.
        kind: of the law; the usual one if None.
        given: what specimens were.

    Raises:
        SceneError: no such law, the points do not rise, or the thickness of a strip is not known.
    """
    rows, kind = _rows(family, tests), kind or CURVES[family].kind
    if family == "friction":
        return [_friction(*rows["force"])]
    if (family, kind) == ("bending", "table"):
        return [_moments(*rows["moment"], strip_thickness(tests, given))]
    if (family, kind) == ("shear", "table"):
        return [_shear(*rows["shear_stress"])]
    known = [*kinds(family)] if family != "bending" else ["table"]
    if kind not in known:
        raise SceneError(f"--law {family}={kind}: expected one that such tests tell: {', '.join(known)}")
    return _formula(family, kind, rows)


def strip_thickness(tests: list[RawTest], given: dict[str, dict[str, float]]) -> float:
    """Thickness in m of the strips that were bent.

    Raises:
        SceneError: it is not known, or they are of several.
    """
    found = [specimen(test, given, ("thickness",))["thickness"] for test in tests]
    if max(found) > (1 + ALIKE) * min(found):
        ends = f"{1e3 * min(found):.4g} mm and {1e3 * max(found):.4g} mm"
        raise SceneError(f"calibrate: bending: strips of {ends}; expected one thickness, which the law then holds for")
    return found[0]


def _rows(family: str, tests: list[RawTest]) -> Rows:
    rows: Rows = {}
    for name in CURVES[family].ys:
        columns = [test.columns for test in tests]
        if family == "shear":
            columns = [entry if name in entry else {**entry, name: entry["pressure"]} for entry in columns]
        having = [entry for entry in columns if name in entry]
        if having:
            x, y = (np.concatenate([np.abs(entry[key]) for entry in having]) for key in (CURVES[family].x, name))
            order = np.argsort(x)
            rows[name] = x[order], y[order]
    return rows


def _nodes(family: str, x: Floats, y: Floats) -> tuple[list[float], list[float]]:
    """A table through the points: made to rise, and thinned to a dozen by equal shares of the points."""
    rising = isotonic_regression(y).x
    nodes: list[tuple[float, float]] = []
    for group in np.array_split(np.flatnonzero(x > 0), min(MOST_NODES, np.count_nonzero(x > 0))):
        node = float(x[group].mean()), float(rising[group].mean())
        if node[1] > 0 and (not nodes or (node[0] > nodes[-1][0] and node[1] > nodes[-1][1])):
            nodes.append(node)
    if not nodes:
        raise SceneError(f"calibrate: {family}: no point above 0; expected values that rise from the origin")
    return [node[0] for node in nodes], [node[1] for node in nodes]


def _shear(angle: Floats, stress: Floats) -> CurveFit:
    across, up = _nodes("shear", angle, stress)
    law = ShearTable.model_validate({"angle": across, "stress": [f"{value!r} Pa" for value in up]})
    model = np.asarray(law.shear_stress(np.tan(np.radians(angle))))
    table = {"kind": "table", **law.model_dump()}
    return CurveFit("shear", table, {}, angle, stress, model, "angle", "shear_stress")


def _moments(curvature: Floats, moment: Floats, thickness: float) -> CurveFit:
    law = moment_table(*_nodes("bending", curvature, moment), thickness)
    model = np.asarray(law.moment_at(curvature))
    table = {"kind": "table", **law.model_dump()}
    return CurveFit("bending", table, {}, curvature, moment, model, "curvature", "moment")


def moment_table(curvature: list[float], moment: list[float], thickness: float) -> MomentTable:
    """Law of moments per width (N) at curvatures (1/m) of a strip of a thickness (m)."""
    columns = {"curvature": [f"{value!r} 1/m" for value in curvature], "moment": [f"{value!r} N" for value in moment]}
    return MomentTable.model_validate({**columns, "thickness": f"{thickness!r} m"})


def _friction(normal: Floats, force: Floats) -> CurveFit:
    """Coefficient of Coulomb's law: forces over normal forces, each pair with the same relative error."""
    ratios = force[normal > 0] / normal[normal > 0]
    error = float(ratios.std(ddof=1) / math.sqrt(len(ratios)))
    coefficient = float(ratios.mean())
    found = {"coefficient": (coefficient, error)}
    model = np.asarray(coefficient * normal)
    return CurveFit("friction", {"coefficient": coefficient}, found, normal, force, model, "normal_force", "force")


def _formula(family: str, kind: str, rows: Rows) -> list[CurveFit]:
    """Numbers of a formula, for residuals relative to the measured values; those not told are left as they are."""
    laws: Laws = {family: kinds(family)[kind]()}  # type: ignore[dict-item]
    free = unknowns(laws, free_of(laws, [], []))

    def off(inner: Floats) -> Floats:
        law = with_values(laws, free.named(inner))[family]
        return np.concatenate([(_model(law, name, x) / y - 1)[y > 0] for name, (x, y) in rows.items()])

    found = least_squares(off, free.parameters()).mapped(free.base, free.slopes)
    unsure = {name for group in found.untold(free.names) for name in group}
    fitted: Any = with_values(laws, named(free.names, found.values))[family]
    errors = named(free.names, found.errors)
    values = {
        name.split(".", 1)[1]: (value_of({family: fitted}, name), errors[name])
        for name in free.names
        if name not in unsure
    }
    table = {"kind": kind, **fitted.model_dump()}
    return [
        CurveFit(family, table, values, x, y, _model(fitted, name, x), CURVES[family].x, name)
        for name, (x, y) in rows.items()
    ]


def _model(law: Any, name: str, x: Floats) -> Floats:
    """What a law gives for a quantity, in SI."""
    if isinstance(law, PermeabilityLaw):
        return np.asarray(law.along(x) if name == "permeability" else law.across(x))
    return np.asarray(law.small_strain_modulus * np.tan(np.radians(x)))
