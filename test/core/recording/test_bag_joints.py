"""What is wrong with a bag's joint angles is said by joint, from the draft on."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from rosbags.typesys import get_types_from_msg

from core.recording import bags
from core.shoe.shoes import ROOT
from shoecal_core.arrays import FloatArray
from shoecal_core.error_sources.tolerances import Tolerances
from shoecal_core.files import read_yaml, write_yaml
from shoecal_core.recording import schemas
from shoecal_core.recording.imports.bag_draft import BagDraft, draft_mapping, mapping_text
from shoecal_core.recording.imports.bag_import import import_bags
from shoecal_core.recording.session import Session
from shoecal_core.robot.kinematics import Kinematics
from shoecal_core.robot.robot_file import load_robot
from shoecal_core.screening.settings import CalibrationSettings
from shoecal_core.shoe.shoe_file import load_shoe
from shoecal_core.workflows.check import check_session

ROBOT, SHOE = ROOT / "config/robots/nao.yaml", ROOT / "config/shoes/nao_shoe.yaml"
RATE, SECONDS, FULL_V = 50.0, 12.0, 0.4
COUNT = int(RATE * SECONDS)
Change = Callable[[FloatArray, "Nao"], None]


class Nao:
    """A robot that sways over both feet, and the bag that it records."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.shoe = load_shoe(SHOE)
        self.robot = load_robot(ROBOT, self.shoe)
        self.time = np.arange(COUNT) / RATE
        self.share = 0.5 + 0.4 * np.sin(1.3 * self.time)
        lean = 0.08 * np.sin(1.3 * self.time)
        bend = 0.1 * np.sin(0.9 * self.time)
        self.angles = np.tile(self.robot.posture, (COUNT, 1))
        for side in "LR":
            for joint, change in (
                ("HipPitch", -bend), ("KneePitch", 2.0 * bend), ("AnklePitch", -bend),
                ("HipRoll", lean), ("AnkleRoll", -lean),
            ):  # fmt: skip
                self.angles[:, self.joint(f"{side}{joint}")] += change

    def joint(self, name: str) -> int:
        return self.robot.joint(name)

    def support(self) -> list[float]:
        """Where the right foot stands."""
        found = Kinematics(self.robot).states(self.angles[:1]).support()
        return [found.dx, found.dy, found.dtheta]

    def lift_right(self, share: float) -> None:
        """The right foot in the air from the third second on, for a share of the time."""
        up = np.clip((self.time - 2.0) / 0.2, 0.0, 1.0)
        up *= np.clip((2.0 + share * SECONDS - self.time) / 0.2, 0.0, 1.0)
        for joint, size in (("RHipRoll", -0.25), ("RHipPitch", -0.5), ("RKneePitch", 0.6)):
            self.angles[:, self.joint(joint)] += size * up
        self.share = self.share * (1.0 - up) + up

    def readings(self) -> FloatArray:
        """(T, n) [V], each foot's share on all its cells, with noise."""
        loads = np.stack((self.share, 1.0 - self.share), axis=1)
        foot = np.array([channel.foot for channel in self.shoe.channels])
        noise = 2e-4 * np.random.default_rng(3).standard_normal((COUNT, len(foot)))
        clean: FloatArray = 0.3 + FULL_V * loads[:, foot] * self.shoe.polarity
        return clean + noise

    def bag(self, name: str = "stands") -> Path:
        bag = bags.BagWriter(self.folder, name, "mcap")
        kind = schemas.SHOE_VOLTAGES_TYPE
        bag.store.register(get_types_from_msg(schemas.SHOE_VOLTAGES_DEFINITION, kind))
        names, cells = list(self.robot.joint_names), list(self.shoe.names)
        status = np.zeros(len(cells), dtype=np.uint8)
        for step, (time, angles, row) in enumerate(
            zip(self.time.tolist(), self.angles, self.readings(), strict=True)
        ):
            bag.joints(time, names, angles)
            volts = bag.make(
                kind, header=bag.header(time), sequence=step, cell=cells, voltage=row,
                status=status, temperature=21.0,
            )  # fmt: skip
            bag.add(time, "/shoe/voltages", volts)
        return bag.close()

    def draft(self) -> BagDraft:
        draft = draft_mapping([self.bag()], self.robot, self.shoe)
        text = mapping_text(draft, self.folder, ROBOT, self.robot.urdf, SHOE)
        (self.folder / "mapping.yaml").write_text(text)
        return draft

    def imported(self, **trial: object) -> Session:
        """As drafted, or with a trial of one's own."""
        mapping = self.folder / "mapping.yaml"
        if trial:
            fields = read_yaml(mapping)
            values = {key: fields.value(key) for key in fields.keys()}
            write_yaml(mapping, values | {"trials": [{"bag": "stands", **trial}]})
        count = len(list(self.folder.glob("session*")))
        return import_bags(mapping, self.folder, self.folder / f"session_{count}")


