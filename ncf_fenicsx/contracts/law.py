"""What every law owes the rest of the program."""

from __future__ import annotations

from typing import Any, ClassVar

from ncf_fenicsx.parts import Part


class Law(Part):
    """A constitutive law."""

    symmetric: ClassVar[bool] = True
    """Whether the law's tangent is symmetric."""

    def check(self, scene: Any) -> None:
        """Raise `parts.impossible` if the law does not go with the rest of the scene."""

    @property
    def caution(self) -> str | None:
        """What a user of this law has to know before a run, in a sentence."""
        return None
