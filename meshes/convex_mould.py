"""Stack of layers bent over a convex cylindrical mould: ``python3 meshes/convex_mould.py mould.msh --radius 0.1``.

The flat stack of ``stack.py`` is rolled onto a cylinder along y; arc lengths on the mould are the flat x.
"""

import gmsh
import numpy as np
from stack import build_from, options, positive, write_mesh


def bend(radius: float) -> None:
    """Move all nodes of the current model from the flat stack onto a mould of a radius (m), its crest at x = 0."""
    tags, coordinates, _ = gmsh.model.mesh.getNodes()
    for tag, (x, y, z) in zip(tags, coordinates.reshape(-1, 3), strict=True):
        angle, distance = x / radius, radius + z
        place = [distance * np.sin(angle), y, distance * np.cos(angle) - radius]
        gmsh.model.mesh.setNode(int(tag), place, [])


if __name__ == "__main__":
    parser = options()
    parser.add_argument("--radius", type=positive, default=0.1, help="radius of the mould (m)")
    given = parser.parse_args()
    build_from(given)
    bend(given.radius)
    write_mesh(given.file)
