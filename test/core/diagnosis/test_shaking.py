"""A robot that shakes while it is recorded is told."""

from __future__ import annotations

import pytest

from core.error_sources.altered import with_forces
from shoecal_core.arrays import FloatArray
from shoecal_core.diagnosis.shaking import shaking
from shoecal_core.diagnosis.workspace import Workspace
from shoecal_core.error_sources.signal_model import SignalModel
from shoecal_core.samples.samples import Track


def struck(signal_model: SignalModel, every: int) -> SignalModel:
    """All cells jump by 5 N, once in so many samples."""

    def work(_track: Track, forces: FloatArray) -> FloatArray:
        forces = forces.copy()
        forces[::every] += 5.0
        return forces

    return with_forces(signal_model, work)


def test_a_robot_that_stands_firm_does_not_shake(workspace: Workspace) -> None:
    assert shaking(workspace.signal_model) == []
    assert shaking(struck(workspace.signal_model, 50)) == []


@pytest.mark.parametrize("every", [7, 9])
def test_how_often_it_shook_is_told(workspace: Workspace, every: int) -> None:
    (note,) = shaking(struck(workspace.signal_model, every))
    assert "the robot shook" in note
    told = float(note.split("for ")[1].split("%")[0])
    assert 100 / every - 1.0 < told < 100 / every + 5.0  # some jumps are the robot's own
