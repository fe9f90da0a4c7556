"""Which factors a scene gets, and whether they are kept."""

import pytest
from assembled import build

from ncf_fenicsx.solver import factor_choice
from ncf_fenicsx.solver.direct_factors import DirectFactors
from ncf_fenicsx.solver.layer_factors import LayerFactors

pytestmark = pytest.mark.two_ranks


@pytest.mark.parametrize(("way", "keeps"), [("automatic", None), ("new", False), ("kept", True), ("layers", True)])
def test_factors_are_kept_where_a_scene_says_so_or_has_many_unknowns(table, monkeypatch, way, keeps):
    problem, _ = build(table)
    unknowns = 3 * problem.space.dofmap.index_map.size_global
    for least in (unknowns, unknowns + 1):
        monkeypatch.setattr(factor_choice, "LARGE", least)
        linear = build(table | {"solver": {"factors": way}})[1].linear
        assert linear.keeps == (least == unknowns if keeps is None else keeps)
        assert isinstance(linear.factors, LayerFactors if way == "layers" else DirectFactors)
