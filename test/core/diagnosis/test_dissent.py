"""What speaks against an explanation."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from core.diagnosis.drawn import Urn
from core.report.diagnoses import cause, diagnosis, evidence
from shoecal_core.diagnosis.dissent import REPLAYED_FROM, after_replay, lowered, worse_runs
from shoecal_core.diagnosis.result import SimulatedShrink
from shoecal_core.diagnosis.settings import DiagnosisSettings

SETTINGS = DiagnosisSettings()


def test_test_runs_that_get_worse_are_named(urn: Urn) -> None:
    workspace = urn.draw(np.random.default_rng(1), {"floor_tilt": [0.03, 0.02]})
    before = workspace.explained(None)[0]
    assert worse_runs(workspace, before, 0.5 * before, SETTINGS) == ((), ())
    after, run = 0.5 * before, workspace.test[-1]
    after[workspace.rows_of([run])] *= 4.0
    runs, words = worse_runs(workspace, before, after, SETTINGS)
    assert runs == (run,)
    assert words[0].startswith(f"test run {run} gets worse with it: CoP ")
    # What grows by less than matters to anybody is no dissent.
    nothing = 1e-3 * before
    assert worse_runs(workspace, nothing, 2.0 * nothing, SETTINGS) == ((), ())


def test_each_takes_its_share_of_the_probability() -> None:
    """But of what happened in a run that was fitted."""
    always = cause("nonlinearity", "load_cell", ("left/front_left",), 0.9)
    once = cause("slip", "contact", ("left",), 0.8, run=2)
    found = diagnosis(causes=(always, once))
    assert lowered(found, ()) == found
    less = lowered(found, found.test[:1])
    assert [one.probability for one in less.causes] == [pytest.approx(0.75), 0.8]
    assert less.verdict == "partly_explained"


@pytest.mark.parametrize(("confirmed", "verdict"), [(True, "explained"), (False, "unknown")])
def test_what_the_simulator_does_not_confirm_is_not_named(confirmed: bool, verdict: str) -> None:
    claimed = 0.6
    removed = REPLAYED_FROM * claimed + (0.01 if confirmed else -0.01)
    simulated = SimulatedShrink(removed, claimed, (2.0, 1.5), (0.4, 0.3), (0.1, 0.1))
    one = replace(diagnosis().causes[0], simulated=simulated)
    found = after_replay(diagnosis(evidence(), causes=(one,)))
    assert found.verdict == verdict
    assert bool(found.causes) == confirmed
    if not confirmed:
        assert "not named" in found.dissent[-1]
        assert found.action is not None
        assert found.action.do.startswith("look for")
        assert found.evidence is not None
        assert found.evidence.explained is None
        assert found.ranking == diagnosis().ranking


def test_what_was_not_replayed_stays_in_part() -> None:
    denied = replace(
        cause("nonlinearity", "load_cell", ("left/front_left",), 0.9),
        simulated=SimulatedShrink(0.0, 0.6, (2.0, 2.0), (0.4, 0.4), (0.1, 0.1)),
    )
    kept = cause("my_own", "load_cell", ("left",), 0.7, simulated=False)
    found = after_replay(diagnosis(causes=(denied, kept)))
    assert found.causes == (kept,)
    assert found.verdict == "partly_explained"
