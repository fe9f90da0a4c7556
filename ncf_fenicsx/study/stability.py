"""How far a scene can be pushed: runs of a grid, their table, their map, and what they come to in words."""

from __future__ import annotations

from ncf_fenicsx.errors import SceneError
from ncf_fenicsx.report.closing import drawn_or_told
from ncf_fenicsx.report.page import PAGE
from ncf_fenicsx.report.study_page import write_study
from ncf_fenicsx.scene import Scene
from ncf_fenicsx.study.choice import chosen
from ncf_fenicsx.study.stability_grid import stability_grid
from ncf_fenicsx.study.stability_map import ACCURATE, draw_map
from ncf_fenicsx.study.stability_runner import Runner
from ncf_fenicsx.workers.rows import Row


def study_stability(scene: Scene, runner: Runner, axes: list[str] | None = None) -> str:
    """Run the grid, or what is missing of it, and draw the map.

    Args:
        scene: the scene of the runner's file.
        runner: runs the cases.
        axes: beginnings of the names of those axes to run; all unless given.

    Returns:
        What the rows come to.

    Raises:
        SceneError: the scene's path does not begin with one tool going down, an axis is unknown, or the scheduler does
            not answer.
    """
    if len(scene.tool) != 1 or not (scene.tool[0].path[0].travel or (0, 0, 0))[2] < 0:
        raise SceneError("study stability: expected a scene with one tool whose path begins with a travel down")
    cases = stability_grid(scene)
    wanted = chosen((case.axis for case in cases), axes, "axis")
    rows = runner.run([case for case in cases if case.axis in wanted])
    order = {(case.axis, case.value): number for number, case in enumerate(cases)}
    rows = sorted((row for row in rows if (row["axis"], row["value"]) in order), key=lambda row: order[_key(row)])
    draw_map(rows, f"{scene.title}: how far it can be pushed", runner.folder / "stability.png")
    told = drawn_or_told(runner.folder, {PAGE: write_study})
    return "\n".join([f"{summary(rows)}; table, map and page in {runner.folder}", *(f"caution: {one}" for one in told)])


def _key(row: Row) -> tuple[str, str]:
    return row["axis"], row["value"]


def summary(rows: list[Row]) -> str:
    """Shares of what happened, in words."""
    sound = [row for row in rows if row["sound"] == "true"]
    done = [row for row in sound if row["ending"] == "done"]
    stopped = [row for row in sound if row["ending"] == "stopped"]
    differences = [abs(float(row["difference"])) for row in done if row["difference"]]
    worst = max(differences, default=0.0)
    close = sum(difference <= ACCURATE for difference in differences)
    return (
        f"{len(done)} of {len(sound)} runs with sound laws done, {len(stopped)} stopped with a reason, "
        f"{len(sound) - len(done) - len(stopped)} neither; {close} of {len(differences)} forces within 1 % of the same "
        f"run with smaller steps (worst {100 * worst:.2g} %)"
    )
