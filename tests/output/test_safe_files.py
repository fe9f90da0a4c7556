"""Files that cannot be written: one line, and what was written before stays."""

import tomllib

import meshio
import pytest
from runs_apart import SLOW_ROLLER, history, start

from ncf_fenicsx.output.safe_files import ResultError, replace

LIMITED = """
import resource
from ncf_fenicsx.simulation import simulation
begin = simulation.Simulation._start
def limited(self):
    resource.setrlimit(resource.RLIMIT_FSIZE, ({limit}, {limit}))
    return begin(self)
simulation.Simulation._start = limited
from ncf_fenicsx.cli import main
main()
"""


@pytest.mark.serial
@pytest.mark.parametrize(("limit", "file"), [(1000, "history.csv"), (12000, "0000.vtu"), (30000, "checkpoint.h5")])
def test_a_full_disk_is_one_line_and_what_was_written_stays(tmp_path, limit, file):
    """A limit on the size of files in bytes, from the start of the run on, stands for the disk."""
    ended = start(*SLOW_ROLLER, "--out", tmp_path / "run", code=LIMITED.format(limit=limit))
    errors = ended.communicate()[1]
    assert ended.returncode == 1
    assert errors.count("\n") == 1, errors
    assert f"{file}: File too large; what was written before stays readable" in errors
    assert tomllib.loads((tmp_path / "run" / "scene.toml").read_text())
    for row in history(tmp_path / "run"):
        assert None not in row.values()
    for fields in (tmp_path / "run" / "fields").glob("*.vtu"):
        assert len(meshio.read(fields).points)


@pytest.mark.serial
def test_a_read_only_folder_is_one_line(tmp_path):
    (tmp_path / "closed").mkdir(mode=0o555)
    ended = start(*SLOW_ROLLER, "--out", tmp_path / "closed" / "run")
    errors = ended.communicate()[1]
    assert ended.returncode == 2
    assert errors.count("\n") == 1
    assert "cannot be written to" in errors


def test_a_file_is_replaced_only_when_the_new_one_is_whole(tmp_path):
    target = tmp_path / "file.txt"
    replace(target, lambda path: path.write_text("old"))

    def fail(path):
        path.write_text("ne")
        raise OSError(28, "No space left on device")

    with pytest.raises(ResultError, match=r"file\.txt: No space left on device"):
        replace(target, fail)
    assert target.read_text() == "old"
    assert list(tmp_path.iterdir()) == [target]
