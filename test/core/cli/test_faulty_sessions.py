"""Recordings with a fault, through the commands: named, left out or refused, and counted."""

from __future__ import annotations

import json
import shutil
from collections.abc import Callable, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml

from core.cli.conftest import Run as Command
from shoecal_core.arrays import FloatArray
from shoecal_core.files import read_yaml
from shoecal_core.recording import messages, schemas
from shoecal_core.recording.run import Run
from shoecal_core.recording.session import Session

TRAIN = ("--train", "1,2,3", "--test", "4")


def rewritten(
    folder: Path, out: Path, change: Callable[[Run], Run], *, force: bool = False
) -> Path:
    """A session whose runs are changed before anything reads them."""
    old = Session.open(folder, force=force)
    new = Session.create(out, old.robot_yaml, old.robot_urdf, old.shoe.path, seed=old.seed)
    for entry in old.runs:
        run = change(old.read(entry.run))
        joints, readings = run.joints, run.readings
        with new.new_run(run.info.motion, run.info.support) as writer:
            for index, time in enumerate(joints.time):
                stamp = run.start_ns + round(1e9 * time)
                effort = np.full(len(joints.names), np.nan)
                position = joints.position[index]
                message = messages.joint_state(stamp, joints.names, position, effort)
                writer.write(schemas.JOINT_STATES, message, stamp)
            for index, time in enumerate(readings.time):
                stamp = run.start_ns + round(1e9 * time)
                message = messages.shoe_voltages(
                    stamp, index, readings.names, readings.value[index], readings.status[index]
                )
                writer.write(schemas.VOLTAGES, message, stamp)
    return out


def with_values(run: Run, values: FloatArray) -> Run:
    return replace(run, readings=replace(run.readings, value=values))


def plain(text: str) -> str:
    return " ".join(text.split())


def figures(shoecal: Command, session: Path, tmp_path: Path) -> tuple[dict[str, Any], str]:
    """Of a calibration that is made in spite of the fault, and what is printed."""
    file = tmp_path / "figures.json"
    words = ["calibrate", session, *TRAIN, "--out", tmp_path / "calibration.yaml", "--json", file]
    code, out, error = shoecal(*words)
    assert code == 0, error
    found: dict[str, Any] = json.loads(file.read_text())
    return found, plain(out)


def spikes(found: Mapping[str, Any]) -> dict[tuple[object, ...], int]:
    """Samples left out as spikes, by run and channels."""
    return {
        (one["run"], *one["channels"]): one["samples"]
        for one in found["screening"]["left_out"]
        if one["fault"] == "spike"
    }


def test_swapped_cells_are_refused_by_name(
    shoecal: Command, simulated: Path, tmp_path: Path
) -> None:
    names = Session.open(simulated).shoe.names
    order = np.arange(len(names))
    order[[0, 4]] = 4, 0
    session = rewritten(
        simulated, tmp_path / "s", lambda run: with_values(run, run.readings.value[:, order])
    )
    told = f"{names[0]} and {names[4]} are swapped"
    code, out, _ = shoecal("check", session)
    assert code == 1
    assert told in plain(out)
    calibration = tmp_path / "calibration.yaml"
    code, _, error = shoecal("calibrate", session, *TRAIN, "--out", calibration)
    assert code == 1
    assert told in plain(error)
    assert error.count("\n") == 1
    assert not calibration.exists()
    # A diagnosis goes on, as it may be the cause, and says so.
    code, out, error = shoecal("diagnose", session, *TRAIN, "--no-simulation")
    assert code == 0, error
    assert f"check: {told}" in plain(out)


def test_spikes_are_left_out_named_and_counted(
    shoecal: Command, simulated: Path, calibrated: Path, tmp_path: Path
) -> None:
    at = np.arange(200, 1400, 60)

    def jumping(run: Run) -> Run:
        values = run.readings.value.copy()
        if run.info.run == 2:
            values[at, 5] += 2.0
        return with_values(run, values)

    # What hits a foot of three cells may jump in one alone, as where it touches down.
    usual = spikes(json.loads(calibrated.with_suffix(".json").read_text()))
    found, out = figures(shoecal, rewritten(simulated, tmp_path / "s", jumping), tmp_path)
    name = Session.open(simulated).shoe.names[5]
    lost = spikes(found)
    assert lost[2, name] >= len(at) - 2
    assert sum(lost.values()) - lost[2, name] - sum(usual.values()) <= 2
    assert f"{name} gave spikes in run 2" in out
    assert "Samples left out" in out


