"""How layers meet: bonded, in contact, or in contact and stitched."""

from __future__ import annotations

from typing import Annotated, ClassVar

from ncf_fenicsx.laws.contact import Enforcement, Friction
from ncf_fenicsx.parameters.kinds import Choice, Kind, parameter
from ncf_fenicsx.parameters.units import Penalty, PositiveForce, PositiveLength


class Bonded(Kind):
    """Neighbouring layers share their nodes."""

    family = "interface"
    kind = "bonded"
    holds: ClassVar[bool] = True


class OneSided(Kind):
    """Neighbouring layers touch, slide and can open."""

    family = "interface"
    kind = "one_sided"
    penalty: Penalty = parameter(
        10.0, description="contact stiffness in Pa/m, or a factor on the compaction tangent over the layer's thickness"
    )
    contact: Annotated[Enforcement, Choice("contact", "penalty")] = parameter({}, description="how it is enforced")
    friction: Friction | None = parameter(None, description="Coulomb friction between the layers; none unless given")

    @property
    def holds(self) -> bool:
        """Whether something keeps the layers from sliding away over each other."""
        return self.friction is not None or self.slip_stiffness > 0

    @property
    def opening_stiffness(self) -> float:
        """Stiffness against opening in Pa/m."""
        return 0.0

    @property
    def slip_stiffness(self) -> float:
        """Stiffness against slip in Pa/m."""
        return 0.0


class Stitched(OneSided):
    """Layers that touch, slide and open against the yarns that stitch them together, one for each pitch cell."""

    kind = "stitched"
    yarn_stiffness: PositiveForce = parameter("20 N", description="axial stiffness EA of a stitching yarn")
    yarn_length: PositiveLength = parameter("4 mm", description="length of yarn that stretches when layers open")
    pitch: tuple[PositiveLength, PositiveLength] = parameter(
        ("5 mm", "5 mm"), description="distance of the stitches along x and y"
    )
    slip_share: float = parameter(0.1, ge=0, description="stiffness of a stitch in slip over that in opening")

    @property
    def opening_stiffness(self) -> float:
        """EA / (length * pitch * pitch) in Pa/m."""
        return self.yarn_stiffness / (self.yarn_length * self.pitch[0] * self.pitch[1])

    @property
    def slip_stiffness(self) -> float:
        """Share of the stiffness in opening, in Pa/m."""
        return self.slip_share * self.opening_stiffness
