"""Hertz's line contact: a long rigid cylinder on a thick elastic block, over the closed form.

Run: ``docker/run python3 demos/verification/hertz.py [RESULTS_FOLDER]``; draws ``hertz.png`` in that folder.

The block is one solid: its layers are bonded and differ only in the number of elements through them. The computed
force gives Hertz's half width a and peak pressure p0, which the computed ones are compared with.
"""

import sys
from dataclasses import dataclass
from math import pi, sqrt
from pathlib import Path
from typing import Any

import meshio
import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.collections import PolyCollection
from matplotlib.figure import Figure
from mpi4py import MPI

from ncf_fenicsx import Scene, run

MM, KPA = 1e3, 1e-3
LIMIT = 0.02
"""Largest relative error of half width, peak pressure and profile."""
SCENE: dict[str, Any] = {
    "title": "Hertz's line contact",
    "gravity": "0 m/s^2",
    "laws": {"solid": {"modulus": "1 MPa", "poisson": 0.3}},
    "stack": {
        "layers": 8,  # 80 mm in all, and 80 mm to the free side: 22 half widths of the contact
        "thickness": "10 mm",
        "size": ["80 mm", "1 mm"],
        "through": [1, 1, 1, 2, 2, 4, 8, 32],
        "divisions": [200, 1],
        "grading": [0.85, 0.0],
        "focus": ["3.4 mm", "0 mm"],  # just inside the end of the contact, the history's width is that of its nodes
        "sides": {"y_max": "symmetry"},  # plane strain
    },
    "interface": {"kind": "bonded"},
    "tool": {
        "radius": "100 mm",
        "width": "infinite",
        "path": [{"travel": ["0 mm", "0 mm", "-0.25 mm"], "speed": "1 mm/min"}],
    },
    "solver": {"first_step": "15 s", "largest_step": "15 s"},
    "output": {"picture": False, "report": False},
}


@dataclass(frozen=True)
class Contact:
    """What was computed, and what Hertz says at the computed force.

    Attributes:
        line_force: computed force over length in N/m.
        half_width: computed half width in m.
        peak: computed peak pressure in Pa.
        hertz_half_width: a = sqrt(4 F R / (pi E* L)) in m.
        hertz_peak: p0 = E* a / (2 R) in Pa.
    """

    line_force: float
    half_width: float
    peak: float
    hertz_half_width: float
    hertz_peak: float

    @classmethod
    def of(cls, scene: Scene, row: dict[str, float]) -> "Contact":
        """Contact in a row of the history."""
        solid, radius, stack = scene.laws.solid, scene.tool[0].radius, scene.stack
        stiffness = solid.modulus / (1 - solid.poisson**2)
        length = stack.size[1] * stack.sides.copies / 2  # the plane x_min mirrors the cylinder, the others lengthen it
        line_force = row["tool_force"] / length
        half_width = sqrt(4 * line_force * radius / (pi * stiffness))
        peak = stiffness * half_width / (2 * radius)
        return cls(line_force, row["contact_width"] / 2, row["pressure_max"], half_width, peak)

    def pressure(self, x: np.ndarray) -> np.ndarray:
        """Hertz's pressure in Pa at a distance (m) from the middle."""
        return self.hertz_peak * np.sqrt(np.maximum(1 - (x / self.hertz_half_width) ** 2, 0.0))

    @property
    def errors(self) -> dict[str, float]:
        """Relative errors of half width and peak pressure."""
        return {
            "half width": self.half_width / self.hertz_half_width - 1,
            "peak pressure": self.peak / self.hertz_peak - 1,
        }


def press(folder: Path) -> tuple[Scene, Contact]:
    """Run the scene; on all ranks."""
    scene = Scene.from_table(SCENE)
    result = run(scene, folder, overwrite=True)
    assert result.done, result.reason
    return scene, Contact.of(scene, result.history[-1])


def read_last_fields(folder: Path) -> meshio.Mesh:
    """Last fields of a run, with the deformed nodes as points; on rank 0."""
    fields = meshio.read(sorted((folder / "fields").glob("*.vtu"))[-1])
    fields.points = fields.points + fields.point_data["displacement"]
    return fields


def profile(fields: meshio.Mesh) -> tuple[np.ndarray, np.ndarray]:
    """Place in m and pressure in Pa of the nodes that the cylinder presses, at y = 0 from the middle outwards."""
    pressure = fields.point_data["contact_pressure"]
    pressed = np.flatnonzero((pressure > 0) & (fields.points[:, 1] < 1e-9))
    order = pressed[np.argsort(fields.points[pressed, 0])]
    return fields.points[order, 0], pressure[order]


