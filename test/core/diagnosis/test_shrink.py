"""Gap and shrink on the test runs, of sessions in which the truth is known."""

from __future__ import annotations

import numpy as np
import pytest

from core.diagnosis.drawn import Urn, part
from shoecal_core.diagnosis.shrink import excess, gap, judged_runs, shrink

LABEL, SIZE = "joint_offset (LHipRoll)", [0.04]


def test_noise_leaves_the_floor(urn: Urn) -> None:
    drawn = urn.draw(np.random.default_rng(1))
    rest = drawn.explained(None)[0]
    found = gap(drawn, rest)
    assert found.cop_mae_mm == pytest.approx(found.cop_floor_mm, rel=0.4)
    assert found.grf_mae_n < 1.4 * found.grf_floor_n
    assert abs(excess(drawn, rest, drawn.test)) < 1.0


def test_the_true_effect_takes_the_gap_away(urn: Urn) -> None:
    drawn = urn.draw(np.random.default_rng(2), {LABEL: SIZE})
    scored = drawn.scorer.score([part(drawn, LABEL)])
    drawn = drawn.at(scored)
    before = drawn.explained(None)[0]
    after, added = drawn.explained(scored)
    found = shrink(drawn, before, after)
    assert found.fraction > 0.9
    assert found.ci95[0] <= found.fraction <= found.ci95[1]
    assert found.cop_mae_mm[1] < 0.5 * found.cop_mae_mm[0]
    assert found.cop_mae_mm[0] == gap(drawn, before).cop_mae_mm
    assert np.abs(added).max() > 0.0


def test_nothing_done_shrinks_nothing_and_worse_is_negative(urn: Urn) -> None:
    drawn = urn.draw(np.random.default_rng(3), {LABEL: SIZE})
    drawn = drawn.at(drawn.scorer.score([part(drawn, LABEL)]))
    before = drawn.explained(None)[0]
    assert shrink(drawn, before, before).fraction == 0.0
    assert shrink(drawn, before, 2.0 * before).fraction < 0.0
    # Below the floor there is nothing to take away.
    assert shrink(drawn, 0.1 * before, before).fraction == 0.0


def test_only_test_runs_count(urn: Urn) -> None:
    drawn = urn.draw(np.random.default_rng(4), {LABEL: SIZE})
    before = drawn.explained(None)[0]
    wild = before.copy()
    wild[drawn.rows_of(drawn.train)] *= 100.0
    assert gap(drawn, wild) == gap(drawn, before)
    assert shrink(drawn, before, wild).fraction == 0.0
    assert judged_runs(drawn) == drawn.test
