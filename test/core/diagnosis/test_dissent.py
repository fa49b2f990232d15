"""What speaks against an explanation."""

from __future__ import annotations

import numpy as np
import pytest

from core.diagnosis.drawn import Urn
from core.report.diagnoses import cause, diagnosis
from shoecal_core.diagnosis.dissent import less_probable, worse_runs
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
    assert less_probable(found, ()) == found
    less = less_probable(found, found.test[:1])
    assert [one.probability for one in less.causes] == [pytest.approx(0.75), 0.8]
    assert less.verdict == "partly_explained"
