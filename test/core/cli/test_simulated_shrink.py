"""A found effect in the simulator: the recorded motion is replayed with it."""

from __future__ import annotations

import shutil
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from shoecal_core.diagnosis.result import Cause, Diagnosis, Gap, Shrink, Size
from shoecal_core.error_sources.base import one_of
from shoecal_core.errors import FileError
from shoecal_core.estimation.session_data import load_data
from shoecal_core.files import Fields
from shoecal_core.recording.session import Session
from shoecal_core.robot.robot_file import load_robot
from shoecal_core.screening.settings import CalibrationSettings
from shoecal_core.shoe.wrench import ChannelParameters
from shoecal_core.simulation.effects.registry import EFFECTS, read_effect
from shoecal_core.workflows.replayed import like_the_model, replay
from shoecal_core.workflows.simulated_shrink import items_of, with_simulated_shrink

NOTHING = Shrink(0.0, (0.0, 0.0), (0.0, 0.0), (0.0, 0.0))


def cause(effect: str, location: tuple[str, ...], **sizes: tuple[float, str]) -> Cause:
    size = {name: Size(value, unit, (value, value)) for name, (value, unit) in sizes.items()}
    return Cause(effect, "timing", location, 1.0, size, None, NOTHING, 0.0)


def diagnosis(*causes: Cause) -> Diagnosis:
    return Diagnosis(
        "explained", Gap(0.0, 0.0, 0.0, 0.0), (), causes, (), (), (), (), None, (1, 2), (3,), (),
        "odd_biped", "odd_shoe",
    )  # fmt: skip


@pytest.mark.parametrize(
    "one",
    [
        cause("latency", ("left",), delay=(0.02, "s")),
        cause("nonlinearity", ("left/a",), quadratic=(1e-4, "1/N"), cubic=(0.0, "1/N^2")),
        cause("joint_compliance", ("all",), compliance=(0.004, "rad/(N m)")),
        cause("floor_tilt", (), about_x=(0.01, "rad"), about_y=(0.0, "rad")),
        cause("zero_drift", ("left",), rate=(0.01, "N/s")),
        cause("cell_position", ("left/a",), x=(0.002, "m"), y=(0.0, "m")),
        cause("off_axis_load", ("left",), x=(0.1, ""), y=(0.0, "")),
    ],
    ids=lambda one: one.effect,
)
def test_causes_are_items_of_a_reality_file(one: Cause) -> None:
    (item,) = items_of(one)
    assert item["effect"] in EFFECTS
    read_effect(Fields(Path("diagnosis"), "", item))


def test_channels_with_sizes_of_their_own_are_items_of_their_own() -> None:
    size = {one_of("rate", "left/a"): (0.01, "N/s"), one_of("rate", "left/b"): (-0.02, "N/s")}
    items = items_of(cause("zero_drift", ("left",), **size))
    assert [(item["location"], item["rate_n_per_s"]) for item in items] == [
        (["left/a"], 0.01), (["left/b"], -0.02)
    ]  # fmt: skip
    for item in items:
        read_effect(Fields(Path("diagnosis"), "", item))


def test_the_same_commands_give_about_the_same_readings(simulated: Path) -> None:
    session = Session.open(simulated)
    robot = load_robot(session.robot_yaml, session.shoe)
    run = session.read(3)
    count = len(session.shoe.names)
    law = ChannelParameters(np.full(count, 2.0), np.linspace(-1.0, 1.0, count))
    drawn = like_the_model(robot, session.shoe, law, ())
    found = replay(run, robot, session.shoe, drawn, 10.0)
    assert found.time[-1] == pytest.approx(run.readings.time[-1], abs=0.05)
    moved = np.ptp(law.outputs(found.readings), axis=0)
    assert (moved > 0.5).any()
    with pytest.raises(FileError, match="no motion can be replayed"):
        replay(replace(run, commanded=()), robot, session.shoe, drawn, 0.0)


def shrunk(told: Diagnosis, session: Path) -> Diagnosis:
    settings = CalibrationSettings()
    data = load_data(Session.open(session), settings=settings, all_readable=False)
    return with_simulated_shrink(told, data, settings)


def test_of_all_causes_together(simulated: Path, tmp_path: Path) -> None:
    """A damaged run that was left out stops nothing."""
    damaged = tmp_path / "session"
    shutil.copytree(simulated, damaged)
    run = damaged / "run_001.mcap"
    run.write_bytes(run.read_bytes()[:1000])
    late = cause("latency", ("all",), delay=(0.0, "s"))
    own = cause("my_own_effect", ("left",), strength=(1.0, "V"))
    told = replace(diagnosis(late, own), train=(2,))
    found = shrunk(told, damaged)
    first, second = found.causes
    # Without size it changes nothing.
    assert first.simulated is not None, found.notes
    assert first.simulated.fraction == pytest.approx(0.0, abs=0.02)
    assert first.simulated.cop_mae_mm[0] > 0.0
    assert second.simulated is None
    assert any("my_own_effect" in note for note in found.notes)


def test_what_cannot_be_simulated_is_a_note(simulated: Path) -> None:
    heavy = cause("payload", ("nobody",), mass=(0.1, "kg"))
    found = shrunk(diagnosis(heavy), simulated)
    assert found.causes[0].simulated is None
    assert any(note.startswith("nothing was simulated") for note in found.notes)


def test_without_a_test_run_there_is_nothing_to_compare_with(simulated: Path) -> None:
    found = replace(diagnosis(cause("latency", ("left",), delay=(0.02, "s"))), test=())
    found = shrunk(found, simulated)
    assert found.causes[0].simulated is None
    assert any("no test run" in note for note in found.notes)
