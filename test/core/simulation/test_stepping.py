from __future__ import annotations

import logging
from pathlib import Path

import mujoco
import pytest

from shoecal_core.simulation.faults import SimulationDivergedError
from shoecal_core.simulation.stepping import advance

FALLING = """
<mujoco><worldbody><body><freejoint/><geom size="0.1" mass="1"/></body></worldbody></mujoco>
"""


def test_a_simulation_that_diverges_is_an_error_and_leaves_no_file(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    monkeypatch.chdir(tmp_path)
    model = mujoco.MjModel.from_xml_string(FALLING)
    data = mujoco.MjData(model)
    advance(model, data, 3)
    assert data.time == pytest.approx(3 * model.opt.timestep)
    data.qvel[2] = 1e200
    with (
        caplog.at_level(logging.WARNING),
        pytest.raises(SimulationDivergedError, match=r"diverged after 0\.01 s; lower step_s"),
    ):
        advance(model, data)
    assert "simulation is unstable" in caplog.text
    assert not list(tmp_path.iterdir())
    advance(model, data)
    assert data.time == pytest.approx(model.opt.timestep)
