"""A stack that snaps through follows one history, whatever round-off does: as another number of ranks would have it."""

import numpy as np
import pytest
from program import DEMOS

from ncf_fenicsx import Scene, simulation
from ncf_fenicsx.report.reading import Results

pytestmark = pytest.mark.serial

QUIET = ["output.picture=false", "output.report=false", "output.fields_every=1000000"]


@pytest.mark.slow
def test_the_last_digit_of_a_modulus_changes_no_step_of_a_snap(folder):
    """The foot meets plies that bend, faces turn from stick to slip, and a wrinkle snaps up under a viscosity."""
    found = []
    for number, modulus in enumerate(("0.1 GPa", "0.100000000000001 GPa")):
        scene = Scene.read(DEMOS / "figure_1.toml", [*QUIET, f"laws.bending.modulus={modulus}"])
        result = simulation.run(scene, folder / str(number))
        assert result.done, result.reason
        found.append(Results.read(folder / str(number)).history)
    first, second = found
    assert first["viscous_share"].max() > 0
    assert first["time"] == pytest.approx(second["time"], rel=1e-9)
    largest = np.abs(first["tool_force"]).max()
    assert np.abs(first["tool_force"] - second["tool_force"]).max() < 1e-6 * largest
    assert np.abs(first["tool_force"] - second["tool_force"]).max() > 0  # round-off is seen, and does not grow
