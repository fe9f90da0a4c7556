"""The study of error against run time: its reference, its errors, its front, its advice, and that it goes on."""

import csv
import math
from dataclasses import replace

import numpy as np
import pytest
from program import DEMOS

from ncf_fenicsx import Scene, SceneError, run
from ncf_fenicsx.report.reading import Results
from ncf_fenicsx.report.reference_solution import Extrapolated, VfField
from ncf_fenicsx.study.error_grid import TOGETHER, Variant, Variants
from ncf_fenicsx.study.error_time import ErrorTime, VariantWork, advice, runs_of
from ncf_fenicsx.study.work_precision import front

pytestmark = pytest.mark.serial
FILE = DEMOS / "long_roller.toml"
SMALL = ("stack.layers=2", "stack.divisions=[6, 1]", "laws.shear.modulus=2 MPa", "solver.max_steps=40")


@pytest.mark.parametrize("order", [0.7, 1.0, 2.0])
def test_the_limit_of_refinements_is_found_with_its_order(order):
    found = Extrapolated.of(*(5.0 + 0.3 * 2.0 ** (-order * level) for level in range(3)))
    assert found.value == pytest.approx(5.0)
    assert found.order == pytest.approx(order)
    assert found.uncertainty == pytest.approx(0.3 * 2.0 ** (-2 * order))


def test_values_that_do_not_converge_evenly_have_no_limit():
    assert math.isnan(Extrapolated.of(1.0, 2.0, 2.01).order)  # a chance
    found = Extrapolated.of(1.0, 2.0, 1.5)
    assert (found.value, found.uncertainty) == (1.5, 0.5)
    assert math.isnan(found.order)


def test_a_field_is_compared_cell_by_cell_with_a_finer_one(folder):
    """A coarse field that is made of the fine one's cells is off by what it cannot show."""
    press = [
        "stack.divisions=[12, 2]",
        "output.picture=false",
        "output.report=false",
        "tool.path.0.travel=['0 mm', '0 mm', '-0.1 mm']",
    ]
    fine = VfField(run(Scene.read(FILE, press), folder).folder)
    assert fine.off(fine, 0.4) == 0
    coarse = VfField(folder)
    pair = np.lexsort(fine.low.round(9).T).reshape(-1, 2)  # by z, then y, then x
    coarse.low, coarse.high = fine.low[pair[:, 0]], fine.high[pair[:, 1]]
    coarse.values = fine.values[pair].mean(axis=1)
    half = 0.5 * np.diff(fine.values[pair], axis=1)[:, 0]
    volumes = fine.volumes[pair]
    expected = (coarse.values[:, None] - fine.values[pair]) ** 2 * volumes
    rest = fine.values.mean()
    assert np.abs(half).max() > 0
    assert coarse.off(fine, rest) == pytest.approx(
        np.sqrt(expected.sum() / (fine.volumes @ (fine.values - rest) ** 2)), rel=1e-9
    )


def test_the_front_is_what_none_beats_in_both():
    assert front([(3, 0.1), (1, 0.5), (2, 0.6), (4, 0.2), (5, 0.01)]) == [(1, 0.5), (3, 0.1), (5, 0.01)]


def test_the_advice_is_the_cheapest_that_is_good_enough():
    rows = [
        {"method": "a", "level": "1", "force_error": "0.03", "seconds": "2", "memory_mb": "100"},
        {"method": "b", "level": "2", "force_error": "0.015", "seconds": "9", "memory_mb": "100"},
        {"method": "c", "level": "3", "force_error": "0.018", "seconds": "4", "memory_mb": "90"},
        {"method": "d", "level": "4", "force_error": "", "seconds": "", "memory_mb": ""},
    ]
    words = advice(rows).splitlines()
    assert words[0].startswith("for 5 % in force use a 1: 2.0 s, 100 MB, off by 3 %")
    assert words[1].startswith("for 2 % in force use c 3")
    assert words[2] == "for 1 % in force none of these is enough"