@pytest.fixture
def nao(tmp_path: Path) -> Nao:
    return Nao(tmp_path)


def notes(session: Session) -> tuple[str, ...]:
    return session.runs[0].info.notes


def test_a_good_bag_says_nothing(nao: Nao) -> None:
    support, draft = nao.support(), nao.draft()
    assert draft.notes == ()
    found = draft.trials[0].support
    assert found is not None
    np.testing.assert_allclose((found.dx, found.dy, found.dtheta), support, atol=1e-3)
    assert notes(nao.imported()) == ()


@pytest.mark.parametrize(
    ("joint", "size"), [("LKneePitch", 0.5), ("RHipPitch", -0.3), ("RAnkleRoll", 0.8)]
)
def test_a_zero_that_is_off_is_named_by_every_command(nao: Nao, joint: str, size: float) -> None:
    """From the draft on; imported as drafted, and with the support of a tape measure."""
    support = nao.support()
    nao.angles[:, nao.joint(joint)] += size
    (note,) = nao.draft().notes
    # Where legs bend alike, the other one's joint explains the soles as well.
    named = note.removeprefix("stands: with ").split(" as recorded the soles are ")[0].split(" or ")
    assert joint in named
    assert {name[1:] for name in named} == {joint[1:]}
    assert "against each other while both carry load: a joint's zero is off (best fit: " in note
    assert f"{joint} by {-size:+.2f} rad" in note
    for session in (nao.imported(), nao.imported(motion="standing", support=support)):
        assert f"stands: {notes(session)[-1]}" == note
        problems = check_session(session, CalibrationSettings(), Tolerances()).problems
        assert [one for one in problems if "as recorded the soles" in one]
        assert not [one for one in problems if "in the air" in one or "/base_pose" in one]


def test_feet_that_hang_have_no_zero_that_is_off(nao: Nao) -> None:
    nao.lift_right(1.0)
    nao.draft()
    assert notes(nao.imported(motion="hanging")) == ()


def test_joints_without_numbers_are_named(nao: Nao) -> None:
    for joint in ("HeadYaw", "HeadPitch"):
        nao.angles[::3, nao.joint(joint)] = np.nan
    draft = nao.draft()
    expected = (
        f"joints 'HeadYaw', 'HeadPitch' have no angle (NaN) in {COUNT // 3} of {COUNT} messages"
    )
    assert draft.notes == (f"stands: {expected}",)
    assert draft.trials[0].support is not None
    session = nao.imported()
    assert notes(session) == (expected,)
    assert session.read(1).notes.count(expected) == 1


def test_bursts_of_zeros_are_named_and_left_out(nao: Nao) -> None:
    knee, own = nao.joint("LKneePitch"), nao.angles.copy()
    nao.angles[100:104, knee] = nao.angles[250, knee] = 0.0
    draft = nao.draft()
    expected = (
        f"joint 'LKneePitch' jumps to zero in 5 of {COUNT} messages, first 2.0 s after the first "
        "message, which are left out: check encoders and bus"
    )
    assert draft.notes == (f"stands: {expected}",)
    assert draft.trials[0].support is not None
    session = nao.imported()
    assert notes(session) == (expected,)
    run = session.read(1)
    assert run.notes.count(expected) == 1
    read = run.joints.position[:, run.joints.names.index("LKneePitch")]
    assert np.isnan(read[100:104]).all()
    np.testing.assert_allclose(read[104:250], own[104:250, knee])


def test_a_message_of_zeros_fails_as_a_whole(nao: Nao) -> None:
    """Rolls that are near zero anyhow, too; a joint that is always zero is well."""
    nao.angles[:, nao.joint("HeadYaw")] = 0.0
    nao.angles[200:206] = 0.0
    draft = nao.draft()
    (note,) = draft.notes
    assert f"more jump to zero in 6 of {COUNT} messages, first 4.0 s" in note
    assert "HeadYaw" not in note
    assert draft.trials[0].support is not None


def test_a_support_is_compared_where_both_feet_carry_load(nao: Nao) -> None:
    """A foot is in the air for 80 % of the time: what is left agrees with the tape measure."""
    support = nao.support()
    nao.lift_right(0.8)
    draft = nao.draft()
    found = draft.trials[0].support
    assert draft.notes == ()
    assert found is not None
    np.testing.assert_allclose((found.dx, found.dy, found.dtheta), support, atol=1e-3)
    session = nao.imported(motion="standing", support=support)
    assert notes(session) == ()
    wrong = nao.imported(motion="standing", support=[support[0] + 0.1, *support[1:]])
    (note,) = notes(wrong)
    assert note.startswith(f"support: dx is {support[0] + 0.1:.4g} m, but ")
    assert abs(float(note.split("but ")[1].split(" m")[0]) - support[0]) < 1e-3
