"""Force on a flat plate over Vf, from the paper's numbers alone: an example of another code's history.

Run: ``python3 demos/closed_form.py FILE.csv``; ``demos/closed_form.csv`` is what it writes. It uses nothing of this
program: 400 mm2 of fabric, 1 mm/min, Eq. 3 shifted to zero at Vf0, Eq. 4 with -1/alpha3, over that at 2 mm/min.
"""

import csv
import sys
from pathlib import Path

AREA = 20e-3 * 20e-3
VF0 = 1425 / (1.79e6 * 2e-3)
ROWS = 200


def growth(speed: float) -> float:
    """Eq. 4 at a speed in mm/min."""
    ratio = 85829 / 23726
    return ratio - (0.1254 * (speed / 2) ** 3.2054 + (ratio - 1) ** -1.6507) ** (-1 / 1.6507)


def sigma_beta(vf: float) -> float:
    """Eq. 3 in Pa."""
    return 96605 ** (1.5238 * vf + 0.0176) - 2254


with Path(sys.argv[1]).open("w", newline="", encoding="utf-8") as file:
    writer = csv.writer(file)
    writer.writerow(["vf_max", "tool_force [kN]", "tool_displacement [mm]"])
    for number in range(ROWS + 1):
        closed = 0.67e-3 * number / ROWS
        vf = VF0 / (1 - closed / 2e-3)
        force = AREA * growth(1) / growth(2) * (sigma_beta(vf) - sigma_beta(VF0))
        writer.writerow([f"{vf:.8f}", f"{1e-3 * force:.8f}", f"{1e3 * closed:.6f}"])
