"""A face of the modelled part made whole by its symmetry planes: extents and waves do not end there."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ncf_fenicsx.scene.stack import Sides

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]

PLANES = {"x_min": (0, np.min), "x_max": (0, np.max), "y_min": (1, np.min), "y_max": (1, np.max)}


class WholeFace:
    """A face and its mirror images; nodes on a symmetry plane are their own images.

    Args:
        undeformed: positions of the face's nodes in m, shape (nodes, 3).
        quads: nodes of its quadrilaterals, shape (quads, 4).
        sides: how the sides are held.

    Attributes:
        source: node that each node of the whole is an image of, shape (all nodes,).
        quads: nodes of the whole's quadrilaterals.
    """

    def __init__(self, undeformed: Floats, quads: Integers, sides: Sides) -> None:
        self.source: Integers = np.arange(len(undeformed))
        self.quads = quads
        self._sign: Floats = np.ones((len(undeformed), 3))
        self._offset: Floats = np.zeros((len(undeformed), 3))
        for name, side in sides:
            if side == "symmetry":
                axis, extreme = PLANES[name]
                self._add_image(self.positions(undeformed), axis, float(extreme(undeformed[:, axis])))

    def _add_image(self, positions: Floats, axis: int, plane: float) -> None:
        off = np.abs(positions[:, axis] - plane) > 1e-9 * np.ptp(positions)
        image = np.arange(len(positions))
        image[off] = len(positions) + np.arange(np.count_nonzero(off))
        sign, offset = self._sign[off], self._offset[off]
        sign[:, axis] *= -1
        offset[:, axis] = 2 * plane - offset[:, axis]
        self.source = np.concatenate([self.source, self.source[off]])
        self.quads = np.concatenate([self.quads, image[self.quads]])
        self._sign, self._offset = np.concatenate([self._sign, sign]), np.concatenate([self._offset, offset])

    def positions(self, positions: Floats) -> Floats:
        """Positions in m of all nodes of the whole, shape (all nodes, 3), from those of the face's own nodes."""
        return self._offset + self._sign * positions[self.source]
