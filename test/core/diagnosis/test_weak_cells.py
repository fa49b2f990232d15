"""Cells that hardly answer are told by their gains, where cells are of one kind."""

from __future__ import annotations

from copy import copy
from dataclasses import replace

import numpy as np
import pytest

from shoecal_core.diagnosis.answer import answer
from shoecal_core.diagnosis.baseline import first_parameters
from shoecal_core.diagnosis.selection import Selection
from shoecal_core.diagnosis.settings import DiagnosisSettings
from shoecal_core.diagnosis.weak_cells import weak_cells
from shoecal_core.diagnosis.workspace import Workspace, make_workspace
from shoecal_core.error_sources.base import Place
from shoecal_core.error_sources.signal_model import make_signal_model
from shoecal_core.error_sources.tolerances import Tolerances

SETTINGS = DiagnosisSettings()
NOTHING = Selection(None, (), (), -3.0)


def everywhere(_effect: str, _place: Place) -> bool:
    """Look for everything."""
    return True


def answering(workspace: Workspace, channel: int, share: float) -> Workspace:
    """The session as it would be had a cell shown but a share of what it feels."""
    samples = workspace.signal_model.samples
    factor = np.ones(len(samples.shoe.channels))
    factor[channel] = share
    tracks = tuple(replace(one, readings=one.readings * factor) for one in samples.tracks)
    weak = replace(samples, tracks=tracks, readings=samples.readings * factor)
    signal_model = make_signal_model(weak, first_parameters(weak, workspace.train), SETTINGS)
    return make_workspace(signal_model, (), workspace.train, workspace.test, SETTINGS, Tolerances())


@pytest.mark.parametrize(("channel", "share"), [(1, 0.1), (6, 0.25)])
def test_a_cell_that_hardly_answers_is_a_stuck_one(
    workspace: Workspace, channel: int, share: float
) -> None:
    (cause,) = weak_cells(answering(workspace, channel, share), everywhere)
    assert (cause.effect, cause.group) == ("stuck_cell", "load_cell")
    assert cause.location == (workspace.signal_model.samples.shoe.names[channel],)
    size = cause.size["share"]
    assert size.ci95[0] <= 1.0 - share <= size.ci95[1]
    assert cause.hidden_cop_mm > 1.0


def test_it_is_a_cause_though_no_signal_shows_a_gap(workspace: Workspace) -> None:
    weak = answering(workspace, 1, 0.1)
    certain = weak_cells(weak, everywhere)
    said = answer(weak, certain, NOTHING, SETTINGS)
    assert said.verdict == "explained"
    assert list(said.causes) == certain
    assert [(one.effect, one.probability) for one in said.ambiguity] == [("stuck_cell", 1.0)]
    assert answer(weak, (), NOTHING, SETTINGS).verdict == "no_gap"


def test_a_gain_that_nothing_fixes_accuses_no_cell(workspace: Workspace) -> None:
    weak = answering(workspace, 1, 0.1)
    scorer = copy(weak.scorer)
    scorer.nothing = replace(weak.scorer.nothing)
    scorer.nothing.__dict__["covariance"] = weak.scorer.nothing.covariance * 1e8
    assert weak_cells(replace(weak, scorer=scorer), everywhere) == []


def test_only_where_it_is_asked_for(workspace: Workspace) -> None:
    weak = answering(workspace, 1, 0.1)
    assert weak_cells(weak, lambda effect, _: effect != "stuck_cell") == []


def test_cells_that_differ_as_cells_do_are_none(workspace: Workspace) -> None:
    assert weak_cells(workspace, everywhere) == []
    assert weak_cells(answering(workspace, 3, 0.6), everywhere) == []


def test_cells_of_known_gain_need_not_be_alike(workspace: Workspace) -> None:
    weak = answering(workspace, 1, 0.1)
    samples = weak.signal_model.samples
    channels = tuple(replace(one, nominal_gain=1.0) for one in samples.shoe.channels)
    shoe = replace(samples.shoe, channels=channels)
    signal_model = replace(weak.signal_model, samples=replace(samples, shoe=shoe))
    assert weak_cells(replace(weak, signal_model=signal_model), everywhere) == []
