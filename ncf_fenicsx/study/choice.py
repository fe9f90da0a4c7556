"""Which cases of a study are asked for."""

from __future__ import annotations

from collections.abc import Iterable

from ncf_fenicsx.errors import SceneError


def chosen(names: Iterable[str], beginnings: list[str] | None, option: str) -> set[str]:
    """Names that begin with one of some texts; all without any.

    Raises:
        SceneError: no name begins with one of the texts; it names the option that gave them.
    """
    known = list(dict.fromkeys(names))
    for text in beginnings or ():
        if not any(name.startswith(text) for name in known):
            found = ", ".join(known)
            raise SceneError(f"--{option} {text}: no such {option}; expected the beginning of one of: {found}")
    return {name for name in known if not beginnings or name.startswith(tuple(beginnings))}
