"""Bending from the shape of a strip that hangs over an edge by its own weight."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import cumulative_trapezoid

from ncf_fenicsx.calibration.curve_laws import CurveFit
from ncf_fenicsx.calibration.fitting import least_squares
from ncf_fenicsx.calibration.free_parameters import positive_parameters
from ncf_fenicsx.calibration.raw_files import RawTest
from ncf_fenicsx.calibration.specimens import specimen
from ncf_fenicsx.errors import SceneError
from ncf_fenicsx.laws.bending import MomentTable

Floats = NDArray[np.float64]
GRAVITY = 9.81
NODES = 6
LEAST_POINTS = 2 * NODES
SUM = np.tril(np.ones((NODES, NODES)))


def fit_shape(raw: RawTest, given: dict[str, dict[str, float]]) -> CurveFit:
    """Moment over curvature of a strip whose deflection over its position was measured, from the edge on.

    The moment at a place follows from the shape: the weight beyond, at its lever. The curvature at some moments,
    straight between them, is what makes the shape, integrated from the edge on, the measured one: no second derivative
    of a measured shape is taken.

    Args:
        raw: with columns position and deflection, positive downwards.
        given: areal density, and layers if several hang together.

    Raises:
        SceneError: the areal density is not known, or the points are too few.
    """
    x, sunk = raw.columns["position"], raw.columns["deflection"]
    order = np.argsort(x)
    x, sunk = x[order] - x[order][0], sunk[order] - sunk[order][0]
    if len(x) < LEAST_POINTS:
        raise SceneError(f"{raw.path}: {len(x)} points of a shape; expected {LEAST_POINTS} or more")
    known = specimen(raw, given, ("areal_density",))
    weight = known["areal_density"] * known.get("layers", 1.0) * GRAVITY
    along: Floats = np.concatenate([[0.0], np.cumsum(np.hypot(np.diff(x), np.diff(sunk)))])
    moment = _moments(weight, along, x)
    nodes: Floats = moment.max() * np.arange(1, NODES + 1) / NODES

    def shape(gains: Floats) -> Floats:
        """Of gains of curvature from node to node, which are positive: so the table rises."""
        bent = np.interp(moment, [0.0, *nodes], [0.0, *np.cumsum(gains)])
        angle = cumulative_trapezoid(bent, along, initial=0.0)
        return np.asarray(cumulative_trapezoid(np.sin(angle), along, initial=0.0))

    first = nodes[0] * _first_guess(moment, along, sunk)
    begin = positive_parameters("gain", [float(first)] * NODES)
    gains, covariance, _ = least_squares(lambda trial: (shape(trial) - sunk)[1:] / np.abs(sunk).max(), begin)
    curvatures, errors = np.cumsum(gains), np.sqrt(np.diag(SUM @ covariance @ SUM.T))
    law = MomentTable.model_validate(
        {"curvature": [f"{float(k)!r} 1/m" for k in curvatures], "moment": [f"{float(m)!r} N" for m in nodes]}
    )
    rows = zip(nodes, curvatures, errors, strict=True)
    found = {f"curvature at {m:.3g} N": (float(value), float(error)) for m, value, error in rows}
    table = {"kind": "table", **law.model_dump()}
    return CurveFit("bending", table, found, x, sunk, shape(gains), "position", "deflection")


def _moments(weight: float, along: Floats, x: Floats) -> Floats:
    """Moment per width in N at each point: the weight (Pa) beyond it, at its lever."""
    beyond = [weight * np.trapezoid(x[place:] - x[place], along[place:]) for place in range(len(x))]
    return np.asarray(beyond)


def _first_guess(moment: Floats, along: Floats, sunk: Floats) -> float:
    """Curvature over moment of a strip of one stiffness that sinks as far."""
    angle = cumulative_trapezoid(moment, along, initial=0.0)
    return float(abs(sunk[-1]) / np.trapezoid(angle, along))
