"""Bending from the shape of a strip that hangs over an edge by its own weight."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from lmfit import Parameters
from numpy.typing import NDArray
from scipy.integrate import cumulative_simpson
from scipy.interpolate import CubicSpline

from ncf_fenicsx.calibration.curve_laws import CurveFit, moment_table, strip_thickness
from ncf_fenicsx.calibration.fitting import akaike
from ncf_fenicsx.calibration.least_squares import Solution, least_squares
from ncf_fenicsx.calibration.raw_files import RawTest
from ncf_fenicsx.calibration.specimens import specimen
from ncf_fenicsx.errors import SceneError

Floats = NDArray[np.float64]
GRAVITY = 9.81
LEAST_POINTS = 12
FINE = 400
MOST_PIECES = 4
WORTH = 10.0
"""Akaike's criterion that another piece has to gain."""
SHARES = (0.1, 20.0)
"""What a piece may take of the moments, over the last one: pieces of next to nothing follow noise."""
WITHIN = (0.25, 0.5, 0.75, 0.9, 1.0)
"""Shares of a straight piece at which it enters a table, whose cubic rounds the corners between them."""


@dataclass(frozen=True)
class Strip:
    """A strip as it hangs.

    Attributes:
        along: arc length in m from the edge on, ascending, `FINE` of them.
        moment: per width in N there, by the weight beyond each place at its lever.
        measured_at: arc lengths in m of the measured points.
        sunk: their deflections in m, positive downwards, from the first on.
    """

    along: Floats
    moment: Floats
    measured_at: Floats
    sunk: Floats

    def shape(self, moments: Floats, curvatures: Floats) -> Floats:
        """Deflection in m at the measured points of a strip whose curvature is straight between some moments."""
        bent = np.interp(self.moment, [0.0, *moments], [0.0, *curvatures])
        angle = cumulative_simpson(bent, x=self.along, initial=0)
        sunk = cumulative_simpson(np.sin(angle), x=self.along, initial=0)
        return np.asarray(np.interp(self.measured_at, self.along, sunk))


def fit_shape(raw: RawTest, given: dict[str, dict[str, float]]) -> CurveFit:
    """Moment over curvature of a strip whose deflection over its position was measured, from the edge on.

    The moment at a place follows from the shape: the weight beyond, at its lever. Curvature over moment is made of
    straight pieces, with corners where they fit best, and as many as Akaike's criterion finds worth it: one is a strip
    of constant stiffness. What is fitted is the shape that they make, integrated from the edge on, where the strip is
    level: no second derivative of a measured shape is taken.

    Args:
        raw: with columns position and deflection, positive downwards.
        given: areal density and thickness, and layers if several hang together.

    Raises:
        SceneError: the areal density or the thickness is not known, or the points are too few.
    """
    x, sunk = raw.columns["position"], raw.columns["deflection"]
    order = np.argsort(x)
    x, sunk = x[order] - x[order][0], sunk[order] - sunk[order][0]
    if len(x) < LEAST_POINTS:
        raise SceneError(f"{raw.path}: {len(x)} points of a shape; expected {LEAST_POINTS} or more")
    known = specimen(raw, given, ("areal_density",))
    thickness = strip_thickness([raw], given)
    strip = _hanging(known["areal_density"] * known.get("layers", 1.0) * GRAVITY, x, sunk)
    moments, curvatures, errors = _best_pieces(strip)
    shares = (np.arange(len(moments))[:, None] + WITHIN).ravel() if len(moments) > 1 else np.array([1.0])
    corners = np.arange(len(moments) + 1.0)
    across, up = (np.interp(shares, corners, [0.0, *nodes]).tolist() for nodes in (curvatures, moments))
    law = moment_table(across, up, thickness)
    rows = zip(moments, curvatures, errors, strict=True)
    found = {f"curvature at {m:.3g} N": (float(value), float(error)) for m, value, error in rows}
    model = strip.shape(moments, curvatures)
    return CurveFit("bending", {"kind": "table", **law.model_dump()}, found, x, sunk, model, "position", "deflection")


def _hanging(weight: float, x: Floats, sunk: Floats) -> Strip:
    """The strip between its measured points: a spline through the positions over the arc length, and the moments."""
    at: Floats = np.concatenate([[0.0], np.cumsum(np.hypot(np.diff(x), np.diff(sunk)))])
    along: Floats = np.linspace(0.0, at[-1], FINE)
    position = CubicSpline(at, x)(along)
    beyond = [weight * np.trapezoid(position[place:] - position[place], along[place:]) for place in range(FINE)]
    return Strip(along, np.asarray(beyond), at, sunk)


def _best_pieces(strip: Strip) -> tuple[Floats, Floats, Floats]:
    """Moments (N) and curvatures (1/m) at the ends of the straight pieces, and standard errors of the curvatures."""
    best, before = _pieces(strip, 1), np.inf
    found = best
    for count in range(1, MOST_PIECES + 1):
        found = _pieces(strip, count)
        criterion = akaike(found.residuals, len(found.values))
        if criterion > before - WORTH:
            break
        best, before = found, criterion
    moments, curvatures = _nodes(strip, best.values)
    count = len(moments)
    total = np.tril(np.ones((count, count))) @ best.covariance[:count, :count] @ np.tril(np.ones((count, count))).T
    return moments, curvatures, np.asarray(np.sqrt(np.diag(total)))


def _pieces(strip: Strip, count: int) -> Solution:
    """Gains of curvature of some pieces, then what all but the last take of the moments, over the last one's share.

    The last number is the deflection of the first point, which its own noise makes that of all others.
    """
    begin = Parameters()
    angle = cumulative_simpson(strip.moment, x=strip.along, initial=0)
    stiff = strip.sunk[-1] / np.trapezoid(angle, strip.along)
    for number in range(count):
        begin.add(f"gain_{number}", value=float(stiff * strip.moment[0] / count), min=1e-9)
    for number in range(count - 1):
        begin.add(f"share_{number}", value=1.0, min=SHARES[0], max=SHARES[1])
    begin.add("first", value=0.0)
    size = float(np.abs(strip.sunk).max())

    def off(values: Floats) -> Floats:
        return (strip.shape(*_nodes(strip, values)) + values[-1] - strip.sunk) / size

    return least_squares(off, begin, {"first": 1e-3 * size})


def _nodes(strip: Strip, values: Floats) -> tuple[Floats, Floats]:
    """Moments and curvatures at the ends of the pieces that these numbers make."""
    count = len(values) // 2
    shares = np.cumsum([*values[count:-1], 1.0])
    return strip.moment[0] * shares / shares[-1], np.cumsum(values[:count])
