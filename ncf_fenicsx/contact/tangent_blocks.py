"""Blocks of the tangent between the nodes of facing layers, spread over all that a node faces."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
from dolfinx import fem
from numpy.typing import NDArray

from ncf_fenicsx.contact.pairing import Pairing

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]
Blocks = tuple[Integers, Integers, Floats]
"""Global node numbers of rows and columns, shapes (n, a) and (n, b), and their blocks in N/m, (n, 3 a, 3 b)."""

BLOCKS_AT_ONCE = 4096


def nodal_blocks(pairing: Pairing, stiffness: Floats, coupled_below: bool) -> Iterator[Blocks]:
    """Blocks of forces that follow y - x node by node, without those of the lower nodes alone.

    Args:
        pairing: what each lower node faces.
        stiffness: derivative of the force on y by y in N/m, shape (nodes, 3, 3).
        coupled_below: whether the blocks between lower and upper nodes are among them.
    """
    for members, masters, weights in _groups(pairing):
        block = stiffness[members]
        yield masters, masters, _spread(block, weights, weights)
        if coupled_below:
            own = pairing.numbers[members, None]
            away = -np.ones(own.shape)
            yield own, masters, _spread(block, away, weights)
            yield masters, own, _spread(block, weights, away)


def stress_blocks(pairing: Pairing, numbers: Integers, by_facing: Any, by_displacement: Any) -> Iterator[Blocks]:
    """Blocks between the upper nodes and all nodes of the cells below, whose stress the contact pressure follows.

    Args:
        pairing: what each lower node faces.
        numbers: global number of each local node.
        by_facing: compiled derivative of the forces on the cells below by y.
        by_displacement: compiled derivative of the forces on y by the displacement of the cells below.
    """
    rows, columns, blocks = _entries(by_facing, len(numbers))
    for entries, masters, weights in _facing(pairing, columns):
        yield numbers[rows[entries], None], masters, _spread(blocks[entries], np.ones((len(entries), 1)), weights)
    rows, columns, blocks = _entries(by_displacement, len(numbers))
    for entries, masters, weights in _facing(pairing, rows):
        yield masters, numbers[columns[entries], None], _spread(blocks[entries], weights, np.ones((len(entries), 1)))


def _groups(pairing: Pairing) -> Iterator[tuple[Integers, Integers, Floats]]:
    """Groups of a pairing, a limited number of nodes at a time."""
    for members, masters, weights in pairing.groups():
        for start in range(0, len(members), BLOCKS_AT_ONCE):
            part = slice(start, start + BLOCKS_AT_ONCE)
            yield members[part], masters[part], weights[part]


def _facing(pairing: Pairing, nodes: Integers) -> Iterator[tuple[Integers, Integers, Floats]]:
    """Entries of a list of local nodes that face something, with the masters they face and their weights."""
    index = np.full(int(max(nodes.max(initial=0), pairing.nodes.max(initial=0))) + 1, -1)
    for members, masters, weights in _groups(pairing):
        index[:] = -1
        index[pairing.nodes[members]] = np.arange(len(members))
        entries = np.flatnonzero(index[nodes] >= 0)
        yield entries, masters[index[nodes[entries]]], weights[index[nodes[entries]]]


def _entries(form: Any, nodes: int) -> tuple[Integers, Integers, Floats]:
    """Local row and column nodes of a form's nonzero pattern on this rank's cells, and its blocks (entries, 3, 3).

    Columns past this rank's nodes are those that rows of other ranks have, in which its cells have no part.
    """
    matrix = fem.assemble_matrix(form).to_scipy(ghosted=True).tobsr((3, 3))
    rows = np.repeat(np.arange(len(matrix.indptr) - 1), np.diff(matrix.indptr))
    here = (matrix.indices < nodes) & (rows < nodes)
    return rows[here], matrix.indices[here].astype(np.int64), matrix.data[here]


def _spread(block: Floats, rows: Floats, columns: Floats) -> Floats:
    """Blocks (n, 3, 3) times weights of rows (n, a) and columns (n, b): (n, 3 a, 3 b)."""
    n, a, b = len(block), rows.shape[1], columns.shape[1]
    return np.einsum("nij,na,nb->naibj", block, rows, columns).reshape(n, 3 * a, 3 * b)
