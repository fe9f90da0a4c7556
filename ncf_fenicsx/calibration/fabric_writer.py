"""A calibration as a fabric file, and in words."""

from __future__ import annotations

from typing import Any

import numpy as np
import tomli_w

from ncf_fenicsx.calibration.calibrate import Calibration
from ncf_fenicsx.calibration.curve_laws import CurveFit
from ncf_fenicsx.calibration.fitting import Fit
from ncf_fenicsx.parameters.units import parse_quantity

PLACES = {"friction": ("interface", "friction"), "permeability": ("output", "permeability")}
"""Where in a scene the laws stand that are not in [laws]."""
AGREED = "(laboratories agree on it within 4 %, on stress at given thickness within 40 %)"
HARDLY = 0.5
"""Standard error over a number from which on it is hardly told."""
STRONG = 0.95
"""Correlation from which on two numbers are told of: each alone is less sure than its error says."""


def fabric_table(made: Calibration, title: str) -> dict[str, Any]:
    """Table of a fabric file: laws, the source of each, and the fit with its covariance."""
    table: dict[str, Any] = {"title": title}
    sources: dict[str, str] = {}
    files = ", ".join(path.name for path in made.files)
    if made.fit is not None:
        fit, first = made.fit, made.tests[0]
        table["stack"] = {
            "thickness": f"{float(np.mean([test.initial_thickness / test.layers for test in made.tests]))!r} m",
            "areal_density": f"{first.areal_density!r} kg/m^2",
            "fibre_density": f"{first.fibre_density!r} kg/m^3",
        }
        sources["stack"] = f"given with {files}"
        for family, law in fit.laws.items():
            table.setdefault("laws", {})[family] = {"kind": law.kind, **law.model_dump()}
            free = [name.split(".", 1)[1] for name in fit.names if name.startswith(f"{family}.")]
            words = f"{', '.join(free)} fitted to {files}" if free else "not fitted"
            sources[f"laws.{family}"] = f"{words}; the other numbers are defaults or given"
        table["fit"] = _record(fit, len(made.tests))
    for curve in made.curves:
        top, name = PLACES.get(curve.family, ("laws", curve.family))
        table.setdefault(top, {})[name] = curve.table
        points = sum(len(other.x) for other in made.curves if other.family == curve.family)
        sources[f"{top}.{name}"] = f"measured: {files}, {points} points"
    return table | {"sources": sources}


def _record(fit: Fit, tests: int) -> dict[str, Any]:
    return {
        "tests": tests,
        "rows": len(fit.residuals),
        "weight": fit.weight,
        "scatter": fit.scatter,
        "criterion": fit.criterion,
        "names": fit.names,
        "values": fit.values.tolist(),
        "standard_errors": fit.errors.tolist(),
        "covariance": fit.covariance.tolist(),
        "untold": sorted(name for names in fit.untold for name in names),
        "compliance": f"{fit.machine.compliance!r} m/N",
        "slack": f"{fit.machine.slack!r} m",
    }


def to_toml(table: dict[str, Any]) -> str:
    """The table as a file."""
    return tomli_w.dumps(table)


def in_words(made: Calibration) -> str:
    """Fitted numbers with errors, what they share, and how far the laws are off, as Markdown."""
    lines: list[str] = []
    if made.fit is not None:
        lines += _compaction_in_words(made.fit, len(made.tests))
    for curve in made.curves:
        lines += _curve_in_words(curve)
    return "\n".join(lines)


def _compaction_in_words(fit: Fit, tests: int) -> list[str]:
    kinds = ", ".join(f"{family} {law.kind}" for family, law in fit.laws.items())
    other = "pressure at given thickness" if fit.weight == "pressure" else "thickness at given pressure"
    lines = [
        f"{kinds}: {len(fit.residuals)} rows of {tests} tests; residuals are those of {other}",
        *([AGREED] * (fit.weight == "thickness")),
        "",
        "| number (SI) | value | standard error |",
        "|---|---|---|",
    ]
    unsure = {name for names in fit.untold for name in names}
    for name, value, error in zip(fit.names, fit.values, fit.errors, strict=True):
        lines.append(f"| {name} | {value:.6g} | {'without bound' if name in unsure else f'{error:.2g}'} |")
    lines += ["", f"root mean square residual: {100 * fit.scatter:.3g} %"]
    lines += unsure_in_words(fit)
    for i, j in np.argwhere(np.triu(np.abs(fit.correlations) > STRONG, 1)):
        lines.append(f"correlation of {fit.names[i]} and {fit.names[j]}: {fit.correlations[i, j]:.3f}")
    if fit.compared:
        behind = sorted(fit.compared.items(), key=lambda pair: pair[1])
        words = ", ".join(f"{kind} by {value:.1f}" for kind, value in behind[1:])
        lines.append(f"{behind[0][0]} is chosen by Akaike's criterion; behind it: {words or 'none'}")
    return [*lines, ""]


def unsure_in_words(fit: Fit) -> list[str]:
    """Which numbers the tests do not tell, or hardly."""
    lines = []
    for names, told in fit.untold.items():
        if len(names) == 1:
            lines.append(f"these tests say nothing of {names[0]}: its error is without bound, and it stays as it was")
        else:
            held = f"unless --fix holds {len(names) - told} of them"
            lines.append(f"these tests tell {told} of {len(names)} numbers, {', '.join(names)}: no errors {held}")
    unsure = {name for names in fit.untold for name in names}
    for name, value, error in zip(fit.names, fit.values, fit.errors, strict=True):
        if name not in unsure and error > HARDLY * abs(value):
            lines.append(f"these tests hardly tell {name}: its error is {100 * error / abs(value):.0f} % of it")
    return lines


def _curve_in_words(curve: CurveFit) -> list[str]:
    off = np.sqrt(np.mean((curve.model - curve.y) ** 2)) / np.abs(curve.y).max()
    words = ", ".join(f"{name} = {value:.5g} +- {error:.2g}" for name, (value, error) in curve.values.items())
    kind = curve.table.get("kind", "coulomb")
    what = f"{len(curve.x)} points of {curve.y_name.replace('_', ' ')}"
    thickness = parse_quantity(curve.table.get("thickness", ""), "mm")
    holds = "" if thickness is None else f"; it holds for layers of {thickness:.4g} mm"
    return [f"{curve.family} {kind}: {words or 'a table'}; {what}, off by {100 * off:.2g} % of the largest{holds}"]