def test_a_run_under_another_weight_is_in_no_set(
    shoecal: Command, simulated: Path, tmp_path: Path
) -> None:
    drawn = read_yaml(simulated / "truth" / "reality.yaml").mapping("gain")
    names = Session.open(simulated).shoe.names
    share = 5.0 / len(names) / np.array([drawn.number(name) for name in names])

    def held(run: Run) -> Run:
        return with_values(run, run.readings.value - (share if run.info.run == 4 else 0.0))

    found, out = figures(shoecal, rewritten(simulated, tmp_path / "s", held), tmp_path)
    assert (found["train"], found["test"]) == ([1, 2, 3], [])
    assert found["screening"]["runs_left_out"] == [4]
    assert "run 4 was recorded with 5.0 N less on the feet than the others" in out


@pytest.mark.parametrize("late_s", [0.08, -0.06])
def test_readings_of_another_clock_are_put_right(
    shoecal: Command, simulated: Path, tmp_path: Path, late_s: float
) -> None:
    """What is stamped late makes the joints early."""

    def late(run: Run) -> Run:
        time = run.readings.time + (late_s - min(late_s, 0.0))
        joints = replace(run.joints, time=run.joints.time - min(late_s, 0.0))
        return replace(run, joints=joints, readings=replace(run.readings, time=time))

    found, out = figures(shoecal, rewritten(simulated, tmp_path / "s", late), tmp_path)
    assert found["time_offset_s"] == pytest.approx(-late_s, abs=0.02)
    if late_s > 0.0:
        assert "joints are early by" in out


@pytest.mark.parametrize("fast", [0.012, -0.012, 0.003, -0.003])
def test_a_clock_that_runs_fast_is_named(
    shoecal: Command, simulated: Path, tmp_path: Path, fast: float
) -> None:
    """Nothing sets it between the runs, as no board's is."""
    first = min(Session.open(simulated).read(number).start_ns for number in (1, 2, 3, 4))

    def stretched(run: Run) -> Run:
        since = (run.start_ns - first) / 1e9
        joints = replace(run.joints, time=run.joints.time + max(0.0, -fast) * since)
        time = run.readings.time * (1.0 + fast) + max(0.0, fast) * since
        return replace(run, joints=joints, readings=replace(run.readings, time=time))

    session = rewritten(simulated, tmp_path / "s", stretched)
    out = tmp_path / "calibration.yaml"
    for words in (("check", session), ("calibrate", session, *TRAIN, "--out", out)):
        code, printed, error = shoecal(*words)
        told = plain(printed + error)
        assert code == 1
        found, way = told.split("the shoe's clock runs ")[1].split(" against")[0].split("% ")
        assert float(found) == pytest.approx(100.0 * abs(fast), abs=0.2)
        assert way == ("fast" if fast > 0.0 else "slow")
        assert "which is corrected in the fit" not in told
    assert not out.exists()


def test_a_changed_shoe_file_is_refused_unless_forced(
    shoecal: Command, simulated: Path, tmp_path: Path
) -> None:
    folder = tmp_path / "session"
    shutil.copytree(simulated, folder)
    with (folder / "shoe.yaml").open("a") as file:
        file.write("# mended\n")
    out = tmp_path / "calibration.yaml"
    for words in (
        ("check", folder),
        ("calibrate", folder, *TRAIN, "--out", out),
        ("diagnose", folder, "--no-simulation"),
    ):
        code, printed, error = shoecal(*words)
        assert code == 1
        assert "recorded with another shoe.yaml" in plain(printed + error)
        assert "--force" in printed + error
    assert not out.exists()
    assert shoecal("check", folder, "--force")[0] == 0
    code, printed, error = shoecal("calibrate", folder, *TRAIN, "--out", out, "--force")
    assert code == 0, error
    assert "WARN: shoe.yaml was changed since the runs were recorded" in plain(printed)
    code, _, error = shoecal("evaluate", folder, "--calibration", out, "--force")
    assert code == 0, error


