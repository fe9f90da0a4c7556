"""Pages as text: what they say of a run, what they do not let through, how large they get."""

import json
import re
from html.parser import HTMLParser

import numpy as np
import pytest
from program import call

from ncf_fenicsx.errors import SceneError
from ncf_fenicsx.report.curves import curves
from ncf_fenicsx.report.model import encode_model
from ncf_fenicsx.report.numbers import figures
from ncf_fenicsx.report.page import write_report
from ncf_fenicsx.report.reading import Results
from ncf_fenicsx.report.sentence import sentence
from ncf_fenicsx.report.thinning import evenly
from ncf_fenicsx.report.warnings import EXPLAINED, warnings

pytestmark = pytest.mark.serial
UNITS = {"N": 1.0, "mm": 1e-3, "kPa": 1e3, "s": 1.0, "": 1.0}


class Reader(HTMLParser):
    """Titles, anchors, links and cells of a page."""

    def __init__(self, path):
        super().__init__()
        self.tags, self.ids, self.links, self.cells = [], set(), [], []
        self.inside, self.texts = "", {"h1": "", "title": ""}
        self.feed(path.read_text("utf-8"))

    def handle_starttag(self, tag, attrs):
        attributes = dict(attrs)
        self.tags.append((tag, attributes))
        self.ids.add(attributes.get("id"))
        self.links += [attributes[name] for name in ("href", "src") if name in attributes]
        self.inside = tag
        if "data-column" in attributes:
            self.cells.append([attributes["data-column"], int(attributes["data-row"]), ""])

    def handle_endtag(self, tag):
        self.inside = "" if tag == self.inside else self.inside

    def handle_data(self, data):
        if self.inside in self.texts:
            self.texts[self.inside] += data
        if self.inside == "td" and self.cells and not self.cells[-1][2]:
            self.cells[-1][2] = data


def test_a_run_writes_its_page_and_its_scene(results):
    assert (results / "report.html").is_file()
    written = (results / "scene_as_written.toml").read_text("utf-8")
    assert written.startswith("# --set solver.largest_step='2 s'\n")
    shown = (results / "report.html").read_text("utf-8")
    assert "# --set solver.largest_step=&#x27;2 s&#x27;" in shown
    assert json.loads((results / "run.json").read_text("utf-8"))["command"].split()[0] in shown


def test_title_is_text(results):
    title = Results.read(results).scene.title
    read = Reader(results / "report.html")
    assert read.texts == {"h1": title, "title": title}
    assert not [tag for tag, _ in read.tags if tag == "b"]


def test_nothing_is_fetched_and_each_link_has_its_target(results):
    read = Reader(results / "report.html")
    assert [link for link in read.links if not link.startswith(("#", "data:"))] == []
    assert {link[1:] for link in read.links if link.startswith("#")} <= read.ids
    rules = next(a["content"] for tag, a in read.tags if tag == "meta" and "http-equiv" in a)
    assert "default-src 'none'" in rules


def test_numbers_equal_the_history(results):
    history = Results.read(results).history
    cells = Reader(results / "report.html").cells
    assert {column for column, _, _ in cells} >= {"tool_force", "vf_max", "gap_max_1", "time", "wall_time"}
    for column, row, text in cells:
        number, _, unit = text.partition(" ")
        assert float(number) * UNITS[unit] == pytest.approx(history[column][row], rel=5e-4), column


def test_figures_are_the_largest(results):
    read = Results.read(results)
    found = {figure.column: figure for figure in figures(read)}
    for column in ("tool_force", "vf_max", "gap_max_1"):
        assert read.history[column][found[column].row] == read.history[column].max()
    highest = next(column for column in found if column.startswith("wrinkle_height"))
    heights = [read.history[f"wrinkle_height_{layer}"].max() for layer in (1, 2)]
    assert read.history[highest][found[highest].row] == max(heights)


def test_the_gap_over_a_mould_is_no_void(copied):
    read = Results.read(copied)
    void = {figure.name: figure.value for figure in figures(read)}["Widest void"]
    read.history["mould_gap_max"] = np.linspace(0.0, 3e-3, read.rows)
    read.history["mould_void_volume"] = np.linspace(0.0, 2e-8, read.rows)
    found = {figure.name: figure for figure in figures(read)}
    assert found["Widest void"].value == void
    gap = found["Widest gap over the mould"]
    assert (gap.value, gap.column, gap.row) == ("3 mm", "mould_gap_max", read.rows - 1)
    assert gap.error == "at 12 s, 20 mm3 between stack and mould; not counted as a void"
    opening = next(curve for curve in curves(read) if curve["title"] == "Widest opening")
    assert opening["lines"][-1] == {"column": "mould_gap_max", "label": "stack and mould"}


def test_the_sentence_tells_the_case(results):
    told = sentence(Results.read(results))
    assert told == (
        "2 layers of 2 mm, 12 x 6 mm modelled (1/4 by symmetry), pressed by a cylinder (radius 2.5 mm, endless "
        "width), which moves 0.2 mm down at 1 mm/min."
    )


