"""A mesh file's groups against where they lie and where they face: names alone would be a wrong answer without a word.

Facets are judged one by one, by their own outward normal, so that a stack may be bent over a mould.
"""

from __future__ import annotations

import numpy as np

from ncf_fenicsx.errors import SceneError
from ncf_fenicsx.mesh.hexahedra import (
    FACES,
    TAGS,
    Hexahedra,
    Integers,
    alike,
    corner_volumes,
    outward_areas,
    point_in_words,
    unit,
)
from ncf_fenicsx.scene.stack import Stack

SMALLEST, LARGEST = 1e-5, 10.0
"""Extents in m of a stack that can be meant."""
SIDEWAYS = 0.05
"""Height of the unit normal of a facet that faces neither up nor down: within 3 degrees of the plane."""
ALONG = 1e-3
"""Least component of the unit normal of a facet of a side along the axis of that side."""
ROUND = 1e-3
"""Distance over the thickness of a layer that a facet may be off a plane of symmetry."""
TOWARDS = {
    "bottom": (2, -1),
    "top": (2, 1),
    "x_min": (0, -1),
    "x_max": (0, 1),
    "y_min": (1, -1),
    "y_max": (1, 1),
}
"""Axis that each outer face looks along, and in which direction."""
LATERAL = ("x_min", "x_max", "y_min", "y_max")


def check_mesh(settings: Stack, stack: Hexahedra) -> None:
    """Check that the groups of a mesh file lie and face as their names say; its cells have positive volumes.

    Args:
        settings: of the scene, whose planes of symmetry the mesh has to end at.
        stack: as read, before its layers are split or bonded.

    Raises:
        SceneError: one line with the group, the place and what was expected.
    """
    _check_turn(stack)
    for name in TOWARDS:
        _check_direction(stack, name)
    _check_sides_stand(stack)
    _check_outer_layers(stack)
    _check_shared_faces(stack)
    _check_heights(stack)
    for name, side in settings.sides:
        if side == "symmetry":
            _check_mirror(settings, stack, name)


def check_extent(stack: Hexahedra) -> None:
    """Refuse a mesh whose lengths cannot be metres."""
    for letter, extent in zip("xyz", np.ptp(stack.points, axis=0), strict=True):
        if not SMALLEST <= extent <= LARGEST:
            raise SceneError(
                f"mesh: it measures {1e3 * extent:.4g} mm along {letter}; expected {1e3 * SMALLEST:g} mm to "
                f"{LARGEST:g} m (a mesh's lengths are metres)"
            )


def _facets(stack: Hexahedra, name: str) -> tuple[Integers, Integers]:
    """Cell and face number of the facets of a group."""
    cell, face = np.nonzero(stack.face_tags == TAGS[name])
    return cell, face


def _place(stack: Hexahedra, cell: Integers, face: Integers, number: int) -> str:
    return point_in_words(stack.face_centres.reshape(-1, 6, 3)[cell[number], face[number]])


def _direction(axis: int, sign: float) -> str:
    """A direction along an axis in words."""
    if axis == 2:
        return "up" if sign > 0 else "down"
    return f"towards {'higher' if sign > 0 else 'lower'} {'xy'[axis]}"


def _check_turn(stack: Hexahedra) -> None:
    """The sides of a stack look along the axes: all turned alike, they are those of a stack that lies askew."""
    turns = {}
    for name in LATERAL:
        axis, sign = TOWARDS[name]
        x, y, _ = outward_areas(stack, *_facets(stack, name)).sum(axis=0)
        if np.hypot(x, y) > 0:
            turns[name] = complex(x, y) / np.hypot(x, y) / (sign * (1j if axis else 1))
    if len({name[0] for name in turns}) < 2:
        return
    mean = np.mean(list(turns.values()))
    angle = np.degrees(np.angle(mean))
    if max(abs(turn - mean) for turn in turns.values()) < 0.01 and abs(angle) > 0.5:
        raise SceneError(
            f"mesh: its sides {', '.join(turns)} are turned by {angle:.3g} degrees about z; "
            "expected a stack that lies along x and y"
        )


def _check_direction(stack: Hexahedra, name: str) -> None:
    """Every facet of a group looks where its name says."""
    cell, face = _facets(stack, name)
    axis, sign = TOWARDS[name]
    normals = unit(outward_areas(stack, cell, face))
    wrong = np.flatnonzero(sign * normals[:, axis] < (SIDEWAYS if axis == 2 else ALONG))
    if len(wrong):
        normal = normals[wrong[0]]
        looks = int(np.argmax(np.abs(normal)))
        raise SceneError(
            f"mesh: the facet of {name!r} at {_place(stack, cell, face, wrong[0])} faces "
            f"{_direction(looks, normal[looks])}; expected {_direction(axis, sign)}"
        )


