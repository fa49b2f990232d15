"""An effect is put into a robot, found, written into its files, and the gap is gone.

All is measured in a run that neither the diagnosis nor a calibration has seen: first what the model
says of the recording, then what the robot of the corrected files shows when it is simulated.
"""

from __future__ import annotations

import json
import shutil
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import mujoco
import numpy as np
import pytest

from core.conftest import CONFIG
from shoecal_core import cli
from shoecal_core.error_sources.tolerances import Tolerances
from shoecal_core.estimation.series import errors, measured_series, modelled_series
from shoecal_core.estimation.session_data import load_data
from shoecal_core.recording.session import Session
from shoecal_core.robot.randomisation import load_randomisation
from shoecal_core.robot.robot_file import load_robot
from shoecal_core.samples.stance import Stance
from shoecal_core.screening.settings import CalibrationSettings
from shoecal_core.shoe.sensing import Sensing
from shoecal_core.workflows.calibrate import calibrate_session
from shoecal_core.workflows.replayed import like_the_model, replay

ANGLE = 0.03
EFFECT = f"effects: [{{effect: joint_offset, location: [LAnklePitch], angle_rad: {ANGLE}}}]\n"
TRAIN, TEST, UNUSED = (1, 2, 3, 4, 5, 6), 7, 8
MOTIONS = (
    "landmarks", "reversed", "torso_height", "unload_left", "unload_right", "faster_reversed",
    "reversed", "faster",
)  # fmt: skip
"""The last is in no other run."""
SETTINGS = CalibrationSettings()


@pytest.fixture(scope="module")
def folders(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Path, Path]:
    """The session with its files as they were, the same with corrected ones, and those alone."""
    folder = tmp_path_factory.mktemp("closed_loop")
    perfect = (CONFIG / "realities" / "perfect.yaml").read_text()
    (folder / "reality.yaml").write_text(perfect + EFFECT)
    session, out, diagnosis = (folder / name for name in ("session", "out", "diagnosis.json"))
    run(
        "simulate", CONFIG / "robots" / "nao.yaml", CONFIG / "shoes" / "nao_shoe.yaml",
        "--reality", folder / "reality.yaml", "--supports", 5, "--rate", 50, "--seed", 2,
        "--motions", ",".join(MOTIONS),
        "--out", session,
    )  # fmt: skip
    run(
        "diagnose", session, "--train", ",".join(map(str, TRAIN)), "--test", TEST,
        "--no-simulation", "--json", diagnosis,
    )  # fmt: skip
    run("correct", session, "--diagnosis", diagnosis, "--out", out)
    shutil.copytree(session, folder / "corrected")
    for name in ("robot.yaml", "robot.urdf"):
        shutil.copy(out / name, folder / "corrected" / name)
    return session, folder / "corrected", out


def run(*words: object) -> None:
    assert cli.main([str(word) for word in words]) == 0


def stances(session: Session) -> list[Stance]:
    return load_data(session, (UNUSED,), SETTINGS).of((UNUSED,))


def sensing_of(session: Session) -> Sensing:
    """By the session's own robot."""
    outcome = calibrate_session(session, TRAIN, (), SETTINGS, Tolerances())
    return outcome.calibration.sensing(session.shoe)


@pytest.fixture(scope="module")
def sessions(folders: tuple[Path, Path, Path]) -> list[tuple[Session, Sensing]]:
    opened = [Session.open(folder, force=True) for folder in folders[:2]]
    return [(session, sensing_of(session)) for session in opened]


def test_the_effect_is_in_the_files_with_its_size(folders: tuple[Path, Path, Path]) -> None:
    (zero,) = load_randomisation(folders[2] / "randomisation.yaml").parameters
    assert (zero.kind, zero.at) == ("joint_zero", "LAnklePitch")
    assert abs(zero.mean - ANGLE) < 3.0 * zero.std < ANGLE


def test_the_corrected_model_says_what_is_measured(
    sessions: list[tuple[Session, Sensing]],
) -> None:
    """A calibration by the corrected files, in a run that was not used."""
    before, after = (
        errors([(measured_series(sensing, one), modelled_series(one)) for one in stances(session)])
        for session, sensing in sessions
    )
    assert after.cop.mean < 0.3 * before.cop.mean


def test_the_corrected_robot_does_in_the_simulator_what_the_real_one_did(
    sessions: list[tuple[Session, Sensing]],
) -> None:
    recorded, sensing = sessions[1]
    before, after = (
        np.mean(list(simulated_gap(session, recorded, sensing))) for session, _ in sessions
    )
    assert after < 0.25 * before


def simulated_gap(session: Session, recorded: Session, sensing: Sensing) -> Iterator[float]:
    """Mean distance of the CoP of a session's own robot, simulated, to the recorded one [m]."""
    robot = load_robot(session.robot_yaml, session.shoe)
    drawn = like_the_model(robot, session.shoe, sensing.parameters, ())
    found = replay(recorded.read(UNUSED), robot, session.shoe, drawn, 0.0)
    for one in stances(recorded):
        readings = [np.interp(one.time, found.time, values) for values in found.readings.T]
        shown = replace(one, readings=np.stack(readings, axis=1))
        pair = measured_series(sensing, one), measured_series(sensing, shown)
        yield errors([pair]).cop.mean


