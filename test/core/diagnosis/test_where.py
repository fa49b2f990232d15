"""Where the gap lies."""

from __future__ import annotations

import numpy as np

from core.diagnosis.drawn import Urn, hypothesis
from shoecal_core.diagnosis.where import where
from shoecal_core.error_sources.signals import CLOSURE, COP


def test_shares_add_up_and_the_largest_comes_first(urn: Urn) -> None:
    drawn = urn.draw(
        np.random.default_rng(1), {"payload (base_link)": [0.5], "latency (left)": [0.1]}
    )
    found = where(drawn, drawn.signal_model.residuals, None)
    shares = [one.share for one in found]
    assert shares == sorted(shares, reverse=True)
    assert 0.9 < sum(shares) <= 1.0 + 1e-9
    assert found[0].signal == "grf"
    assert found[0].run is None


def test_the_signal_and_the_run_that_hold_it_are_named(urn: Urn) -> None:
    workspace = urn.workspace
    run = workspace.test[0]
    for part, signals in ((CLOSURE, {"closure"}), (COP, {"cop_x", "cop_y"})):
        rest = np.zeros_like(workspace.signal_model.residuals)
        here = workspace.signal_model.samples.run == run
        rest[here, part] = 20.0 * workspace.floor[part]
        found = where(workspace, np.where(workspace.signal_model.mask, rest, 0.0), None)
        assert {one.signal for one in found} == signals
        motions = {track.run: track.motion for track in workspace.signal_model.samples.tracks}
        assert {(one.run, one.phase) for one in found} == {(run, motions[run])}


def test_without_a_gap_there_is_no_place(urn: Urn) -> None:
    assert where(urn.workspace, np.zeros_like(urn.workspace.signal_model.residuals), None) == ()


def test_a_slip_is_told_of_its_run_and_time(urn: Urn) -> None:
    slip = hypothesis(urn.workspace, "slip (left)")
    drawn = urn.draw(np.random.default_rng(2))
    form = slip.forms[0]
    found = where(drawn, drawn.signal_model.residuals, drawn.scorer.score([(slip, form)]))
    (event,) = (one for one in found if one.onset_s is not None)
    assert (event.run, event.onset_s, event.foot) == (form.shape.run, form.shape.onset, "left")
