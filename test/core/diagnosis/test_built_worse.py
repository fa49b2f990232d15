"""A robot built worse than its tolerances say is reported as that, and hides no unknown cause."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from core.diagnosis.drawn import Urn, coloured
from shoecal_core.diagnosis.answer import first_confirmed
from shoecal_core.diagnosis.built_worse import answer_as_built, times_usual
from shoecal_core.diagnosis.settings import DiagnosisSettings
from shoecal_core.diagnosis.spread import BODILESS
from shoecal_core.diagnosis.workspace import Workspace
from shoecal_core.error_sources.signals import GRF

SETTINGS = DiagnosisSettings()


def drawn(urn: Urn, seed: int, form: float, grf_n: float = 0.0) -> Workspace:
    """Tolerance errors that add `form` times as much as usual in another form to the signals of
    the body, and a smooth error of the GRF [N] that nothing in the library has.
    """
    rng = np.random.default_rng(seed)
    usual = urn.draw(rng)
    rows = usual.scorer.rows
    body = ~np.isin(rows.signal, list(BODILESS))
    variance = np.where(body, form**2 * rows.form, 0.0)
    grf = rows.signal == GRF.start
    variance[grf] += grf_n**2 * rows.smooth[grf] / rows.smooth[grf].max()
    more = replace(usual, noise=rows.by_band(variance, np.zeros_like(usual.noise)))
    return urn.showing(usual.signal_model.residuals + coloured(more, rng))


@pytest.mark.parametrize("seed", [0, 1])
def test_a_robot_built_worse_has_no_gap(urn: Urn, seed: int) -> None:
    workspace = drawn(urn, seed, form=4.0)
    assert 2.0 <= times_usual(workspace.built_worse().built) <= 3.0
    found, _ = first_confirmed(workspace, SETTINGS)
    _, said, notes = answer_as_built(workspace, (), found, SETTINGS)
    assert said.verdict == "no_gap"
    assert "built worse" in notes[0]


def test_of_a_robot_within_tolerance_nothing_is_said(urn: Urn) -> None:
    workspace = drawn(urn, 2, form=0.0)
    found, _ = first_confirmed(workspace, SETTINGS)
    _, said, notes = answer_as_built(workspace, (), found, SETTINGS)
    assert said.verdict == "no_gap"
    assert notes == ()


def test_what_moves_the_weight_is_not_how_gears_are_built(urn: Urn) -> None:
    workspace = drawn(urn, 3, form=3.0, grf_n=20.0)
    found, _ = first_confirmed(workspace, SETTINGS)
    _, said, notes = answer_as_built(workspace, (), found, SETTINGS)
    assert said.verdict != "no_gap"
    assert notes == ()
