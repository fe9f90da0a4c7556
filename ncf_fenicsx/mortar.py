"""Weights between two faces that lie on each other with meshes of their own: dual mortar integrals in plan.

The lower face is the slave, the upper one the master; both are quadrilaterals in plan, corners x fastest: (0,0), (1,0),
(0,1), (1,1). On each slave element the dual functions psi = D M^-1 phi, with M = int phi phi^T and D = diag(int phi)
over the part that master elements cover (Wohlmuth; "consistent" after Cichosz & Bischoff 2011), add up to one and meet
int psi_i phi_k = 0 for i != k. So W_ij = int psi_i N_j / int psi_i takes linear fields of the master to the slave nodes
exactly, and its transpose carries a uniform pressure to the master as int N_j. No DOLFINx here.
"""

from __future__ import annotations

from dataclasses import dataclass

import basix
import numpy as np
import shapely
from numpy.typing import NDArray
from scipy.sparse import coo_matrix, csr_matrix, diags
from scipy.spatial import cKDTree

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]

RING = np.array([0, 1, 3, 2])
POINTS, POINT_WEIGHTS = basix.make_quadrature(basix.CellType.triangle, 4)
CORNER_MASS = np.array([[4, 2, 2, 1], [2, 4, 1, 2], [2, 1, 4, 2], [1, 2, 2, 4]]) / 36
LEAST_WEIGHT = 1e-8  # weights below this are round-off
LEAST_PIECE = 1e-10  # overlaps below this part of a slave element are lines
LEAST_COVERED = 0.05  # slave elements covered by less than this part count as open: M is badly conditioned there
BLOCK = 4000  # slave elements clipped at a time, for the memory's sake


@dataclass(frozen=True)
class Weights:
    """What the slave nodes see of the master nodes.

    Attributes:
        rows: W_ij, rows add up to one or are empty, shape (slave nodes, master nodes).
        coverage: part of each node's share of the slave face that lies on the master, shape (slave nodes,).
    """

    rows: csr_matrix
    coverage: Floats


def dual_weights(
    slave_places: Floats, slave_quads: Integers, master_places: Floats, master_quads: Integers, tolerance: float = 1e-6
) -> Weights:
    """Weights of the master nodes for each slave node, and its coverage.

    Args:
        slave_places: nodes in plan in m, shape (slave nodes, 2).
        slave_quads: nodes of each element, shape (slave elements, 4).
        master_places: nodes in plan in m, shape (master nodes, 2).
        master_quads: nodes of each element, shape (master elements, 4).
        tolerance: slip, relative to the shortest edge of a slave element, up to which its nodes and those of a master
            element count as the same places.
    """
    return normalised(*integrals(slave_places, slave_quads, master_places, master_quads, tolerance))


def normalised(coupling: csr_matrix, covered: Floats, whole: Floats) -> Weights:
    """Weights from ``integrals`` that are complete, that is, added up over all slave elements (and ranks)."""
    scale = np.divide(1.0, covered, out=np.zeros_like(covered), where=covered > 0)
    rows = csr_matrix(diags(scale) @ coupling)
    rows.data[np.abs(rows.data) < LEAST_WEIGHT] = 0.0
    rows.eliminate_zeros()
    rows.data /= np.repeat(np.asarray(rows.sum(axis=1)).ravel(), np.diff(rows.indptr))
    return Weights(rows, np.clip(np.divide(covered, whole, out=np.zeros_like(whole), where=whole > 0), 0.0, 1.0))


def integrals(
    slave_places: Floats, slave_quads: Integers, master_places: Floats, master_quads: Integers, tolerance: float = 1e-6
) -> tuple[csr_matrix, Floats, Floats]:
    """Sums over these slave elements, which may be some of many; arguments as for ``dual_weights``.

    Returns:
        int psi_i N_j, shape (slave nodes, master nodes), int phi_i where covered, and int phi_i, shape (slave nodes,);
        all in m2. Row sums of the first are the second.
    """
    slave, master = slave_places[slave_quads], master_places[master_quads]
    partner, same = _partners(slave_places, slave_quads, master_places, master_quads, tolerance)
    whole = _corner_areas(slave)
    covered = np.where(same[:, None], whole, 0.0)
    parts = [(slave_quads[same].ravel(), partner[same].ravel(), whole[same].ravel())]
    rest = np.flatnonzero(~same)
    tree = shapely.STRtree(shapely.polygons(master[:, RING]) if len(rest) else [])
    for start in range(0, len(rest), BLOCK):
        block = rest[start : start + BLOCK]
        element, other, coupling, covered[block] = _clipped(slave[block], whole[block].sum(axis=1), master, tree)
        # so that coverage is one there also where quadrature is not exact, on distorted elements
        full = covered[block].sum(axis=1) > (1 - 1e-9) * whole[block].sum(axis=1)
        whole[block[full]] = covered[block[full]]
        row, column = np.broadcast_arrays(slave_quads[block][element][:, :, None], master_quads[other][:, None, :])
        parts.append((row.ravel(), column.ravel(), coupling.ravel()))
    rows, columns, values = (np.concatenate(arrays) for arrays in zip(*parts, strict=True))
    shape = (len(slave_places), len(master_places))
    at_nodes = [np.bincount(slave_quads.ravel(), a.ravel(), len(slave_places)) for a in (covered, whole)]
    return coo_matrix((values, (rows, columns)), shape).tocsr(), *at_nodes


