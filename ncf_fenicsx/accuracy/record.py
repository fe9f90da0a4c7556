"""What a sequence of runs writes: ``accuracy.json``, and error bars in its finest level; a companion writes bars."""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Any

from ncf_fenicsx.accuracy.answer import Answer, bar_words, words_of
from ncf_fenicsx.accuracy.bands import write_bands
from ncf_fenicsx.accuracy.quantities import QUANTITIES
from ncf_fenicsx.output.results_folder import ACCURACY
from ncf_fenicsx.output.safe_files import replace
from ncf_fenicsx.report.closing import drawings_of_run, drawn_or_told
from ncf_fenicsx.report.page import PAGE
from ncf_fenicsx.report.reading import read_record
from ncf_fenicsx.report.study_page import write_study
from ncf_fenicsx.scene.settings import Accuracy, Output


def write_answer(folder: Path, answer: Answer, asked: Accuracy, ending: tuple[bool, str] | None) -> dict[str, Any]:
    """Write ``accuracy.json`` of a sequence, also of one that goes on; what it holds.

    Args:
        folder: of the sequence.
        answer: by now.
        asked: what the scene asks for.
        ending: whether the tolerance was met, and why the sequence ended; None while it goes on.

    Raises:
        ResultError: it cannot be written.
    """
    record = {
        "asked": {"quantities": list(asked.quantities), "tolerance": asked.tolerance},
        "met": ending is not None and ending[0],
        "ending": "goes on, or was killed" if ending is None else ending[1],
        "quantities": {name: _quantity(answer, name) for name in answer.estimates},
        "words": answer.lines,
        "different_branches": answer.branches,
        "levels": [_level(answer, number) for number in range(len(answer.levels))],
    }
    _write(folder / ACCURACY, record)
    return record


def _quantity(answer: Answer, name: str) -> dict[str, Any]:
    """An estimate in SI; None for what is not known."""
    one = answer.estimates[name]
    numbers = {"value": one.value, "bar": one.bar, "relative_bar": one.relative, "order": one.order, "limit": one.limit}
    known = {key: value if math.isfinite(value) else None for key, value in numbers.items()}
    shown = {"unit": QUANTITIES[name].unit, "factor_to_unit": QUANTITIES[name].factor}
    words = {"title": QUANTITIES[name].title, "words": words_of(name, one), "bar_words": bar_words(name, one)}
    return known | {"levels": one.levels, "basis": one.basis.value} | shown | words


def _level(answer: Answer, number: int) -> dict[str, Any]:
    level = answer.levels[number]
    cost = {"unknowns": level.cost.unknowns, "seconds": level.cost.seconds, "peak_memory_mb": level.cost.memory / 1e6}
    changed = {"vf_field_change": answer.changes[number - 1]} if number and answer.changes else {}
    bars = {name: one.bar if math.isfinite(one.bar) else None for name, one in answer.until(number).estimates.items()}
    found = {"values": level.values, "bars": bars, **changed, "stability_lost_at": level.lost}
    return {"level": level.number, **cost, **found}


def show_in_finest(answer: Answer, record: dict[str, Any], output: Output) -> list[str]:
    """Put the error bars of a sequence beside the results of its finest run, and draw what its scene asks for of both.

    Args:
        answer: of the sequence, with a level at least.
        record: of it, as written.
        output: what the scene asks for.

    Returns:
        What could not be drawn.

    Raises:
        ResultError: they cannot be written.
    """
    shown = {key: record[key] for key in ("asked", "met", "ending", "quantities", "different_branches")}
    of_all = {PAGE: write_study} if output.report else {}
    return _show(answer, shown, output) + drawn_or_told(answer.levels[-1].folder.parent, of_all)


def show_of_companion(answer: Answer, output: Output) -> list[str]:
    """Put what a companion tells beside the results of its run, and draw what the scene asks for; as `show_in_finest`.

    Args:
        answer: of both, the companion first.
        output: what the scene asks for.
    """
    shown = {
        "quantities": {name: _quantity(answer, name) for name in answer.estimates},
        "different_branches": answer.branches,
        "companion": {
            name: one for name, one in _level(answer, 0).items() if name in ("unknowns", "seconds", "values")
        },
    }
    return _show(answer, shown, output)


def add_caution(folder: Path, words: str) -> None:
    """Add a caution to the record of a run.

    Raises:
        ResultError: it cannot be written.
    """
    record = read_record(folder)
    _write(folder / "run.json", record | {"cautions": [*record["cautions"], words]})


def _show(answer: Answer, shown: dict[str, Any], output: Output) -> list[str]:
    """Write error bars beside the finest run, and draw what its scene asks for with them; what could not be drawn."""
    finest = answer.levels[-1].folder
    write_bands(answer)
    _write(finest / "run.json", read_record(finest) | {"accuracy": shown})
    return drawn_or_told(finest, drawings_of_run(output))


def _write(path: Path, record: dict[str, Any]) -> None:
    replace(path, lambda beside: beside.write_text(json.dumps(record, indent=2) + "\n", encoding="utf-8"))
