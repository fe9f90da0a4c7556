"""Work along a path from forces at the ends of steps: order four, exact for cubics, and closed elastic cycles close."""

import numpy as np
import pytest

from ncf_fenicsx import Scene, run
from ncf_fenicsx.output.tool_work import ToolWork

pytestmark = pytest.mark.two_ranks


def work_of(times, force, position, ends):
    work = ToolWork(np.zeros(ToolWork.size(1)), ends)
    for time in times:
        work.add(time, np.array([force(time)]), np.array([position(time)]))
    return work


@pytest.mark.serial
def test_the_error_goes_with_the_fourth_power_of_the_step_and_is_known():
    """A tool at constant speed on a stack whose force grows e-fold in a second: 1 - e^-3 J."""
    errors = []
    for count in (12, 24, 48):
        times = np.concatenate([[0, 0.02], np.linspace(0.05, 3.0, count)])  # a piece begins with small steps
        work = work_of(times, lambda time: np.exp(time - 3), lambda time: -time, [3.0])
        errors.append(abs(work.total - (1 - np.exp(-3))))
        assert errors[-1] < work.error
    assert (np.log2(np.divide(errors[:-1], errors[1:])) > 3.5).all(), errors


@pytest.mark.serial
def test_a_kink_where_a_piece_ends_is_no_matter():
    """The slopes of force and position jump at 1 s; both are linear before and after, so that each piece is exact."""
    times = [0.0, 0.3, 1.0, 1.2, 2.0]
    work = work_of(times, lambda t: t if t <= 1 else 2 * t - 1, lambda t: -t if t <= 1 else 2 * t - 3, [1.0, 2.0])
    assert work.total == pytest.approx(0.5 - 4.0, rel=1e-12)
    across = work_of(times, lambda t: t if t <= 1 else 2 * t - 1, lambda t: -t if t <= 1 else 2 * t - 3, [2.0])
    assert across.total != pytest.approx(0.5 - 4.0, rel=1e-3)


@pytest.mark.parametrize("kind", ["exponential", "power"])
def test_an_elastic_cycle_gives_back_what_it_took(folder, kind):
    travel = {"speed": "1 mm/min"}
    table = {
        "stack": {"layers": 1, "size": ["6 mm", "4 mm"], "divisions": [2, 1], "grading": [0, 0]},
        "laws": {"rate": {"kind": "none"}, "compaction": {"kind": kind}},
        "tool": {
            "kind": "plate",
            "path": [travel | {"travel": ["0 mm", "0 mm", f"{way} mm"]} for way in ("-0.6", "0.6")],
        },
        "output": {"picture": False, "report": False, "fields_every": 1000},
    }
    result = run(Scene.from_table(table), folder)
    assert result.done, result.reason
    work = [row["tool_work"] for row in result.history]
    assert max(work) > 1e-4
    assert abs(work[-1]) < 1e-3 * max(work)
    assert result.history[-1]["tool_work_error"] < 1e-2 * max(work)