def _check_sides_stand(stack: Hexahedra) -> None:
    """Facets of ``sides`` look anywhere but up or down."""
    cell, face = _facets(stack, "sides")
    normals = unit(outward_areas(stack, cell, face))
    wrong = np.flatnonzero(np.hypot(normals[:, 0], normals[:, 1]) < SIDEWAYS)
    if len(wrong):
        raise SceneError(
            f"mesh: the facet of 'sides' at {_place(stack, cell, face, wrong[0])} faces "
            f"{_direction(2, normals[wrong[0], 2])}; expected a side"
        )


def _check_outer_layers(stack: Hexahedra) -> None:
    """The bottom is that of the first layer, the top that of the last."""
    for name, expected in (("bottom", 0), ("top", int(stack.layer.max()))):
        cell, face = _facets(stack, name)
        wrong = np.flatnonzero(stack.layer[cell] != expected)
        if len(wrong):
            raise SceneError(
                f"mesh: the facet of {name!r} at {_place(stack, cell, face, wrong[0])} is one of "
                f"'layer_{stack.layer[cell[wrong[0]]] + 1}'; expected 'layer_{expected + 1}', layers from the bottom up"
            )


def _check_shared_faces(stack: Hexahedra) -> None:
    """Where cells of two layers share a face, the one lies on the other, and they are neighbours in the row."""
    group, count = alike(stack.face_vertices)
    order = np.argsort(group, kind="stable")
    first, second = order[count[order] == 2].reshape(-1, 2).T
    lower = np.where(stack.layer[first // 6] < stack.layer[second // 6], first, second)
    upper = np.where(lower == first, second, first)
    differ = stack.layer[lower // 6] != stack.layer[upper // 6]
    lower, upper = lower[differ], upper[differ]
    cell, face = lower // 6, lower % 6
    below, above = stack.layer[cell], stack.layer[upper // 6]
    heights = unit(outward_areas(stack, cell, face))[:, 2]
    wrong = np.flatnonzero((above != below + 1) | (heights < SIDEWAYS))
    if len(wrong):
        number = wrong[0]
        lies = "on" if heights[number] >= SIDEWAYS else "beside" if heights[number] > -SIDEWAYS else "below"
        raise SceneError(
            f"mesh: at {_place(stack, cell, face, number)} 'layer_{above[number] + 1}' lies {lies} "
            f"'layer_{below[number] + 1}'; expected layers on each other, from the bottom up"
        )


def _check_heights(stack: Hexahedra) -> None:
    """Layers with nodes of their own share no faces: the middle of each is above that of the one before."""
    volumes = corner_volumes(stack).mean(axis=1)
    centres = stack.points[stack.cells].mean(axis=1)
    total = np.bincount(stack.layer, volumes)
    heights = np.bincount(stack.layer, volumes * centres[:, 2]) / total
    wrong = np.flatnonzero(np.diff(heights) <= 0)
    if len(wrong):
        below, above = wrong[0], wrong[0] + 1
        raise SceneError(
            f"mesh: 'layer_{above + 1}' is at a height of {1e3 * heights[above]:.4g} mm, 'layer_{below + 1}' at "
            f"{1e3 * heights[below]:.4g} mm; expected layers from the bottom up"
        )


def _check_mirror(settings: Stack, stack: Hexahedra, name: str) -> None:
    """A plane of symmetry is a plane across its axis, and the stack ends there: its image is on the other side."""
    cell, face = _facets(stack, name)
    if not len(cell):
        return
    axis, sign = TOWARDS[name]
    end = sign * float((sign * stack.points[:, axis]).max())
    vertices = stack.points[stack.cells[cell[:, None], FACES[face]]]
    off = np.abs(vertices[:, :, axis] - end).max(axis=1)
    wrong = int(np.argmax(off))
    if off[wrong] > ROUND * settings.thickness:
        raise SceneError(
            f"mesh: the facet of {name!r} at {_place(stack, cell, face, wrong)} is {1e3 * off[wrong]:.4g} mm off "
            f"{'xy'[axis]} = {round(1e3 * end, 9) + 0.0:.4g} mm, where the stack ends; expected a plane there, "
            "as that side is one of symmetry"
        )