@pytest.mark.parametrize("name", ["long_roller", "roller", "deep", "relaxation"])
def test_every_variant_is_a_valid_scene_with_a_name_of_its_own(name):
    file = DEMOS / f"{name}.toml"
    variants = Variants(Scene.read(file), along_y=True, levels=3, through=True).all()
    assert len({variant.name for variant in variants}) == len(variants) > 30
    for variant in variants:
        Scene.read(file, variant.overrides)


def test_elements_through_a_layer_may_be_part_of_the_model():
    variants = Variants(Scene.read(FILE), True, 3, through=False).all()
    assert not any(
        "through" in text for variant in variants for text in variant.overrides if variant.method == TOGETHER
    )
    assert not any("through" in variant.method for variant in variants)


def test_a_strip_stands_for_the_same_whole():
    scene = Scene.read(FILE)
    strip = next(one for one in Variants(scene, True, 3, True).all() if one.method == "plane strain")
    narrow = Scene.read(FILE, strip.overrides)
    assert narrow.stack.size[1] * narrow.stack.sides.copies == scene.stack.size[1] * scene.stack.sides.copies
    assert narrow.stack.divisions[1] == 1


def test_a_study_weighs_its_runs_and_goes_on_where_it_was_ended(tmp_path):
    study = ErrorTime(FILE, tmp_path, SMALL, limit=200, along_y=False, levels=3, through=True)
    words = study.run(["elements"])
    assert words.startswith("for 5 % in force")
    with (tmp_path / "error_time.csv").open() as file:
        rows = list(csv.DictReader(file))
    assert [row["level"] for row in rows] == ["1", "2", "4", "1", "2", "3", "4"]
    assert {row["ending"] for row in rows} == {"done"}
    through = [float(row["vf_field_error"]) for row in rows[3:]]
    assert through[3] < through[0]
    assert all(0.1 < float(row["effectivity"]) < 3 for row in rows[3:])
    assert (tmp_path / "error_time.png").stat().st_size > 1e4
    before = (tmp_path / "runs.csv").read_text()
    study.run(["elements"])
    assert (tmp_path / "runs.csv").read_text() == before  # nothing was run again


def test_an_accuracy_that_is_asked_for_costs_all_its_levels(tmp_path):
    loose = Variant("accuracy asked", "30 %", ("accuracy.tolerance=30 %",), by_levels=True)
    strict = replace(loose, level="0.01 %", overrides=("accuracy.tolerance=0.01 %", "accuracy.most_memory=1 MB"))
    work = VariantWork(FILE, tmp_path, SMALL, 200, False, {(one.method, one.level): one for one in (loose, strict)})
    row = work(("accuracy asked", "30 %"))
    levels = [Results.read(folder) for folder in runs_of(tmp_path / loose.name)]
    assert row["ending"] == "done"
    assert len(levels) >= 3
    assert int(row["iterations"]) == sum(level.record["newton_iterations"] for level in levels)
    assert float(row["force_N"]) == pytest.approx(levels[-1].history["tool_force"].max(), rel=1e-7)
    assert int(row["unknowns"]) == max(level.record["unknowns"] for level in levels)
    assert work(("accuracy asked", "0.01 %"))["ending"] != "done"


def test_a_run_that_fails_is_a_row_and_a_reference_that_fails_is_told(tmp_path):
    stopped = ErrorTime(
        FILE, tmp_path, (*SMALL, "solver.max_steps=2"), limit=200, along_y=False, levels=3, through=True
    )
    with pytest.raises(SceneError, match="no such method; expected the beginning of one of: all refined"):
        stopped.run(["none"])
    variant = next(
        one for one in Variants(Scene.read(FILE, SMALL), True, 3, True).all() if one.method == "mesh in the plane"
    )
    work = VariantWork(FILE, tmp_path, stopped.overrides, 200, True, {("one", "1"): variant})
    row = {"force_N": ""} | work(("one", "1"))
    assert (row["ending"], row["reason"], row["force_N"]) == ("stopped", "max_steps = 2 reached", "")
    assert TOGETHER == "all refined together"
