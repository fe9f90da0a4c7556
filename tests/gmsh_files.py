"""Mesh files written by hand, number by number, so that each can have one defect that no mesher would make."""

from dataclasses import dataclass, field, replace

import numpy as np
import pytest
from mpi4py import MPI

from ncf_fenicsx import Scene, SceneError
from ncf_fenicsx.mesh import build_mesh

COMM = MPI.COMM_WORLD

GROUPS = ("layer_1", "layer_2", "layer_3", "bottom", "top", "x_min", "x_max", "y_min", "y_max", "sides", "layer_4")
NUMBERS = {name: number + 1 for number, name in enumerate(GROUPS)}
SIZES = {3: 4, 5: 8}
CORNERS = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (0, 0, 1), (1, 0, 1), (1, 1, 1), (0, 1, 1)]
"""Corners of a hexahedron in gmsh's order."""
FACES = {
    "z0": (0, 1, 2, 3),
    "z1": (4, 5, 6, 7),
    "y0": (0, 1, 5, 4),
    "y1": (2, 3, 7, 6),
    "x0": (0, 3, 7, 4),
    "x1": (1, 2, 6, 5),
}


@dataclass(frozen=True)
class MeshFile:
    """Nodes and elements as a file has them.

    Attributes:
        points: coordinates in m, shape (nodes, 3).
        tags: numbers of the nodes.
        elements: gmsh's type, physical number, tags of the nodes.
        names: of groups: dimension, number, name.
    """

    points: np.ndarray
    tags: list[int]
    elements: list[tuple[int, int, list[int]]]
    names: list[tuple[int, int, str]] = field(
        default_factory=lambda: [(3 if name.startswith("layer") else 2, NUMBERS[name], name) for name in GROUPS]
    )

    def with_points(self, change):
        """The same with other coordinates, ``change(points)``."""
        return replace(self, points=change(self.points.copy()))

    def regroup(self, change):
        """The same with other groups, ``change(name, centre in mm)``; an element of the group None is left out."""
        elements = []
        for kind, number, nodes in self.elements:
            name = change(GROUPS[number - 1], 1e3 * self.points[np.array(nodes) - 1].mean(axis=0))
            elements += [] if name is None else [(kind, NUMBERS[name], nodes)]
        return replace(self, elements=elements)

    def twice(self, name, other, kind):
        """The same with the first element of a group in another group too."""
        nodes = next(nodes for _, number, nodes in self.elements if number == NUMBERS[name])
        return replace(self, elements=[*self.elements, (kind, NUMBERS[other], nodes)])


def stack(layers=2, own_nodes=False, divisions=(3, 2), size=(12e-3, 6e-3), thickness=2e-3):
    """A good file: layers of one element each, on common nodes or on nodes of their own."""
    points, elements = [], []
    for layer in range(layers):
        for place in np.ndindex(*divisions, 1):
            corners = [tuple(np.add(place, corner) + np.array([0, 0, layer])) for corner in CORNERS]
            nodes = [_node(points, corner, layer if own_nodes else 0) for corner in corners]
            elements.append((5, NUMBERS[f"layer_{layer + 1}"], nodes))
            elements += [
                (3, NUMBERS[name], [nodes[k] for k in face]) for name, face in _outside(place, layer, layers, divisions)
            ]
    places = np.array([point for point, _ in points], dtype=float)
    scale = np.array([size[0] / divisions[0], size[1] / divisions[1], thickness])
    return MeshFile(places * scale, list(range(1, len(points) + 1)), elements)


def _node(points, corner, owner):
    key = (tuple(int(index) for index in corner), owner)
    if key not in points:
        points.append(key)
    return points.index(key) + 1


def _outside(place, layer, layers, divisions):
    ends = {"x0": ("x_min", place[0] == 0), "x1": ("x_max", place[0] == divisions[0] - 1)}
    ends |= {"y0": ("y_min", place[1] == 0), "y1": ("y_max", place[1] == divisions[1] - 1)}
    ends |= {"z0": ("bottom", layer == 0), "z1": ("top", layer == layers - 1)}
    return [(name, FACES[face]) for face, (name, is_outside) in ends.items() if is_outside]


def _head(mesh, line):
    names = "".join(f'{dimension} {number} "{name}"\n' for dimension, number, name in mesh.names)
    return f"$MeshFormat\n{line}\n$EndMeshFormat\n$PhysicalNames\n{len(mesh.names)}\n{names}$EndPhysicalNames\n"


def text_22(mesh, line="2.2 0 8"):
    """The file in format 2.2."""
    nodes = "".join(
        f"{tag} {x!r} {y!r} {z!r}\n" for tag, (x, y, z) in zip(mesh.tags, mesh.points.tolist(), strict=True)
    )
    rows = [[number + 1, kind, 2, group, group, *nodes] for number, (kind, group, nodes) in enumerate(mesh.elements)]
    elements = "".join(" ".join(map(str, row)) + "\n" for row in rows)
    return (
        f"{_head(mesh, line)}$Nodes\n{len(mesh.tags)}\n{nodes}$EndNodes\n"
        f"$Elements\n{len(rows)}\n{elements}$EndElements\n"
    )


