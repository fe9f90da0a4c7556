"""The one line that says what is wrong with a scene counts errors, not what follows from them."""

import pytest

from ncf_fenicsx import Scene, SceneError

BACKWARD = {"travel": ["0 mm", "0 mm", "-0.5 mm"], "speed": "-1 mm/min"}


def refused(table):
    with pytest.raises(SceneError) as caught:
        Scene.from_table(table)
    return str(caught.value)


def test_a_wrong_entry_of_a_list_is_one_error(table):
    table["tool"]["path"] = [BACKWARD]
    words = refused(table)
    assert "tool.path.0.speed = '-1 mm/min': expected a positive speed" in words
    assert "more)" not in words


def test_two_wrong_entries_are_two(table):
    table["tool"]["path"] = [BACKWARD, BACKWARD]
    assert refused(table).endswith("(and 1 more)")