def test_warnings_have_explanations(copied):
    history = Results.read(copied).history
    text = (copied / "history.csv").read_text("utf-8").splitlines()
    names = text[0].split(",")
    changed = history | {
        "vf_error": np.full_like(history["time"], 0.3),
        "penetration_max": history["tool_displacement"],
        "support_force": history["support_force"] + 1.0,
        "negative_pivots": np.ones_like(history["time"]),
        "viscous_share": np.ones_like(history["time"]),
    }
    rows = [",".join(repr(float(changed[name][row])) for name in names) for row in range(len(history["time"]))]
    (copied / "history.csv").write_text("\n".join([text[0], *rows]) + "\n", encoding="utf-8")
    (copied / "run.json").unlink()
    found = warnings(Results.read(copied))
    about = {one.about for one in found}
    assert about == {
        f"about-{name}" for name in ("ending", "penetration", "error", "viscosity", "balance", "stability")
    }
    assert about <= set(EXPLAINED)
    shown = ("size-of-the-steps", "deepest-penetration", "estimated-errors-and-shares", "force", "negative-pivots")
    assert {one.place for one in found} == {f"curve-{name}" for name in shown}
    write_report(copied)
    read = Reader(copied / "report.html")
    assert {f"#{one.place}" for one in found} <= set(read.links)
    assert {link[1:] for link in read.links if link.startswith("#")} <= read.ids


def test_layers_that_penetrate_each_other_are_a_warning(copied):
    read = Results.read(copied)
    assert not [one for one in warnings(read) if "interface" in one.words]
    read.history["interface_penetration_max_1"][-1] = 0.05 * read.scene.stack.thickness
    (found,) = (one for one in warnings(read) if "interface" in one.words)
    assert found.words == "interface_penetration_max_1: faces penetrate each other by 0.1 mm, 5 % of a layer."


def test_cautions_of_a_run_lead_to_what_shows_them(copied):
    cautions = {
        "stability is lost at 3 s (2 negative pivots)": "curve-negative-pivots",
        "stack.divisions: elements under tool are up to 3 mm long along x": "view-of-the-stack",
        "tool never touched the stack: tool_force is 0, and 3 mm are left": "curve-force",
        "laws.compaction: the table is moved by 3 Pa": "file-scene",
    }
    record = json.loads((copied / "run.json").read_text("utf-8"))
    (copied / "run.json").write_text(json.dumps(record | {"cautions": list(cautions)}), encoding="utf-8")
    found = {one.words: one.place for one in warnings(Results.read(copied))}
    assert {words: found[words] for words in cautions} == cautions


def test_an_unfinished_folder_has_a_page(copied):
    (copied / "run.json").unlink()
    (copied / "summary.png").unlink()
    write_report(copied)
    assert "Not ended" in (copied / "report.html").read_text("utf-8")


def test_a_row_that_is_being_written_is_left_out(copied):
    whole = Results.read(copied).history
    with (copied / "history.csv").open("a", encoding="utf-8") as file:
        file.write("12.5,0.1,0.0")
    assert (Results.read(copied).history["time"] == whole["time"]).all()


@pytest.mark.parametrize("rows", [-1, 0, 1])
def test_a_run_that_has_only_begun_has_a_page(copied, rows):
    for name in ("run.json", "fields.pvd"):
        (copied / name).unlink()
    lines = (copied / "history.csv").read_text("utf-8").splitlines(keepends=True)
    (copied / "history.csv").write_text("".join(lines[: 1 + rows]), encoding="utf-8")
    write_report(copied)
    assert ("No step has been accepted yet" in (copied / "report.html").read_text("utf-8")) == (rows < 1)


def test_what_is_no_results_folder_is_one_line(tmp_path, copied):
    with pytest.raises(SceneError, match=r"has no scene\.toml; expected a results folder"):
        write_report(tmp_path)
    (copied / "run.json").write_text("{", encoding="utf-8")
    with pytest.raises(SceneError, match="cannot be read"):
        write_report(copied)


def test_steps_are_left_out_until_the_page_is_small(results):
    read = Results.read(results)
    whole = encode_model(read, 10_000_000)
    assert len(whole["times"]) == whole["steps_of_run"] == len(read.snapshots)
    small = len(json.dumps(whole)) - 3000
    fewer = encode_model(read, small)
    assert len(json.dumps(fewer)) <= small + 100
    assert 2 <= len(fewer["times"]) < fewer["steps_of_run"]
    assert fewer["times"][0] == whole["times"][0]
    assert fewer["times"][-1] == whole["times"][-1]
    assert "too much room for a page: 24 cells" in encode_model(read, 1000)["why_not"]


def test_even_steps_have_both_ends():
    assert evenly(1, 5) == [0]
    assert evenly(5, 9) == [0, 1, 2, 3, 4]
    assert evenly(11, 3) == [0, 5, 10]


def test_no_page_where_none_is_wanted(tmp_path, table):
    from ncf_fenicsx import Scene, run

    assert run(Scene.from_table(table), tmp_path / "run").done
    assert not (tmp_path / "run" / "report.html").exists()


def test_the_command_writes_a_page(copied, tmp_path):
    (copied / "report.html").unlink()
    done = call("report", copied)
    assert (done.returncode, done.stdout) == (0, f"page in {copied / 'report.html'}\n")
    wrong = call("report", tmp_path / "nothing")
    assert wrong.returncode == 2
    assert re.fullmatch(r"ncf-fenicsx: .*nothing: has no scene\.toml; expected a results folder\n", wrong.stderr)
