"""Nodes, quads and nodal areas of a rectangle."""

import numpy as np

LENGTH, WIDTH = 0.1, 0.05


def grid(x, y):
    """Positions and quads of a grid, with each node's share of the area."""
    X, Y = np.meshgrid(x, y)
    node = np.arange(X.size).reshape(X.shape)
    quads = np.stack([node[:-1, :-1], node[:-1, 1:], node[1:, :-1], node[1:, 1:]], axis=-1).reshape(-1, 4)
    area = np.outer(np.gradient(y) * share(y), np.gradient(x) * share(x))
    return np.stack([X.ravel(), Y.ravel()], axis=1), quads, area.ravel()


def share(coordinate):
    return np.where((coordinate == coordinate[0]) | (coordinate == coordinate[-1]), 0.5, 1.0)
