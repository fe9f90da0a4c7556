"""What is drawn of a run when it has ended: the summary and the page."""

from __future__ import annotations

from mpi4py import MPI

from ncf_fenicsx.mesh.parallel import on_root
from ncf_fenicsx.output.results_folder import Results
from ncf_fenicsx.report.closing import drawings_of_run, drawn_or_told
from ncf_fenicsx.scene.settings import Output
from ncf_fenicsx.simulation.progress_bar import ProgressBar


def draw_closing_pictures(results: Results, output: Output, progress: ProgressBar, comm: MPI.Comm) -> None:
    """Draw ``summary.png`` and write ``report.html`` on rank 0, where the scene asks for them; collective.

    All results are on the disk by then. What cannot be drawn is a caution and no error: the run is not at fault, and
    ``ncf-fenicsx report`` writes the page again.
    """
    for words in on_root(comm, lambda: drawn_or_told(results.folder, drawings_of_run(output))):
        progress.caution(words)