def test_a_diagnosis_that_names_no_cause_is_refused(
    folders: tuple[Path, Path, Path], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    session, file = folders[0], tmp_path / "diagnosis.json"
    found = json.loads((session.parent / "diagnosis.json").read_text())
    creep = {**found["causes"][0], "effect": "creep", "location": ["left"]}
    for change, words in (
        ({"verdict": "ambiguous"}, ("verdict", "several explanations", "partly_explained")),
        ({"sessions": [found]}, ("sessions", "alone")),
        ({"robot": "wren"}, ("robot", "name its session")),
        ({"causes": [creep]}, ("causes", "creep (left)", "joint_offset")),
        ({"error": {"message": "no effect named 'x'"}}, ("failed (no effect named 'x')", "again")),
    ):
        file.write_text(json.dumps(found | change))
        words_given = ["correct", session, "--diagnosis", file, "--out", tmp_path / "out"]
        assert cli.main([str(word) for word in words_given]) == 1
        told = capsys.readouterr().err
        assert all(word in told for word in (*words, str(file))), told
    words_given[3] = session.parent / "diagnosis.json"
    assert cli.main([*map(str, words_given), "--train", "1,2"]) == 1
    assert "leave them out" in capsys.readouterr().err
    assert not (tmp_path / "out").exists()


def test_every_cause_of_the_robot_has_its_place(
    folders: tuple[Path, Path, Path], tmp_path: Path
) -> None:
    session, file, mjcf = folders[0], tmp_path / "diagnosis.json", tmp_path / "lab.xml"
    spec = mujoco.MjSpec.from_file(str(session / "robot.urdf"))
    spec.compiler.fusestatic = False
    spec.compiler.boundmass = spec.compiler.boundinertia = 1e-6  # its grippers weigh nothing
    spec.worldbody.first_body().add_freejoint()
    spec.compile()
    mjcf.write_text(spec.to_xml())
    found = json.loads((session.parent / "diagnosis.json").read_text())
    causes = [
        cause("payload", ["base_link"], mass=(0.3, "kg")),
        cause("link_com", ["LThigh_link"], x=(0.01, "m"), y=(0.0, "m"), z=(-0.002, "m")),
        cause("joint_offset", ["LHipYawPitch"], angle=(0.02, "rad")),
        cause("joint_compliance", ["all"], compliance=(0.004, "rad/(N m)")),
        cause("backlash", ["RKneePitch"], play=(0.01, "rad")),
        cause("latency", ["all"], delay=(0.03, "s")),
        cause("creep", ["left"], fraction=(0.02, "")),
    ]
    file.write_text(json.dumps(found | {"causes": causes}))
    out, figures = tmp_path / "out", tmp_path / "figures.json"
    run("correct", session, "--diagnosis", file, "--mjcf", mjcf, "--out", out, "--json", figures)
    before, after = (
        load_robot(folder / "robot.yaml", urdf=folder / "robot.urdf") for folder in (session, out)
    )
    assert after.mass - before.mass == pytest.approx(0.3, abs=1e-6)
    assert after.mass_std == pytest.approx(np.hypot(before.mass_std, 0.1 / 3.92), rel=1e-3)
    masses = [one.mass for one in before.model.inertias], [one.mass for one in after.model.inertias]
    changed = np.subtract(masses[1], masses[0])
    assert changed[1] == pytest.approx(0.3, abs=1e-6)
    assert changed[2:] == pytest.approx(0.0, abs=1e-6)

    randomised = load_randomisation(out / "randomisation.yaml")
    legs = [before.joint_names[index] for index in before.moved]
    assert list(randomised.of("compliance")) == legs
    assert {name: one.mean for name, one in randomised.of("latency").items()} == {
        "left": 0.03, "right": 0.03
    }  # fmt: skip
    (play,) = randomised.of("play").values()
    assert (play.at, play.mean) == ("RKneePitch", 0.01)
    assert play.std == pytest.approx(0.1 / 3.92)
    hips = {name: one.mean for name, one in randomised.of("joint_zero").items()}
    assert hips == pytest.approx({"LHipYawPitch": 0.02, "RHipYawPitch": 0.02})
    assert randomised.of("com_x")["LThigh_link"].mean == pytest.approx(0.01)

    model = mujoco.MjModel.from_xml_path(str(out / "robot.xml"))
    assert np.ptp(model.joint("RKneePitch_play").range) == pytest.approx(0.01, rel=1e-5)
    left = json.loads(figures.read_text())["left_out"]
    assert sum("compliance of" in line for line in left) == len(legs)  # no servo in this MJCF
    assert any("creep (left)" in line for line in left)
    assert any("latency of the left foot" in line for line in left)


def cause(effect: str, location: list[str], **sizes: tuple[float, str]) -> dict[str, object]:
    size = {
        name: {"value": value, "unit": unit, "ci95": [value - 0.05, value + 0.05]}
        for name, (value, unit) in sizes.items()
    }
    return {"effect": effect, "location": location, "run": None, "size": size}