def _partners(
    slave_places: Floats, slave_quads: Integers, master_places: Floats, master_quads: Integers, tolerance: float
) -> tuple[Integers, NDArray[np.bool_]]:
    """Nearest master node of each corner, shape (elements, 4), and whether these four make one master element."""
    if not len(slave_quads) or not len(master_quads):
        return np.zeros_like(slave_quads), np.zeros(len(slave_quads), dtype=bool)
    slave_nodes, master_nodes = np.unique(slave_quads), np.unique(master_quads)
    distance, nearest = np.full(len(slave_places), np.inf), np.zeros(len(slave_places), dtype=np.int64)
    distance[slave_nodes], index = cKDTree(master_places[master_nodes]).query(slave_places[slave_nodes])
    nearest[slave_nodes] = master_nodes[index]
    ring = slave_places[slave_quads[:, RING]]
    edge = np.linalg.norm(ring - np.roll(ring, 1, axis=1), axis=2).min(axis=1)
    near = distance[slave_quads].max(axis=1) <= tolerance * edge
    own, others = (_incidence(quads, len(master_places)) for quads in (nearest[slave_quads], master_quads))
    return nearest[slave_quads], near & ((own @ others.T).max(axis=1).toarray().ravel() == 4)


def _incidence(quads: Integers, nodes: int) -> csr_matrix:
    return csr_matrix((np.ones(quads.size), quads.ravel(), np.arange(0, quads.size + 1, 4)), (len(quads), nodes))


def _corner_areas(quads: Floats) -> Floats:
    """Integral of each shape function in m2, for places of shape (elements, 4, 2), shape (elements, 4)."""
    along_x, along_y = quads[:, [1, 1, 3, 3]] - quads[:, [0, 0, 2, 2]], quads[:, [2, 3, 2, 3]] - quads[:, [0, 1, 0, 1]]
    return np.abs(_cross(along_x, along_y) @ CORNER_MASS)


def _clipped(
    slave: Floats, area: Floats, master: Floats, tree: shapely.STRtree
) -> tuple[Integers, Integers, Floats, Floats]:
    """Slave and master element of each overlap, its int psi_i N_j in m2, (., 4, 4), and int phi_i where covered."""
    element, other, pieces = _overlaps(slave, area, tree)
    triangles, piece = _triangles(pieces)
    weights = np.abs(_cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0]))
    points = np.concatenate([1 - POINTS.sum(axis=1, keepdims=True), POINTS], axis=1) @ triangles
    phi, N = _shapes(points, slave[element[piece]]), _shapes(points, master[other[piece]])
    weighted = np.swapaxes(phi * (weights[:, None] * POINT_WEIGHTS)[:, :, None], 1, 2)
    mass = _added(weighted @ phi, element[piece], len(slave))
    covered = mass.sum(axis=2)
    closed = covered.sum(axis=1) > LEAST_COVERED * area
    covered[~closed], mass[~closed] = 0.0, np.eye(4)
    dual = np.swapaxes(np.linalg.solve(mass, covered[:, :, None] * np.eye(4)), 1, 2)
    return element, other, dual[element] @ _added(weighted @ N, piece, len(pieces)), covered


def _overlaps(slave: Floats, area: Floats, tree: shapely.STRtree) -> tuple[Integers, Integers, NDArray[np.object_]]:
    """Slave element, master element and polygon of each overlap."""
    polygons = shapely.polygons(slave[:, RING])
    element, other = tree.query(polygons)
    pieces, pair = shapely.get_parts(shapely.intersection(polygons[element], tree.geometries[other]), return_index=True)
    kept = shapely.area(pieces) > LEAST_PIECE * area[element[pair]]
    return element[pair[kept]], other[pair[kept]], pieces[kept]


def _triangles(pieces: NDArray[np.object_]) -> tuple[Floats, Integers]:
    """Fans of triangles about the first corner of convex polygons, shape (triangles, 3, 2), and their polygons."""
    points, piece = shapely.get_coordinates(pieces, return_index=True)
    # rings end where they start: n corners are n + 1 points, and n - 2 of these have three more of their ring behind
    before = np.flatnonzero(piece[:-3] == piece[3:])
    first = np.searchsorted(piece, piece[before])
    return points[np.stack([first, before + 1, before + 2], axis=1)], piece[before]


def _shapes(points: Floats, quads: Floats) -> Floats:
    """Bilinear shape functions at points (elements, p, 2) of quads (elements, 4, 2), shape (elements, p, 4)."""
    origin, along_x, along_y = quads[:, :1], quads[:, 1:2] - quads[:, :1], quads[:, 2:3] - quads[:, :1]
    twist = quads[:, 3:] - quads[:, 2:3] - along_x
    s = np.full(points.shape, 0.5)
    for _ in range(20):
        d_x, d_y = along_x + s[..., 1:] * twist, along_y + s[..., :1] * twist
        gap = points - origin - s[..., :1] * along_x - s[..., 1:] * d_y
        step = np.stack([_cross(gap, d_y), _cross(d_x, gap)], axis=-1) / _cross(d_x, d_y)[..., None]
        s += step
        if np.abs(step).max(initial=0.0) < 1e-7:  # the next step would be its square
            break
    x, y = s[..., 0], s[..., 1]
    return np.stack([(1 - x) * (1 - y), x * (1 - y), (1 - x) * y, x * y], axis=-1)


def _cross(a: Floats, b: Floats) -> Floats:
    return a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0]


def _added(values: Floats, group: Integers, groups: int) -> Floats:
    """Sums of matrices (n, 4, 4) by group, shape (groups, 4, 4)."""
    members = csr_matrix((np.ones(len(group)), (group, np.arange(len(group)))), (groups, len(group)))
    return (members @ values.reshape(-1, 16)).reshape(-1, 4, 4)
