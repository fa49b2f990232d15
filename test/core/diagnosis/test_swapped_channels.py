"""Cables that were swapped are found, and none where none are."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from core.diagnosis.rewritten import rewritten
from shoecal_core.diagnosis.baseline import first_parameters
from shoecal_core.diagnosis.diagnose import Wanted, diagnose
from shoecal_core.diagnosis.settings import DiagnosisSettings
from shoecal_core.diagnosis.swapped_channels import swapped_channels
from shoecal_core.diagnosis.workspace import Workspace, make_workspace
from shoecal_core.error_sources.effects.geometry import SwappedCells
from shoecal_core.error_sources.signal_model import make_signal_model
from shoecal_core.error_sources.tolerances import Tolerances
from shoecal_core.recording.run import Run
from shoecal_core.recording.session import Session

SETTINGS, EFFECTS = DiagnosisSettings(), (SwappedCells(),)


def swapped(workspace: Workspace, one: int, other: int) -> Workspace:
    """The session as it would be had two cables been swapped."""
    samples = workspace.signal_model.samples
    order = np.arange(len(samples.shoe.channels))
    order[[one, other]] = other, one
    tracks = tuple(replace(one, readings=one.readings[:, order]) for one in samples.tracks)
    crossed = replace(samples, tracks=tracks, readings=samples.readings[:, order])
    first = first_parameters(crossed, workspace.train)
    signal_model = make_signal_model(crossed, first, SETTINGS)
    return make_workspace(
        signal_model, EFFECTS, workspace.train, workspace.test, SETTINGS, Tolerances()
    )


@pytest.mark.parametrize(("one", "other"), [(0, 3), (2, 5)])
def test_swapped_cables_are_found(workspace: Workspace, one: int, other: int) -> None:
    names = workspace.signal_model.samples.shoe.names
    crossed = swapped(workspace, one, other)
    found = swapped_channels(crossed, EFFECTS, SETTINGS)
    assert found is not None
    assert set(found.hypothesis.place) == {names[one], names[other]}
    before, after = (
        float(np.sqrt(np.mean(each.explained(None)[0][:, 1:3] ** 2)))
        for each in (crossed, found.workspace)
    )
    assert after < 0.5 * before


def test_cables_that_are_right_stay(workspace: Workspace) -> None:
    usual = make_workspace(
        workspace.signal_model, EFFECTS, workspace.train, workspace.test, SETTINGS, Tolerances()
    )
    assert len(usual.catalogue.swapped) == 28
    assert swapped_channels(usual, EFFECTS, SETTINGS) is None
    assert (
        swapped_channels(
            replace(usual, catalogue=replace(usual.catalogue, swapped=())), EFFECTS, SETTINGS
        )
        is None
    )


def test_a_swap_that_test_runs_deny_is_none(workspace: Workspace) -> None:
    """In the training runs alone something else looks like it."""
    crossed = swapped(workspace, 0, 3)
    samples = crossed.signal_model.samples
    order = np.arange(len(samples.shoe.channels))
    order[[0, 3]] = 3, 0
    here = crossed.rows_of(crossed.test)[:, None]
    readings = np.where(here, samples.readings[:, order], samples.readings)
    signal_model = replace(crossed.signal_model, samples=replace(samples, readings=readings))
    denied = replace(crossed, signal_model=signal_model)
    assert swapped_channels(crossed, EFFECTS, SETTINGS) is not None
    assert swapped_channels(denied, EFFECTS, SETTINGS) is None
    assert swapped_channels(replace(denied, test=()), EFFECTS, SETTINGS) is not None


def test_who_asks_for_them_alone_is_told_of_them_alone(
    standard_session: Session, tmp_path: Path
) -> None:
    def crossed(run: Run) -> Run:
        value = run.readings.value.copy()
        value[:, [0, 3]] = value[:, [3, 0]]
        return replace(run, readings=replace(run.readings, value=value))

    session = rewritten(standard_session, tmp_path / "crossed", (1, 2, 3), crossed)
    found = diagnose(session, (1, 2), (3,), only=Wanted("swapped_cells"))
    (cause,) = found.causes
    names = session.shoe.names
    assert set(cause.location) == {names[0], names[3]}
    assert found.shrink is not None
    assert found.shrink.fraction > 0.9
