"""Faces of the stack where something touches: their nodes, values at the nodes, and their geometry on every rank."""

from __future__ import annotations

from typing import Any

import numpy as np
import ufl
from dolfinx import fem, la
from numpy.typing import NDArray

from ncf_fenicsx.laws.kinematics import Expression
from ncf_fenicsx.mesh import compat
from ncf_fenicsx.mesh.elements import Element, sub_quads

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]


class NodalSpaces:
    """Fields with values at the nodes of a mesh, the same node bearing the same number in both spaces.

    Args:
        vectors: space of displacements.
        element: of their components.

    Attributes:
        scalars: the same of scalars.
        owned: number of nodes that this rank owns, the first ones.
        numbers: global number of each local node.
    """

    def __init__(self, vectors: Any, element: Element) -> None:
        self.vectors, self.mesh, self.element = vectors, vectors.mesh, element
        self.scalars = compat.nodal_space(self.mesh, element.basix(), element.has_bare_entities)
        assert np.array_equal(self.scalars.dofmap.list, vectors.dofmap.list)
        index_map = vectors.dofmap.index_map
        self.owned = index_map.size_local
        local = np.arange(index_map.size_local + index_map.num_ghosts, dtype=np.int32)
        self.numbers: Integers = index_map.local_to_global(local)

    def scalar(self) -> Any:
        """A new scalar field, 0 everywhere."""
        return fem.Function(self.scalars)

    def vector(self) -> Any:
        """A new vector field, 0 everywhere."""
        return fem.Function(self.vectors)

    def forces(self, form: Any) -> Floats:
        """Nodal forces in N of a compiled linear form at this rank's owned nodes, shape (nodes, 3)."""
        vector = fem.assemble_vector(form)
        vector.scatter_reverse(la.InsertMode.add)
        forces: Floats = vector.array.reshape(-1, 3)[: self.owned].copy()
        return forces


class Face:
    """Facets with some tags.

    Args:
        spaces: nodal spaces of the mesh.
        facet_tags: DOLFINx tags of its facets.
        tags: of the facets that belong to the face.

    Attributes:
        measure: UFL measure of the undeformed face that evaluates at nodes.
        area: share of the undeformed face of each local node of the mesh in m2, 0 off the face.
    """

    def __init__(self, spaces: NodalSpaces, facet_tags: Any, tags: tuple[int, ...]) -> None:
        self.spaces = spaces
        ds = ufl.Measure("ds", domain=spaces.mesh, subdomain_data=facet_tags, metadata=spaces.element.face_rule)
        self.measure = ds(tags)
        self.facets = np.sort(np.concatenate([facet_tags.find(tag) for tag in tags])).astype(np.int32)
        self.area = self.assembled(self.density(fem.Constant(spaces.mesh, 1.0)))

    def density(self, density: Expression) -> Any:
        """Compiled form of a density per undeformed area, each node taking its share."""
        shape = ufl.as_ufl(density).ufl_shape
        test = ufl.TestFunction(self.spaces.vectors if shape else self.spaces.scalars)
        return compat.compile_form(ufl.inner(density, test) * self.measure)

    def assembled(self, form: Any) -> Floats:
        """Sum over the facets around each local node, of all ranks; shape (nodes,) or (nodes, 3)."""
        vector = fem.assemble_vector(form)
        vector.scatter_reverse(la.InsertMode.add)
        vector.scatter_forward()
        size = form.function_spaces[0].dofmap.index_map_bs
        return vector.array.reshape(-1, 3).copy() if size == 3 else vector.array.copy()

    def values(self, form: Any) -> Floats:
        """Mean of a `density` over the facets around each local node; 0 off the face."""
        total = self.assembled(form)
        area = self.area if total.ndim == 1 else self.area[:, None]
        return np.divide(total, area, out=np.zeros_like(total), where=area > 0)

    def owned(self) -> Integers:
        """Nodes of the face that this rank owns, shape (nodes,)."""
        used: Integers = np.flatnonzero(self.area[: self.spaces.owned] > 0)
        return used


class SharedFace:
    """Elements of a face, known on every rank.

    Args:
        spaces: nodal spaces of the mesh.
        facets: this rank's facets.

    Attributes:
        numbers: global numbers of the face's nodes, ascending, shape (nodes,).
        elements: nodes of each element's face, x fastest, counted along ``numbers``, shape (elements, 4 or 9).
        quads: quadrilaterals between neighbouring nodes, shape (quads, 4).
        local: this rank's local nodes of the face, ghosts included.
        index_of_local: where each of them stands in ``numbers``.
    """

    def __init__(self, spaces: NodalSpaces, facets: Any) -> None:
        self.comm = spaces.mesh.comm
        everywhere = np.concatenate(self.comm.allgather(spaces.numbers[_facet_nodes(spaces, facets)]))
        self.numbers, compact = np.unique(everywhere, return_inverse=True)
        self.elements: Integers = compact.reshape(everywhere.shape)
        self.quads: Integers = sub_quads(self.elements)
        self.local = np.flatnonzero(np.isin(spaces.numbers, self.numbers))
        self.index_of_local = np.searchsorted(self.numbers, spaces.numbers[self.local])
        self._mine = self.local < spaces.owned
        self._order = np.concatenate(self.comm.allgather(self.index_of_local[self._mine]))
        self.undeformed = self.gather(spaces.scalars.tabulate_dof_coordinates())

    def gather(self, values: Floats) -> Floats:
        """Values at the face's nodes on every rank, from values at each rank's local nodes; shape (nodes, ...)."""
        parts = self.comm.allgather(values[self.local[self._mine]])
        gathered = np.empty((len(self.numbers), *values.shape[1:]))
        gathered[self._order] = np.concatenate(parts)
        return gathered


def _facet_nodes(spaces: NodalSpaces, facets: Any) -> Integers:
    """Local nodes of facets, x fastest, shape (facets, nodes)."""
    topology = spaces.mesh.topology
    topology.create_connectivity(2, 3)
    topology.create_connectivity(3, 2)
    cells = np.array([topology.connectivity(2, 3).links(facet)[0] for facet in facets], dtype=np.int64)
    around = topology.connectivity(3, 2).array.reshape(-1, 6)[cells]
    face = np.argmax(around == np.asarray(facets)[:, None], axis=1) if len(cells) else cells
    around_cell = spaces.vectors.dofmap.list[cells]
    nodes: Integers = np.take_along_axis(around_cell, spaces.element.faces[face], axis=1).astype(np.int64)
    return nodes
