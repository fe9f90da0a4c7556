"""Fabric files: the laws of a fabric with the source of each number, for many scenes to share."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from ncf_fenicsx.errors import SceneError
from ncf_fenicsx.parameters.kinds import nearest
from ncf_fenicsx.scene.scene_file import read_table

SHIPPED = Path(__file__).parent / "fabrics"
GIVES = {
    "stack": ("thickness", "areal_density", "fibre_density"),
    "laws": None,
    "interface": ("friction",),
    "output": ("permeability",),
}
"""Tables of a scene that a fabric may give, with the keys in each; None for all."""
BESIDE = ("title", "sources", "fit")
"""What a fabric file has for its readers, not for scenes."""


def with_fabric(data: dict[str, Any], source: Path) -> dict[str, Any]:
    """Table of a scene with the laws of the fabric that it names; what the scene says itself stays.

    A law of the scene that is of another kind than the fabric's takes its place.

    Args:
        data: table of the scene.
        source: file of the scene; a fabric is looked for beside it, or among those that ship by its bare name.

    Raises:
        SceneError: there is no such fabric, or it gives what a fabric does not have.
    """
    if "fabric" not in data:
        return data
    own = {key: value for key, value in data.items() if key != "fabric"}
    fabric = read_fabric(_found(data["fabric"], source))
    given = {table: fabric[table] for table in GIVES if table in fabric}
    interface = own.get("interface", {})
    if not isinstance(interface, dict) or interface.get("kind") == "bonded":
        given.pop("interface", None)  # several ways to meet, or none to slide: a scene says itself where friction is
    return _merged(given, own)


def read_fabric(path: Path) -> dict[str, Any]:
    """Table of a fabric file.

    Raises:
        SceneError: it cannot be read, or gives what a fabric does not have.
    """
    table = read_table(path)
    for name, value in table.items():
        if name in BESIDE:
            continue
        if name not in GIVES:
            raise SceneError(f"{path}: {name}: unknown key of a fabric; {nearest(name, [*GIVES, *BESIDE])}")
        allowed = GIVES[name]
        if not isinstance(value, dict):
            raise SceneError(f"{path}: {name} = {value!r}: expected a table")
        wrong = [key for key in value if allowed is not None and key not in allowed]
        if wrong:
            raise SceneError(f"{path}: {name}.{wrong[0]}: not of a fabric; {nearest(wrong[0], list(allowed or ()))}")
    return table


def _found(name: Any, source: Path) -> Path:
    shipped = sorted(path.stem for path in SHIPPED.glob("*.toml"))
    if not isinstance(name, str):
        raise SceneError(f"{source}: fabric = {name!r}: expected a file, or one of {', '.join(shipped)}")
    path = SHIPPED / f"{name}.toml" if name in shipped else source.parent / name
    if not path.is_file():
        raise SceneError(f"{source}: fabric = {name!r}: no such file beside the scene, nor one of {', '.join(shipped)}")
    return path


def _merged(below: Any, above: Any) -> Any:
    """Two nested tables, the second of which wins; a table of another kind takes the other's place."""
    if not (isinstance(below, dict) and isinstance(above, dict)):
        return above
    if "kind" in above and above["kind"] != below.get("kind", above["kind"]):
        return above
    shared = {key: _merged(below[key], value) if key in below else value for key, value in above.items()}
    return {**below, **shared}


def list_fabrics() -> str:
    """The fabrics that ship, each with its laws and the sources of its numbers."""
    lines = []
    for path in sorted(SHIPPED.glob("*.toml")):
        fabric = read_fabric(path)
        lines.append(f"{path.stem}: {fabric['title']}")
        lines += [f"  {key}: {source}" for key, source in fabric["sources"].items()]
    return "\n".join(lines)
