"""The cases of a stability study: one property of a scene changed at a time, and one pair of them together."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from ncf_fenicsx.scene import Scene
from ncf_fenicsx.workers.launch import folder_name

MM = 1e3


@dataclass(frozen=True)
class Case:
    """A scene with something changed.

    Attributes:
        axis: what is changed.
        value: to what, in words.
        overrides: ``key=value`` texts.
        sound: whether the laws are sound; the paper's as printed are not all.
    """

    axis: str
    value: str
    overrides: tuple[str, ...]
    sound: bool = True

    @property
    def name(self) -> str:
        """Of its folder."""
        return folder_name(f"{self.axis} {self.value}")


MODULI = ("1e6", "1e7", "1e8", "1e9", "1e10", "2.42e11", "1e12")
SHEAR_MODULI = ("1e2", "1e3", "1e4", "1e5", "1e6", "1e7", "1e8", "1e9")
PENALTIES = ("0.1", "1", "10", "100", "1e3", "1e4")
SPEEDS = ("0.01", "0.1", "1", "10", "100")
DEPTHS = ("0.5", "1", "1.5", "2", "2.5", "3", "3.5", "4")
ASPECTS = (0.1, 0.3, 1.0, 3.0, 10.0, 50.0)
PRINTED = {
    "Eq. 1": ("laws.in_plane.kind=as_printed",),
    "Eq. 2": ("laws.rate.normalised=lowest_speed",),
    "Eq. 3 raw": ("laws.compaction.toe=raw",),
    "Eq. 3 clipped": ("laws.compaction.toe=clip",),
    "Eq. 4": ("laws.rate.exponent=as_printed",),
}
DEPTH = '["0 mm", "0 mm", "-0.5 mm"]'
PRESS = '{travel = ["0 mm", "0 mm", "-0.5 mm"], speed = "1 mm/min"}'
PATHS = {
    "hold": f'[{PRESS}, {{hold = "60 s"}}]',
    "open": f'[{PRESS}, {{travel = ["0 mm", "0 mm", "1 mm"], speed = "1 mm/min"}}]',
    "reverse": "[{0}, {1}, {0}, {1}]".format(
        '{travel = ["0 mm", "0 mm", "-0.5 mm"], speed = "1 mm/min"}',
        '{travel = ["0 mm", "0 mm", "0.4 mm"], speed = "1 mm/min"}',
    ),
}


def stability_grid(scene: Scene) -> list[Case]:
    """Cases for a scene with one tool that goes down first."""
    return [
        *(Case("in-plane modulus (Pa)", value, (f"laws.in_plane.modulus={value} Pa",)) for value in MODULI),
        *(Case("shear modulus G_t (Pa)", value, (f"laws.shear.modulus={value} Pa",)) for value in SHEAR_MODULI),
        *(Case("tool penalty", value, (f"tool.penalty={value}",)) for value in PENALTIES),
        *(Case("layer penalty", value, (f"interface.penalty={value}",)) for value in PENALTIES),
        *(Case("speed (mm/min)", value, (f"tool.path.0.speed={value} mm/min",)) for value in SPEEDS),
        *(Case("depth (mm)", value, (f"tool.path.0.travel={_down(value)}",)) for value in DEPTHS),
        *_meshes(scene),
        *(Case("layers", kind, (f"interface={{kind='{kind}'}}",)) for kind in ("one_sided", "stitched", "bonded")),
        *(Case("path", name, (f"tool.path={path}",)) for name, path in PATHS.items()),
        Case("step", "all at once", (f"solver.first_step={_whole(scene)}", f"solver.largest_step={_whole(scene)}")),
        *(Case("as printed", name, overrides, sound=False) for name, overrides in PRINTED.items()),
        *_pairs(),
    ]


def _down(depth: str) -> str:
    return DEPTH.replace("0.5", depth)


def _whole(scene: Scene) -> str:
    return f"{scene.milestones[0]!r} s"


def _meshes(scene: Scene) -> Iterator[Case]:
    """Elements along x of some aspect, length over thickness, and elements through each layer."""
    stack = scene.stack
    along_y = stack.divisions_by_layer[0][1]
    for aspect in ASPECTS:
        along_x = max(round(stack.size[0] / (aspect * stack.thickness)), 1)
        overrides = (f"stack.divisions=[{along_x}, {along_y}]", "stack.grading=[0, 0]")
        yield Case("element aspect", f"{aspect:g}", overrides)
    for number in range(1, 5):
        yield Case("elements through a layer", str(number), (f"stack.through={number}",))


def _pairs() -> Iterator[Case]:
    """Stiff fibres with weak shear are the hardest pair: their ratio decides how a layer crimps."""
    for modulus in ("1e8", "1e10", "1e12"):
        for shear in ("1e3", "1e5", "1e7"):
            overrides = (f"laws.in_plane.modulus={modulus} Pa", f"laws.shear.modulus={shear} Pa")
            yield Case(f"G_t (Pa) at {modulus} Pa", shear, overrides)