def text_41(mesh, more=(), line="4.1 0 8"):
    """The file in format 4.1, where entities have groups: one entity each, and ``more`` physical numbers for a name."""
    groups = sorted({group for _, group, _ in mesh.elements})
    kinds = {group: kind for kind, group, _ in mesh.elements}
    entities = {dimension: [group for group in groups if kinds[group] == kind] for dimension, kind in ((2, 3), (3, 5))}
    lines = [f"0 0 {len(entities[2])} {len(entities[3])}"]
    for group in [*entities[2], *entities[3]]:
        numbers = [group, *(NUMBERS[other] for name, other in more if NUMBERS[name] == group)]
        lines.append(f"{group} 0 0 0 0 0 0 {len(numbers)} {' '.join(map(str, numbers))} 0")
    tags, places = "\n".join(map(str, mesh.tags)), "\n".join(f"{x!r} {y!r} {z!r}" for x, y, z in mesh.points.tolist())
    nodes = f"1 {len(mesh.tags)} {min(mesh.tags)} {max(mesh.tags)}\n3 1 0 {len(mesh.tags)}\n{tags}\n{places}\n"
    blocks, count = "", 0
    for group in groups:
        rows = [nodes for _, number, nodes in mesh.elements if number == group]
        blocks += f"{2 if kinds[group] == 3 else 3} {group} {kinds[group]} {len(rows)}\n"
        for row in rows:
            count += 1
            blocks += f"{count} {' '.join(map(str, row))}\n"
    elements = f"{len(groups)} {count} 1 {count}\n{blocks}"
    return (
        f"{_head(mesh, line)}$Entities\n{chr(10).join(lines)}\n$EndEntities\n$Nodes\n{nodes}$EndNodes\n"
        f"$Elements\n{elements}$EndElements\n"
    )


def binary(text):
    """A file of format 4.1 or 2.2 with its numbers in binary."""
    out, is_41 = b"", "4.1 0 8" in text
    for section in text.split("$End")[:-1]:
        name, _, body = section[section.index("$") + 1 :].partition("\n")
        if name == "MeshFormat":
            packed = body.replace(" 0 8", " 1 8").encode() + np.array([1], "<i4").tobytes() + b"\n"
        elif name == "PhysicalNames":
            packed = body.encode()
        else:
            packed = (_packed_41 if is_41 else _packed_22)(name, body) + b"\n"
        out += f"${name}\n".encode() + packed + f"$End{name}\n".encode()
    return out


def _packed_41(name, body):
    rows = [line.split() for line in body.splitlines()]
    out = np.array(rows[0], "<u8").tobytes()
    at = 1
    while at < len(rows):
        row = rows[at]
        at += 1
        if name == "Entities":
            count = int(row[7])
            parts = [(row[:1], "<i4"), (row[1:7], "<f8"), ([count], "<u8"), (row[8 : 8 + count], "<i4"), ([0], "<u8")]
            out += b"".join(np.array(values, kind).tobytes() for values, kind in parts)
            continue
        count = int(row[3])
        out += np.array(row[:3], "<i4").tobytes() + np.array([count], "<u8").tobytes()
        out += np.array(rows[at : at + count], "<u8").tobytes()
        at += count
        if name == "Nodes":
            out += np.array(rows[at : at + count], "<f8").tobytes()
            at += count
    return out


def _packed_22(name, body):
    count, *rows = body.splitlines()
    out = count.encode() + b"\n"
    for words in (row.split() for row in rows):
        if name == "Nodes":
            out += np.array(words[:1], "<i4").tobytes() + np.array(words[1:], "<f8").tobytes()
        else:
            out += np.array([words[1], 1, words[2], words[0], *words[3:]], "<i4").tobytes()
    return out


def write(folder, content, layers=2, sides=None):
    """A scene with a mesh file, on rank 0; the same on all."""
    path = folder / "mesh.msh"
    if COMM.rank == 0:
        path.write_bytes(content if isinstance(content, bytes) else content.encode())
    COMM.barrier()
    table = {"duration": "1 s", "stack": {"layers": layers, "mesh": str(path)}}
    if sides is not None:
        table["stack"]["sides"] = sides
    return Scene.from_table(table)


def line_of(scene):
    with pytest.raises(SceneError) as caught:
        build_mesh(scene, COMM)
    line = str(caught.value)
    assert "\n" not in line
    assert line.startswith(("mesh.msh: ", "mesh.inp: ", "mesh.vtu: ", "mesh: "))
    return line


GOOD = stack()
