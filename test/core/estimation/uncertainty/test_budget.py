"""Where the expected error of the CoP comes from."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from core.estimation.drawn import TOLERANCES, Drawn, drawn
from shoecal_core.error_sources.tolerances import Tolerances
from shoecal_core.estimation.uncertainty.budget import (
    NOISE,
    PRIOR,
    SIDEWAYS,
    SUPPORT,
    Budget,
    budget,
)
from shoecal_core.estimation.uncertainty.expected import ErrorModel, support_covariance


def budget_of(found: Drawn, tolerances: Tolerances = TOLERANCES) -> Budget:
    fit = found.fit
    model = ErrorModel.of(
        fit.signal_model.samples.robot, fit.shoe, fit.signal_model.samples.shoe, fit.parameters,
        *fit.measuring, support_covariance(fit, tolerances), tolerances,
    )  # fmt: skip
    return budget(fit, model, model.over_polygons())


@pytest.fixture(scope="module")
def found(known: Drawn) -> Budget:
    return budget_of(known)


def test_sources_make_the_whole(found: Budget) -> None:
    """Their mean squares add up to the total's, for both feet and for each."""
    squares = np.sum([one.size**2 for one in found.sources], axis=0)
    np.testing.assert_allclose(squares, found.total**2, rtol=1e-6)
    np.testing.assert_allclose(np.sum([one.share for one in found.sources], axis=0), 1.0)


def test_every_source_is_there_once_the_largest_first(known: Drawn, found: Budget) -> None:
    names = [one.effect for one in found.sources]
    assert len(names) == len(set(names))
    effects = {one.deviation.effect for one in known.fit.deviations} - {SUPPORT}
    assert effects | {NOISE, PRIOR, SIDEWAYS, SUPPORT} <= set(names)
    sums = [float(one.share.sum()) for one in found.sources]
    assert sums == sorted(sums, reverse=True)
    assert found.source("payload") is None


def test_intervals_are_of_shares(found: Budget) -> None:
    for one in found.sources:
        low, high = one.interval.T
        assert (low >= 0.0).all()
        assert (low <= high).all()
        assert (high <= 1.0 + 1e-9).all() or one.effect == NOISE


def test_what_is_known_exactly_wins(known: Drawn, found: Budget) -> None:
    for one in found.sources:
        if one.effect in (NOISE, PRIOR):
            assert np.isnan(one.without).all()
        else:
            assert (one.without <= found.total * (1.0 + 1e-9)).all()
    cells = found.source("cell_position")
    assert cells is not None
    assert (cells.without < 0.95 * found.total).any()


@pytest.mark.parametrize(
    ("effect", "setting"), [("cell_position", "cell_position_m"), ("plates", "plate_share")]
)
def test_knowing_a_source_is_what_a_fit_says_that_takes_it_for_exact(
    effect: str, setting: str
) -> None:
    """The same recording of a robot without errors, fitted with and without the source."""
    exact = replace(TOLERANCES, **{setting: 0.0})
    one = budget_of(drawn(7, share=0.0)).source(effect)
    assert one is not None
    fitted = budget_of(drawn(7, share=0.0, believed=exact), exact)
    np.testing.assert_allclose(one.without, fitted.total, rtol=0.03)
    assert fitted.source(effect) is None


def test_sideways_and_support_stand_where_they_act(found: Budget) -> None:
    sideways, support = found.source(SIDEWAYS), found.source(SUPPORT)
    assert sideways is not None
    assert support is not None
    assert sideways.size[0] == 0.0
    assert (sideways.size[1:] > 0.0).all()
    assert support.size[0] > 0.0
    assert not support.size[1:].any()


def test_it_is_the_same_each_time(known: Drawn, found: Budget) -> None:
    again = budget_of(known)
    assert again.to_json() == found.to_json()


def test_rows_for_result_files(found: Budget) -> None:
    rows = found.to_json()
    assert [row["source"] for row in rows] == [one.effect for one in found.sources]
    assert set(rows[0]) == {"source", "cop_share", "ci95", "cop_mm", "cop_mm_if_known"}
    by_name = {row["source"]: row for row in rows}
    assert by_name[NOISE]["cop_mm_if_known"] == [None, None, None]
