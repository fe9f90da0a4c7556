"""The block of ``general_codes.py`` in FElupe: ``python general_codes_felupe.py BLOCK.json`` prints a JSON line.

Needs ``pip install "felupe[all]" pypardiso``; nothing of ncf_fenicsx.
"""

import json
import sys
from pathlib import Path

import felupe as fem
import numpy as np
import pypardiso


def press(block: dict) -> dict:
    """Press the cylinder into the block; force on it in N, and Newton iterations."""
    nx, ny, nz = block["divisions"]
    length, depth, height = block["size"]
    mesh = fem.Cube(b=(length, depth, height), n=(nx + 1, ny + 1, nz + 1))
    top = np.flatnonzero(np.isclose(mesh.z, height))
    mesh.add_points([0.0, 0.0, height + block["radius"]])
    field = fem.FieldContainer([fem.Field(fem.RegionHexahedron(mesh), dim=3)])
    solid = fem.SolidBody(fem.NeoHooke(mu=block["shear_modulus"], bulk=block["bulk_modulus"], parallel=True), field)
    contact = fem.ContactRigidCylinder(
        field,
        points=top,
        centerpoint=-1,
        radius=block["radius"],
        axis=[0.0, 1.0, 0.0],
        multiplier=block["penalty"] * length * depth / (nx * ny),
        symmetric=True,
    )
    free = {"x": (0, 1, 1), "y": (1, 0, 1), "z": (1, 1, 0)}
    held = {name: fem.Boundary(field[0], **{f"f{name}": 0.0}, skip=skip) for name, skip in free.items()}
    centre = mesh.npoints - 1
    points = np.zeros(mesh.npoints, dtype=bool)
    points[centre] = True
    held["fixed"] = fem.Boundary(field[0], mask=points, skip=(0, 0, 1))
    held["move"] = fem.Boundary(field[0], mask=points, skip=(1, 1, 0))
    iterations, solution = 0, field
    for step in range(1, block["steps"] + 1):
        held["move"].update(-block["travel"] * step / block["steps"])
        dof0, dof1 = fem.dof.partition(field, held)
        values = fem.dof.apply(field, held, dof0)
        result = fem.newtonraphson(
            items=[solid, contact],
            x0=solution,
            dof0=dof0,
            dof1=dof1,
            ext0=values,
            tol=block["tolerance"],
            solver=pypardiso.spsolve,
            verbose=0,
        )
        solution = result.x
        iterations += result.iterations
    force = np.asarray(result.fun).ravel()[3 * centre + 2]
    return {"force": abs(float(force)), "iterations": iterations}


if __name__ == "__main__":
    print(json.dumps(press(json.loads(Path(sys.argv[1]).read_text(encoding="utf-8")))))
