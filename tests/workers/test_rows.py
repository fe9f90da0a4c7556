"""Rows are whole or not there, belong to one writer, and are told apart by their inputs; Parquet has their units."""

import pyarrow.parquet
import pytest

from ncf_fenicsx import SceneError
from ncf_fenicsx.sweeps.parquet import write_parquet
from ncf_fenicsx.workers.rows import Rows, read_rows

pytestmark = pytest.mark.serial
INPUTS, OUTCOMES = ["a [m]", "kind"], ["force [N]", "ending", "reason"]


def row(number, **changes):
    made = {"a [m]": repr(float(number)), "kind": "x", "force [N]": "2.5", "ending": "done", "reason": "the end"}
    return made | changes


def test_rows_are_known_again(tmp_path):
    path = tmp_path / "new" / "rows.csv"
    with Rows(path, INPUTS, OUTCOMES) as rows:
        rows.append(row(1, reason="two\nlines, a comma"))
        rows.append(row(2))
        assert rows.known == {("1.0", "x"), ("2.0", "x")}
    with Rows(path, INPUTS, OUTCOMES) as rows:
        assert rows.known == {("1.0", "x"), ("2.0", "x")}
    assert next(read_rows(path))["reason"] == "two lines, a comma"


def test_a_line_half_written_at_any_byte_is_no_row_and_the_next_one_is_whole(tmp_path):
    path = tmp_path / "rows.csv"
    with Rows(path, INPUTS, OUTCOMES) as rows:
        rows.append(row(1))
        rows.append(row(2))
    whole = path.read_bytes()
    for length in range(len(whole)):
        path.write_bytes(whole[:length])
        with Rows(path, INPUTS, OUTCOMES) as rows:
            for number in (1, 2):
                if (repr(float(number)), "x") not in rows.known:
                    rows.append(row(number))
        assert path.read_bytes() == whole


def test_one_writes_and_rows_of_other_inputs_are_refused(tmp_path):
    path = tmp_path / "rows.csv"
    with Rows(path, INPUTS, OUTCOMES), pytest.raises(SceneError, match="another study writes there"):
        Rows(path, INPUTS, OUTCOMES).__enter__()
    with pytest.raises(SceneError, match="has rows of other inputs: a \\[m\\], kind"):
        Rows(path, ["b"], OUTCOMES).__enter__()


def test_parquet_has_numbers_words_and_units(tmp_path):
    path = tmp_path / "rows.csv"
    with Rows(path, INPUTS, OUTCOMES) as rows:
        for number in range(2500):
            rows.append(row(number, **{"force [N]": ""} if number == 7 else {}))
    table = pyarrow.parquet.read_table(write_parquet(path))
    assert table.num_rows == 2500
    assert table.column_names == ["a", "kind", "force", "ending", "reason"]
    assert table.schema.field("a").metadata == {b"unit": b"m"}
    assert table.schema.field("force").metadata == {b"unit": b"N"}
    assert table["a"].to_pylist() == [float(number) for number in range(2500)]
    assert table["force"].to_pylist()[6:9] == [2.5, None, 2.5]
    assert set(table["kind"].to_pylist()) == {"x"}
