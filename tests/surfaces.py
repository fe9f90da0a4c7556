"""Tools and moulds to test, their distances as numbers, and points about them."""

import numpy as np
import ufl
from basix.ufl import element
from ufl.algorithms.apply_algebra_lowering import apply_algebra_lowering
from ufl.algorithms.apply_derivatives import apply_derivatives

from ncf_fenicsx.parameters.kinds import kinds

MM = 1e-3


def distance(surface, point):
    return float(ufl.as_ufl(surface.signed_distance(ufl.as_vector([float(c) for c in point])))(()))


def gradient(surface, point):
    offsets = 1e-7 * np.eye(3)
    return np.array([(distance(surface, point + d) - distance(surface, point - d)) / 2e-7 for d in offsets])


def derivatives(surface):
    """First and second derivatives of the distance as forms take them, each to be called with a point."""
    at = ufl.variable(ufl.SpatialCoordinate(ufl.Mesh(element("Lagrange", "hexahedron", 1, shape=(3,)))))
    first = ufl.diff(surface.signed_distance(at), at)
    second = ufl.diff(first, at)
    parts = [first[i] for i in range(3)], [second[i, j] for i in range(3) for j in range(3)]
    return [[apply_derivatives(apply_algebra_lowering(part)) for part in order] for order in parts]


def tool(kind="cylinder", **keys):
    return kinds("tool")[kind].model_validate(keys)


def mould(kind, **keys):
    return kinds("mould")[kind].model_validate(keys)


def profile(points, rounding):
    return tool("profile", points=[[f"{x!r} m", f"{z!r} m"] for x, z in points], rounding=rounding)


CYLINDER = tool(radius="2.5 mm", width="30 mm")
ROUNDED = tool(radius="2.5 mm", width="30 mm", edge="1 mm")
BALL = tool("sphere")
FOOT = tool("presser_foot", size=("20 mm", "12 mm"))
PLATE = tool("plate")
PROFILE = tool("profile")
NOTCHED = profile([(-6 * MM, 3 * MM), (-2 * MM, 1 * MM), (0, 2 * MM), (5 * MM, -1 * MM)], "0.5 mm")
TOOTHED = profile([(-6 * MM, 5 * MM), (-4 * MM, 13 * MM), (0, 12 * MM), (1 * MM, 0)], "0.5 mm")
TOOLS = {
    "cylinder": CYLINDER,
    "infinite cylinder": tool(width="infinite"),
    "rounded cylinder": ROUNDED,
    "sphere": BALL,
    "presser foot": FOOT,
    "plate": PLATE,
    "profile": PROFILE,
    "notched profile": NOTCHED,
}
MOULDS = {
    "ridge": mould("cylinder", radius="20 mm"),
    "trough": mould("cylinder", radius="20 mm", shape="concave"),
    "dome": mould("sphere", radius="20 mm"),
    "bowl": mould("sphere", radius="20 mm", shape="concave"),
    "flat": mould("plate"),
}
SURFACES = TOOLS | MOULDS


def points_about(surface, count, seed):
    """Points on the fabric's side, and inside less deep than the smallest rounding."""
    low, high = (-3.0, 0.4) if surface.family == "tool" else (-0.4, 3.0)
    return np.random.default_rng(seed).uniform([-12, -19, low], [12, 19, high], (count, 3)) * MM