def test_data_sheets_that_contradict_the_data(
    shoecal: Command, simulated: Path, calibrated: Path, tmp_path: Path
) -> None:
    """Readings in kgf under gains in N: nothing is written, and the unit is named."""
    gains = {one["name"]: one["gain"] for one in yaml.safe_load(calibrated.read_text())["channels"]}
    for factor, passes in ((1.0, True), (9.80665, False)):
        session = tmp_path / f"session_{passes}"
        shutil.copytree(simulated, session)
        shoe = yaml.safe_load((session / "shoe.yaml").read_text())
        for foot, of_foot in shoe["feet"].items():
            for cell in of_foot["cells"]:
                cell["nominal_gain"] = gains[f"{foot}/{cell['name']}"] / factor
        (session / "shoe.yaml").write_text(yaml.safe_dump(shoe))
        out = tmp_path / f"calibration_{passes}.yaml"
        code, told, error = shoecal("calibrate", session, "--force", "--out", out)
        assert out.exists() == passes == (code == 0)
        assert ("are the readings in kgf or kg?" in told + error) != passes


def test_a_converter_at_its_ceiling_is_one_line(
    shoecal: Command, simulated: Path, tmp_path: Path
) -> None:
    """The shoe file's range is wider than the converter's, as where it was not known."""
    source = tmp_path / "source"
    shutil.copytree(simulated, source)
    shoe = source / "shoe.yaml"
    shoe.write_text(
        shoe.read_text().replace("lowest: -5.0, highest: 5.0", "lowest: -2e9, highest: 2e9")
    )
    channels = [0, 2, 5]

    def at_ceiling(run: Run) -> Run:
        values = run.readings.value.copy()
        for offset, channel in enumerate(channels):
            values[100 + offset :: 97, channel] = 16777215.0
        return with_values(run, values)

    session = rewritten(source, tmp_path / "session", at_ceiling, force=True)
    code, out, error = shoecal("check", session)
    assert code == 0, error
    lines = [line for line in plain(out).split("WARN: ") if "at the end of" in line]
    assert len(lines) == 1
    assert lines[0].startswith("left/toe, left/heel_right, right/c are at the end of their range")
    assert "messages, at 16777215 V), where the converter goes no further: lower" in lines[0]
    assert "spikes" not in out


@pytest.mark.parametrize(("sign", "zero"), [(-1.0, 0.0), (1.0, 0.4)])
def test_a_joint_that_is_off_in_all_runs_is_one_sentence(
    shoecal: Command, simulated: Path, tmp_path: Path, sign: float, zero: float
) -> None:
    names = Session.open(simulated).read(1).joints.names
    knee = next(index for index, name in enumerate(names) if "knee" in name.lower())

    def turned(run: Run) -> Run:
        position = run.joints.position.copy()
        position[:, knee] = sign * position[:, knee] + zero
        return replace(run, joints=replace(run.joints, position=position))

    session = rewritten(simulated, tmp_path / "s", turned)
    for words in (("check", session), ("calibrate", session, *TRAIN, "--out", tmp_path / "c.yaml")):
        code, out, error = shoecal(*words)
        told = plain(out + error)
        assert code == 1
        assert "runs 1, 2, 3 and 4: " in told, told
        assert told.count("a joint's ") == 1


def test_readings_that_come_too_seldom(shoecal: Command, simulated: Path, tmp_path: Path) -> None:
    """Every command says how often they come, and what to set."""

    def seldom(run: Run) -> Run:
        readings = run.readings
        kept = slice(None, None, round(readings.rate_hz))
        return replace(
            run,
            readings=replace(
                readings,
                time=readings.time[kept],
                value=readings.value[kept],
                status=readings.status[kept],
                sequence=readings.sequence[kept],
                temperature=readings.temperature[kept],
            ),
        )

    session = rewritten(simulated, tmp_path / "s", seldom)
    told = "readings come 1.0 times a second: set the board to 10 times or more"
    out = tmp_path / "calibration.yaml"
    for words in (("check",), ("calibrate", "--out", out), ("diagnose", "--no-simulation")):
        code, printed, error = shoecal(words[0], session, *words[1:])
        assert code == 1
        assert told in plain(printed + error)
        assert "Traceback" not in error
    assert not out.exists()
