"""Weights between two faces that lie on each other with meshes of their own: dual mortar integrals in plan.

The lower face is the slave, the upper one the master; elements have four or nine nodes, x fastest. On each slave
element the dual functions psi = D M^-1 phi, with M = int phi phi^T and D = diag(int phi) over the part that master
elements cover (Wohlmuth; "consistent" after Cichosz & Bischoff 2011), add up to one and meet int psi_i phi_k = 0 for
i != k. So W_ij = int psi_i N_j / int psi_i takes linear fields of the master to the slave nodes exactly, and its
transpose carries a uniform pressure to the master as int N_j. Where master elements cover an element of nine nodes in
part, some int phi could be none or negative: its four quadrilaterals take its place. No DOLFINx here.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import shapely
from numpy.typing import NDArray
from scipy.sparse import coo_matrix, csr_matrix, diags
from scipy.spatial import cKDTree

from ncf_fenicsx.contact.face_overlaps import RING, Overlaps, PlanElements

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]
Entries = tuple[Integers, Integers, Floats]
"""Rows, columns and values of a sparse matrix."""

LEAST_WEIGHT = 1e-8  # weights below this are round-off
LEAST_COVERED = 0.05  # slave elements covered by less than this part count as open: M is badly conditioned there
ROUND_OFF = 1e-9  # of an element's area that may seem open where it is covered
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
    slave_positions: Floats,
    slave_elements: Integers,
    master_positions: Floats,
    master_elements: Integers,
    tolerance: float = 1e-6,
) -> Weights:
    """Weights of the master nodes for each slave node, and its coverage.

    Args:
        slave_positions: nodes in plan in m, shape (slave nodes, 2).
        slave_elements: nodes of each element, shape (slave elements, 4 or 9).
        master_positions: nodes in plan in m, shape (master nodes, 2).
        master_elements: nodes of each element, shape (master elements, 4 or 9).
        tolerance: slip, relative to the shortest edge between nodes of a slave element, up to which its nodes and those
            of a master element count as the same positions.
    """
    return normalised(*integrals(slave_positions, slave_elements, master_positions, master_elements, tolerance))


def normalised(coupling: csr_matrix, covered: Floats, whole: Floats) -> Weights:
    """Weights from ``integrals`` that are complete, that is, added up over all slave elements (and ranks)."""
    scale = np.divide(1.0, covered, out=np.zeros_like(covered), where=covered > 0)
    rows = csr_matrix(diags(scale) @ coupling)
    rows.data[np.abs(rows.data) < LEAST_WEIGHT] = 0.0
    rows.eliminate_zeros()
    rows.data /= np.repeat(np.asarray(rows.sum(axis=1)).ravel(), np.diff(rows.indptr))
    return Weights(rows, np.clip(np.divide(covered, whole, out=np.zeros_like(whole), where=whole > 0), 0.0, 1.0))


def integrals(
    slave_positions: Floats,
    slave_elements: Integers,
    master_positions: Floats,
    master_elements: Integers,
    tolerance: float = 1e-6,
) -> tuple[csr_matrix, Floats, Floats]:
    """Sums over these slave elements, which may be some of many; arguments as for ``dual_weights``.

    Returns:
        int psi_i N_j, shape (slave nodes, master nodes), int phi_i where covered, and int phi_i, shape (slave nodes,);
        all in m2. Row sums of the first are the second.
    """
    slave, master = PlanElements(slave_positions, slave_elements), PlanElements(master_positions, master_elements)
    partner, same = _partners(slave, master, tolerance)
    matched = slave.some(same)
    sums = _Sums(len(slave_positions), len(master_positions))
    sums.add(matched, matched.shares, matched.shares, (matched.nodes, partner[same], matched.shares))
    rest = slave.some(~same)
    tree = shapely.STRtree(master.polygons if len(rest.nodes) else [])
    for start in range(0, len(rest.nodes), BLOCK):
        _integrate(rest.some(slice(start, start + BLOCK)), master, tree, sums)
    return sums.result()


class _Sums:
    """Adds up the integrals of elements."""

    def __init__(self, slaves: int, masters: int) -> None:
        self._shape, self._entries = (slaves, masters), list[Entries]()
        self._covered, self._whole = np.zeros(slaves), np.zeros(slaves)

    def add(self, slave: PlanElements, covered: Floats, whole: Floats, entries: Entries) -> None:
        """Add int phi where covered and everywhere, shape (elements, nodes), and entries of int psi_i N_j."""
        np.add.at(self._covered, slave.nodes, covered)
        np.add.at(self._whole, slave.nodes, whole)
        rows, columns, values = np.broadcast_arrays(*entries)
        self._entries.append((rows.ravel(), columns.ravel(), values.ravel()))

    def result(self) -> tuple[csr_matrix, Floats, Floats]:
        """As of `integrals`."""
        rows, columns, values = (np.concatenate(arrays) for arrays in zip(*self._entries, strict=True))
        return coo_matrix((values, (rows, columns)), self._shape).tocsr(), self._covered, self._whole


def _partners(slave: PlanElements, master: PlanElements, tolerance: float) -> tuple[Integers, NDArray[np.bool_]]:
    """Nearest master node of each slave node, shape (elements, nodes), and whether these make one master element."""
    nearest, none = np.zeros(len(slave.positions), dtype=np.int64), np.zeros(len(slave.nodes), dtype=bool)
    if not len(slave.nodes) or not len(master.nodes) or slave.order != master.order:
        return nearest[slave.nodes], none
    slave_nodes, master_nodes = np.unique(slave.nodes), np.unique(master.nodes)
    distance = np.full(len(slave.positions), np.inf)
    distance[slave_nodes], index = cKDTree(master.positions[master_nodes]).query(slave.positions[slave_nodes])
    nearest[slave_nodes] = master_nodes[index]
    ring = slave.quads[:, RING]
    edge = np.linalg.norm(ring - np.roll(ring, 1, axis=1), axis=2).reshape(len(none), 4 * slave.pieces).min(axis=1)
    near = distance[slave.nodes].max(axis=1) <= tolerance * edge
    own, others = (_incidence(nodes, len(master.positions)) for nodes in (nearest[slave.nodes], master.nodes))
    shared = (own @ others.T).max(axis=1).toarray().ravel()
    return nearest[slave.nodes], near & (shared == slave.nodes.shape[1])


def _incidence(elements: Integers, nodes: int) -> csr_matrix:
    starts = np.arange(0, elements.size + 1, elements.shape[1])
    return csr_matrix((np.ones(elements.size), elements.ravel(), starts), (len(elements), nodes))


def _integrate(slave: PlanElements, master: PlanElements, tree: shapely.STRtree, sums: _Sums) -> None:
    """Add the integrals of slave elements, by their overlaps with the master's quadrilaterals."""
    overlaps, whole = Overlaps.of(slave, tree), slave.shares
    element = overlaps.quad // slave.pieces
    area = np.bincount(element, shapely.area(overlaps.polygons), len(slave.nodes))
    full = area > (1 - ROUND_OFF) * whole.sum(axis=1)
    if slave.order > 1 and not full.all():
        _integrate(slave.some(~full).in_pieces(), master, tree, sums)
        _integrate(slave.some(full), master, tree, sums)
        return
    points, weights, overlap = overlaps.points(max(slave.order, master.order))
    phi, N = slave.shapes(points, overlaps.quad[overlap]), master.shapes(points, overlaps.other[overlap])
    weighted = np.swapaxes(phi * weights[:, :, None], 1, 2)
    mass = _added(weighted @ phi, element[overlap], len(slave.nodes))
    covered = mass.sum(axis=2)
    closed = covered.sum(axis=1) > LEAST_COVERED * whole.sum(axis=1)
    covered[~closed], mass[~closed] = 0.0, np.eye(slave.nodes.shape[1])
    dual = np.swapaxes(np.linalg.solve(mass, covered[:, :, None] * np.eye(covered.shape[1])), 1, 2)
    coupling = dual[element] @ _added(weighted @ N, overlap, len(overlaps.quad))
    # so that coverage is one there also where quadrature is not exact, on distorted elements
    whole = np.where(full[:, None], covered, whole)
    nodes = slave.nodes[element][:, :, None], master.nodes[overlaps.other // master.pieces][:, None, :]
    sums.add(slave, covered, whole, (*nodes, coupling))


def _added(values: Floats, group: Integers, groups: int) -> Floats:
    """Sums of matrices (n, a, b) by group, shape (groups, a, b)."""
    members = csr_matrix((np.ones(len(group)), (group, np.arange(len(group)))), (groups, len(group)))
    rows = values.reshape(len(values), math.prod(values.shape[1:]))
    return np.asarray(members @ rows).reshape(groups, *values.shape[1:])
