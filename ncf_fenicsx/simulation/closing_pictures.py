"""What is drawn of a run when it has ended: the summary and the page."""

from __future__ import annotations

from mpi4py import MPI

from ncf_fenicsx.mesh.parallel import on_root
from ncf_fenicsx.output.results_folder import Results
from ncf_fenicsx.report.page import write_report
from ncf_fenicsx.report.summary_picture import draw_summary
from ncf_fenicsx.scene.settings import Output
from ncf_fenicsx.simulation.progress_bar import ProgressBar


def draw_closing_pictures(results: Results, output: Output, progress: ProgressBar, comm: MPI.Comm) -> None:
    """Draw ``summary.png`` and write ``report.html`` on rank 0, where the scene asks for them; collective.

    All results are on the disk by then. A page that cannot be made is a note and no error: the run is not at fault,
    and ``ncf-fenicsx report`` makes it again.
    """
    if output.picture:
        on_root(comm, lambda: draw_summary(results.folder))
    if output.report:
        failed = on_root(comm, lambda: _reported(results))
        if failed:
            progress.note(f"no report.html: {failed}; all else is written")


def _reported(results: Results) -> str:
    """Why the page could not be made; empty if it was."""
    try:
        write_report(results.folder)
    except Exception as error:
        return f"{type(error).__name__}: {error}"
    return ""