def draw(path: Path, scene: Scene, contact: Contact, fields: meshio.Mesh) -> None:
    """The stress in the block, and the pressure on it over Hertz's."""
    solid, radius = scene.laws.solid, MM * scene.tool[0].radius
    figure = Figure(figsize=(11, 5), dpi=130, layout="constrained")
    figure.suptitle(
        f"Hertz line contact: a long rigid cylinder (R = {radius:.0f} mm) pressed on a thick elastic block "
        f"(E = {1e-6 * solid.modulus:g} MPa, ν = {solid.poisson})"
    )
    block, pressure = figure.subplots(1, 2, width_ratios=(1, 1.25))
    draw_block(figure, block, scene, contact, fields)
    draw_pressure(pressure, contact, *profile(fields))
    FigureCanvasAgg(figure).print_png(path)


def draw_block(figure: Figure, axes: Any, scene: Scene, contact: Contact, fields: meshio.Mesh) -> None:
    """Elements near the contact, both halves, by vertical stress, and the cylinder's outline."""
    cells = fields.cells_dict["hexahedron"]
    stress = KPA * fields.cell_data_dict["stress_33"]["hexahedron"]
    quads = MM * fields.points[cells[:, [0, 1, 5, 4]]][:, :, [0, 2]]
    top, reach = MM * scene.stack.layers * scene.stack.thickness, 2.2 * MM * contact.hertz_half_width
    quads[:, :, 1] -= top
    for side in (1, -1):
        elements = PolyCollection(quads * [side, 1], array=stress, cmap="viridis", edgecolors="face", linewidths=0.2)
        elements.set_clim(-KPA * contact.hertz_peak, 0)
        axes.add_collection(elements)
    radius = MM * scene.tool[0].radius
    tip = MM * sum(segment.travel[2] for segment in scene.segments)
    x = np.linspace(-reach, reach, 201)
    axes.fill_between(x, tip + radius - np.sqrt(radius**2 - x**2), reach, color="lightgrey", edgecolor="black")
    axes.text(0, 0.26 * reach, "rigid cylinder", ha="center")
    half = MM * contact.half_width
    axes.annotate("", (-half, 0.09 * reach), (half, 0.09 * reach), arrowprops={"arrowstyle": "<->"})
    axes.text(0, 0.1 * reach, "contact, 2a", ha="center", va="bottom", fontsize="small")
    axes.set(xlim=(-reach, reach), ylim=(-1.5 * reach, 0.4 * reach), aspect="equal")
    axes.set(xlabel="x (mm)", ylabel="height over the undeformed top (mm)", title="vertical stress in the block")
    figure.colorbar(elements, ax=axes, label="vertical stress (kPa)", shrink=0.8)


def draw_pressure(axes: Any, contact: Contact, x: np.ndarray, computed: np.ndarray) -> None:
    """Nodal pressures of both halves over Hertz's, with the errors."""
    a = contact.hertz_half_width
    curve = a * np.sin(np.linspace(-pi / 2, pi / 2, 400))
    label = f"Hertz at the computed {contact.line_force:.1f} N/m: $p_0\\sqrt{{1 - x^2/a^2}}$"
    axes.plot(MM * curve, KPA * contact.pressure(curve), color="tab:orange", linewidth=2, label=label)
    both = np.concatenate([-x[::-1], x])
    axes.plot(
        MM * both, KPA * np.concatenate([computed[::-1], computed]), ".", color="tab:blue", label="computed, nodes"
    )
    width, peak = contact.errors.values()
    lines = [
        f"half width $a$: {MM * contact.half_width:.3f} mm, Hertz {MM * a:.3f} mm ({100 * width:+.2f} %)",
        f"peak $p_0$: {KPA * contact.peak:.2f} kPa, Hertz {KPA * contact.hertz_peak:.2f} kPa ({100 * peak:+.2f} %)",
    ]
    axes.text(0.5, 0.08, "\n".join(lines), transform=axes.transAxes, ha="center", va="bottom", fontsize=9)
    axes.set(xlabel="x (mm)", ylabel="contact pressure (kPa)", title="pressure under the cylinder")
    axes.set_ylim(0, 1.3 * KPA * contact.hertz_peak)
    axes.legend(loc="upper center")
    axes.grid(alpha=0.3)


def main(folder: Path) -> dict[str, float]:
    """Run, draw and print; return the relative errors."""
    scene, contact = press(folder)
    if MPI.COMM_WORLD.rank == 0:
        draw(folder / "hertz.png", scene, contact, read_last_fields(folder))
        print(f"line force: {contact.line_force:.2f} N/m")
        print(f"half width: {MM * contact.half_width:.4f} mm, Hertz {MM * contact.hertz_half_width:.4f} mm")
        print(f"peak pressure: {KPA * contact.peak:.3f} kPa, Hertz {KPA * contact.hertz_peak:.3f} kPa")
        print(*(f"relative error of the {name}: {value:+.2%}" for name, value in contact.errors.items()), sep="\n")
    return contact.errors


if __name__ == "__main__":
    target = Path(sys.argv[1] if len(sys.argv) > 1 else "results/hertz")
    if max(abs(error) for error in main(target).values()) > LIMIT:
        sys.exit(f"the computed contact differs from Hertz's by more than {LIMIT:.0%}")
