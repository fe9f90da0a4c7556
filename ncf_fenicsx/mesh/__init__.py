"""The stack as a mesh: elements, faces, fields of state, and where tools meet it."""

from ncf_fenicsx.mesh.stack_mesh import StackMesh, build_mesh

__all__ = ["StackMesh", "build_mesh"]
