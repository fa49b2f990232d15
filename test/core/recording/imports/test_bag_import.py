from __future__ import annotations

import tracemalloc
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest
from mcap.writer import CompressionType, Writer
from rosbags.rosbag2 import CompressionMode
from rosbags.typesys import get_types_from_msg

from core.recording import bags, samples
from core.recording.two_feet import ASTRIDE, leg_pairs
from core.recording.two_feet import standing as standing_angles
from shoecal_core.arrays import FloatArray
from shoecal_core.errors import FileError, FileMissingError, FileTooLargeError
from shoecal_core.files import read_yaml, write_yaml
from shoecal_core.recording import schemas
from shoecal_core.recording.errors import reason_of
from shoecal_core.recording.imports import foreign
from shoecal_core.recording.imports.bag_draft import draft_mapping, mapping_text
from shoecal_core.recording.imports.bag_import import import_bags
from shoecal_core.recording.session import Session
from shoecal_core.robot.kinematics import Kinematics
from shoecal_core.robot.robot_file import load_robot
from shoecal_core.shoe.shoe_file import load_shoe

PREFIX = "wren/"


@dataclass(frozen=True)
class Lab:
    """A robot, its shoe file, and a bag of it."""

    folder: Path
    robot: Path
    shoe: Path
    joints: tuple[str, ...]

    @property
    def mapping(self) -> Path:
        return self.folder / "mapping.yaml"

    def values(self) -> dict[str, object]:
        """Of the mapping."""
        fields = read_yaml(self.mapping)
        return {key: fields.value(key) for key in fields.keys()}

    def draft(self, *recorded: Path) -> dict[str, object]:
        """Draft the mapping, as the command does."""
        shoe = load_shoe(self.shoe)
        robot = load_robot(self.robot, shoe)
        draft = draft_mapping(recorded, robot, shoe)
        text = mapping_text(draft, self.folder, self.robot, robot.urdf, self.shoe)
        self.mapping.write_text(text)
        return self.values()

    def edit(self, **changed: object) -> None:
        """Other values in the mapping; None takes one out."""
        values = {**self.values(), **changed}
        write_yaml(self.mapping, {key: one for key, one in values.items() if one is not None})

    def imported_from(self, bag: Path) -> Session:
        """With the mapping as it is, but of another bag."""
        self.edit(trials=[{"bag": bag.name, "motion": "walk"}])
        return self.imported()

    def imported(self, folder: Path | None = None) -> Session:
        return import_bags(self.mapping, self.folder, folder or self.folder / "session")


@pytest.fixture
def lab(tmp_path: Path) -> Lab:
    robot, shoe = bags.robot_files(tmp_path)
    return Lab(tmp_path, robot, shoe, load_robot(robot).joint_names)


@pytest.mark.parametrize("kind", bags.FORMATS)
def test_a_bag_is_drafted_and_imported(lab: Lab, kind: str) -> None:
    """Every signal arrives: joints renamed, forces in the sole's axes, base in the world."""
    recorded = bags.walk(lab.folder, "walk", kind, lab.joints, prefix=PREFIX).close()
    mapping = lab.draft(recorded)
    assert mapping["joints"] == {
        "topics": ["/joint_states"],
        "rename": {f"{PREFIX}{joint}": joint for joint in lab.joints},
    }
    assert mapping["wrenches"] == {
        "left": {"topic": "/left_ankle/wrench", "rotation_rpy_rad": [0.0, 0.0, 1.570796327]},
        "right": {"topic": "/right_ankle/wrench"},
    }
    assert (mapping["imu"], mapping["base_pose"]) == ({"topic": "/imu/data"}, {"topic": "/odom"})
    assert "received" not in mapping
    session = lab.imported()
    run = Session.open(session.folder).read(1)
    assert run.info.notes == ()
    assert run.joints.names == lab.joints
    times = run.joints.time + 1e-9 * run.start_ns - bags.START_S
    assert len(times) == 200
    for place in range(len(lab.joints)):
        np.testing.assert_allclose(
            run.joints.position[:, place], bags.angles(times, place), atol=1e-6
        )
    assert run.joints.effort is not None
    np.testing.assert_array_equal(run.joints.effort[5], np.arange(len(lab.joints)))
    whole = np.isfinite(run.readings.value).all(axis=1)
    assert whole.sum() > 380
    times = run.readings.time[whole] + 1e-9 * run.start_ns - bags.START_S
    force = bags.force(times)
    names = run.readings.names
    left, right = names.index("left/fx"), names.index("right/fz")
    found = run.readings.value[whole]
    np.testing.assert_allclose(found[:, left : left + 3], force, atol=2e-2)
    np.testing.assert_allclose(found[:, left + 3 : left + 5], 0.1 * force[:, :2], atol=2e-3)
    # Its axis is against the sole's: that is left to the polarity in the shoe file.
    np.testing.assert_allclose(found[:, right], -force[:, 2], atol=2e-2)
    assert run.base_pose is not None
    np.testing.assert_allclose(run.base_pose.position[:, 2], 0.8)
    assert run.imu is not None
    np.testing.assert_allclose(run.imu.linear_acceleration[0], [0, 0, 9.81])


def test_what_is_unclear_is_asked_for(lab: Lab) -> None:
    """Two topics of one kind without the usual name: the draft names both, the import asks."""
    bag = bags.walk(lab.folder, "walk", "mcap", lab.joints)
    for time in np.arange(0.0, 1.0, 0.01):
        for topic in ("/a/pose", "/b/pose"):
            bag.add(time, topic, bag.odometry(time, "body", [0, 0, 0.8], [0, 0, 0, 1]))
    recorded = bag.close()
    assert lab.draft(recorded)["base_pose"] == {"choose": ["/a/pose", "/b/pose", "/odom"]}
    with pytest.raises(FileError) as caught:
        lab.imported()
    assert (
        "mapping.yaml: base_pose.choose: several topics fit (/a/pose, /b/pose, /odom); write "
        in (str(caught.value))
    )
    lab.edit(base_pose={"topic": "/b/pose"})
    base = lab.imported().read(1).base_pose
    assert base is not None
    assert len(base.time) == 100


def test_an_old_bag_played_while_the_new_one_was_recorded(lab: Lab) -> None:
    bag = bags.walk(lab.folder, "walk", "mcap", lab.joints)
    lab.draft(bag.close())
    bag = bags.walk(lab.folder, "both", "mcap", lab.joints)
    for time in np.arange(0.0, 1.9, 0.02):
        old = bag.joint_state(time - 3600.0, list(lab.joints), np.zeros(len(lab.joints)))
        bag.add(time, "/joint_states", old)
    recorded = bag.close()
    for read in (lambda: lab.draft(recorded), lambda: lab.imported_from(recorded)):
        with pytest.raises(FileError, match=r"/joint_states: holds two series .* 3600\.0 s apart"):
            read()


def test_the_pose_of_another_link_of_the_base_is_carried_over(lab: Lab) -> None:
    urdf = lab.folder / "wren.urdf"
    marker = """<link name="marker"/><joint name="on" type="fixed"><parent link="body"/>
        <child link="marker"/><origin xyz="0 0 0.5" rpy="0 0 3.141592653589793"/></joint></robot>"""
    urdf.write_text(urdf.read_text().replace("</robot>", marker))
    bag = bags.walk(lab.folder, "walk", "mcap", lab.joints)
    for time in np.arange(0.0, 1.0, 0.01):
        bag.add(time, "/vicon", bag.odometry(time, "marker", [1, 2, 1.3], [0, 0, 1, 0]))
    lab.draft(bag.close())
    lab.edit(base_pose={"topic": "/vicon", "link": "marker"})
    base = lab.imported().read(1).base_pose
    assert base is not None
    np.testing.assert_allclose(base.position[0], [1, 2, 0.8], atol=1e-12)
    np.testing.assert_allclose(np.abs(base.quaternion[0]), [0, 0, 0, 1], atol=1e-12)
    lab.edit(base_pose={"topic": "/vicon", "link": "left_sole"})
    with pytest.raises(
        FileError, match=r"base_pose\.link: 'left_sole' is no link that is fixed to"
    ):
        lab.imported(lab.folder / "other")


def test_topics_without_stamps_count_when_they_were_received(lab: Lab) -> None:
    bag = bags.BagWriter(lab.folder, "walk", "ros1")
    for time in np.arange(0.0, 1.0, 0.01):
        names = list(lab.joints)
        state = bag.joint_state(None, names, np.zeros(len(names)))
        bag.add(time + 0.5, "/robot/joint_states", state)
        for side in ("left", "right"):
            # No frame of the URDF: the topics' names say which foot.
            bag.add(time + 0.1, f"/{side}_foot_ft", bag.wrench(time, "ati", [0.0, 0.0, 50.0]))
    mapping = lab.draft(bag.close())
    assert mapping["received"] == ["/robot/joint_states"]
    assert mapping["wrenches"] == {
        "left": {"topic": "/left_foot_ft"}, "right": {"topic": "/right_foot_ft"},
    }  # fmt: skip
    run = lab.imported().read(1)
    assert run.joints.time[0] - run.readings.time[0] == pytest.approx(0.5)
    lab.edit(received=[])
    with pytest.raises(FileError, match="/robot/joint_states: its messages carry no stamp; list"):
        lab.imported(lab.folder / "other")


@pytest.mark.parametrize("kind", bags.FORMATS)
@pytest.mark.parametrize("step", [1.0, 0.02])
def test_stamps_without_their_digits_are_refused_with_the_cure(
    lab: Lab, kind: str, step: float
) -> None:
    """Joints at 100 Hz, stamped in whole steps [s]; by the times of receiving they are fine."""
    bag = bags.walk(lab.folder, "walk", kind, lab.joints)
    for received, topic, message in bag._messages:
        if topic == "/joint_states":
            message.header.stamp = bag.header(np.floor(received / step) * step).stamp
    lab.draft(bag.close())
    lab.edit(received=[])
    with pytest.raises(FileError) as caught:
        lab.imported()
    assert "/joint_states: " in str(caught.value)
    assert "messages have the stamp of the one before: their sender rounds" in str(caught.value)
    assert "list the topic under 'received'" in str(caught.value)
    lab.edit(received=["/joint_states"])
    assert len(lab.imported().read(1).joints.time) == 200


def test_messages_that_are_sent_twice_count_once(lab: Lab) -> None:
    bag = bags.walk(lab.folder, "walk", "mcap", lab.joints)
    for received, topic, message in list(bag._messages):
        if topic == "/joint_states":
            bag.add(received + 0.003, topic, message)
    lab.draft(bag.close())
    run = lab.imported().read(1)
    assert len(run.joints.time) == 200
    assert run.info.notes[0].startswith("/joint_states: 200 of 400 messages have a stamp that")


def test_stamps_of_another_clock_count_when_they_were_received(lab: Lab) -> None:
    """Where two clocks differ; one that is off with all topics stays."""
    for name, off, received in (
        ("two", 0.8, ["/left_foot_ft", "/right_foot_ft"]),
        ("one", 0.0, None),
    ):
        bag = bags.BagWriter(lab.folder, name, "mcap")
        for time in np.arange(0.0, 1.0, 0.01):
            state = bag.joint_state(
                time - 100.0 * (off == 0.0), list(lab.joints), np.zeros(len(lab.joints))
            )
            bag.add(time + 0.01, "/joint_states", state)
            for side in ("left", "right"):
                stamp = time - (off or 100.0)
                bag.add(time + 0.01, f"/{side}_foot_ft", bag.wrench(stamp, "ati", [0.0, 0.0, 50.0]))
        assert lab.draft(bag.close()).get("received") == received


def test_a_wrench_of_the_other_foot_is_not_taken_for_want_of_a_better(lab: Lab) -> None:
    bag = bags.BagWriter(lab.folder, "one_foot", "mcap")
    for time in np.arange(0.0, 1.0, 0.01):
        bag.joints(time, lab.joints)
        bag.add(time, "/ft/left", bag.wrench(time, "sensor", [0.0, 0.0, 50.0]))
    assert lab.draft(bag.close())["wrenches"] == {"left": {"topic": "/ft/left"}}
    assert "no topic fits the right foot's six-axis sensor" in lab.mapping.read_text()
    lab.edit(wrenches={"left": {"topic": "/ft/left"}, "right": {"topic": "/ft/left"}})
    with pytest.raises(FileError, match="wrenches: '/ft/left' is given for both feet"):
        lab.imported()


def test_two_senders_of_the_same_joints_are_refused(lab: Lab) -> None:
    """A second one that lists them in another order; one sender may leave some out."""
    names = list(lab.joints)
    for other, refused in ((names[::-1], True), (names[3:], False)):
        bag = bags.BagWriter(lab.folder, f"twice_{refused}", "mcap")
        for time in np.arange(0.0, 1.0, 0.01):
            bag.joints(time, names)
            bag.joints(time + 0.005, other)
            bag.feet(time)
        lab.draft(bag.close())
        folder = lab.folder / f"session_{refused}"
        if not refused:
            lab.imported(folder).read(1)
            continue
        with pytest.raises(FileError, match=r"/joint_states: two senders send '.*' in turns"):
            lab.imported(folder)


def test_feet_that_stand_still_need_no_base_pose(lab: Lab) -> None:
    """Their double support follows from the joint angles."""
    robot = load_robot(lab.robot, load_shoe(lab.shoe))
    expected = Kinematics(robot).states(robot.posture[None]).support()
    for name, sway in (("stands", 1e-4), ("steps", 0.2)):
        bag = bags.BagWriter(lab.folder, name, "mcap")
        for time in np.arange(0.0, 1.0, 0.01):
            posture = robot.posture.copy()
            posture[robot.joint("left_hip_swing")] += sway * np.sin(6.0 * time)
            bag.joints(time, lab.joints, posture)
            bag.feet(time)
        bag.close()
    lab.draft(lab.folder / "stands", lab.folder / "steps")
    stands, steps = read_yaml(lab.mapping).items("trials")
    assert (steps.keys(), steps.text("motion")) == (["motion", "bag"], "walking")
    assert "# CHECK: steps: has no base pose, and its feet move" in lab.mapping.read_text()
    assert stands.text("motion") == "standing"
    place = (expected.dx, expected.dy, expected.dtheta)
    np.testing.assert_allclose(stands.array("support", (3,)), place, atol=1e-3)
    found = lab.imported().runs[0].info.support
    assert found is not None
    np.testing.assert_allclose(found.translation, expected.translation, atol=1e-3)


def test_legs_and_arms_by_drivers_of_their_own(lab: Lab) -> None:
    bag = bags.BagWriter(lab.folder, "walk", "sqlite3")
    legs = [name for name in lab.joints if name.startswith("left")]
    rest = [name for name in lab.joints if name not in legs]
    for time in np.arange(0.0, 1.0, 0.01):
        for topic, names in (("/a/states", legs), ("/b/states", rest)):
            bag.joints(time, names, 0.1, topic)
        bag.feet(time)
    mapping = lab.draft(bag.close())
    assert mapping["joints"] == {"topics": ["/a/states", "/b/states"]}
    run = lab.imported().read(1)
    assert set(run.joints.names) == set(lab.joints)
    assert np.isfinite(run.joints.position).all()


def test_cells_of_the_projects_own_driver(lab: Lab) -> None:
    lab.shoe.write_text(samples.SHOE_YAML)
    cells = list(load_shoe(lab.shoe).names)
    bag = bags.BagWriter(lab.folder, "walk", "mcap")
    kind = schemas.SHOE_VOLTAGES_TYPE
    bag.store.register(get_types_from_msg(schemas.SHOE_VOLTAGES_DEFINITION, kind))
    for step in range(100):
        time = 0.01 * step
        bag.joints(time, lab.joints)
        volts = bag.make(
            kind, header=bag.header(time, "board"), sequence=step, cell=cells,
            voltage=np.arange(6.0), status=np.zeros(6, dtype=np.uint8), temperature=21.0,
        )  # fmt: skip
        bag.add(time, "/shoe/voltages", volts)
    assert lab.draft(bag.close())["cells"] == {"topics": ["/shoe/voltages"]}
    run = lab.imported().read(1)
    np.testing.assert_array_equal(run.readings.value[7], np.arange(6.0))
    np.testing.assert_array_equal(run.readings.sequence[:, 0], np.arange(100))


def test_spans_of_a_long_bag(lab: Lab, monkeypatch: pytest.MonkeyPatch) -> None:
    recorded = bags.walk(lab.folder, "walk", "mcap", lab.joints).close()
    lab.draft(recorded)
    parts = [
        {"motion": "walking", "bag": "walk", "from_s": 0.5, "to_s": 1.0, "set": "train"},
        {"motion": "walking", "bag": "walk", "from_s": 1.0},
    ]
    lab.edit(trials=parts)
    first, second = lab.imported().runs
    assert (first.hint, second.hint) == ("train", "")
    length = Session.open(lab.folder / "session").read(1).joints.time[-1]
    assert length == pytest.approx(0.5, abs=0.03)
    monkeypatch.setattr(foreign, "MAX_RECORDS", 300)
    with pytest.raises(FileTooLargeError, match=r"walk: holds over 300 messages.* 'from_s' and"):
        lab.imported(lab.folder / "other")


@pytest.mark.parametrize(
    ("changed", "problem"),
    [
        (
            {"joints": {"topics": ["/joints"]}},
            "joints.topics: '/joints' is missing in walk; topics",
        ),
        (
            {"imu": {"topic": "/odom"}},
            "imu.topic: '/odom' is nav_msgs/msg/Odometry in walk; topics",
        ),
        ({"joints": {"topics": []}}, "joints.topics: is empty"),
        ({"wrenches": None}, "wrenches: is missing, and so is 'cells'"),
        (
            {"wrenches": {"both": {"topic": "/ft"}}},
            "wrenches.both: unknown key; known: left, right",
        ),
        ({"received": ["/ft"]}, "received: '/ft' is not imported; name one that is"),
        (
            {"trials": [{"motion": "a", "bag": "walk", "from_s": 9}]},
            "walk: has no message of /imu/data, /joint_states, /left_ankle/wrench",
        ),
        ({"trials": [{"motion": "a", "bag": "x"}]}, "x: does not exist; name a bag"),
        ({"trials": [{"motion": "a", "bag": "wren.yaml"}]}, "wren.yaml: is no bag by its name"),
        ({"trials": [{"motion": "a", "bag": "."}]}, "has no metadata.yaml; name the .mcap"),
    ],
)
def test_a_wrong_mapping_is_one_line(lab: Lab, changed: dict[str, object], problem: str) -> None:
    lab.draft(bags.walk(lab.folder, "walk", "mcap", lab.joints).close())
    lab.edit(**changed)
    with pytest.raises(FileError) as caught:
        lab.imported()
    assert problem in str(caught.value)
    assert not (lab.folder / "session").exists()


@pytest.mark.parametrize("kind", bags.FORMATS)
def test_a_damaged_bag_is_one_line(lab: Lab, kind: str) -> None:
    recorded = bags.walk(lab.folder, "walk", kind, lab.joints).close()
    lab.draft(recorded)
    file = recorded if recorded.is_file() else next(
        path for path in recorded.iterdir() if path.suffix in (".mcap", ".db3")
    )  # fmt: skip
    content = file.read_bytes()
    file.write_bytes(content[: len(content) // 2])
    with pytest.raises(FileError) as caught:
        lab.imported()
    assert "cannot be read as a bag" in str(caught.value)


def test_an_altered_byte_is_noticed(lab: Lab) -> None:
    lab.draft(bags.walk(lab.folder, "walk", "mcap", lab.joints).close())
    lab.edit(trials=[{"motion": "walking", "bag": "run.mcap"}])
    file = samples.write_run(lab.folder / "run.mcap", samples.make_sample(500), lab.joints[:6])
    content = bytearray(file.read_bytes())
    content[len(content) // 2] ^= 1
    file.write_bytes(content)
    with pytest.raises(FileError, match=r"run\.mcap: cannot be read as a bag \(crc validation"):
        lab.imported()


def test_commanded_and_measured_joints_are_asked_for(lab: Lab) -> None:
    bag = bags.walk(lab.folder, "walk", "mcap", lab.joints)
    assert lab.draft(bag.close())["joints"] == {"topics": ["/joint_states"]}
    bag = bags.BagWriter(lab.folder, "unusual", "mcap")
    for topic in ("/desired", "/measured"):
        bag.joints(0.0, lab.joints, topic=topic)
    bag.feet(0.0)
    assert lab.draft(bag.close())["joints"] == {"choose": ["/desired", "/measured"]}


def test_a_bag_of_another_robot(lab: Lab) -> None:
    recorded = bags.walk(lab.folder, "walk", "mcap", ("a", "b")).close()
    with pytest.raises(FileError, match="names a, b, …, and none of the joints of 'wren'"):
        lab.draft(recorded)
    lab.shoe.write_text(samples.SHOE_YAML)
    recorded = bags.walk(lab.folder, "other", "mcap", lab.joints).close()
    with pytest.raises(FileError, match="has no topic that fits 'test_shoe'"):
        lab.draft(recorded)


def standing(lab: Lab, name: str, unit: float = 1.0) -> Path:
    """A bag of a robot that stands in its posture; its joint angles are times a unit."""
    posture = unit * load_robot(lab.robot).posture
    bag = bags.BagWriter(lab.folder, name, "mcap")
    for time in np.arange(0.0, 0.5, 0.01):
        bag.joints(time, lab.joints, posture)
        bag.feet(time)
    return bag.close()


@pytest.mark.parametrize("kind", ["mcap", "sqlite3"])
@pytest.mark.parametrize("mode", [CompressionMode.FILE, CompressionMode.MESSAGE])
def test_compressed_bags_are_read(lab: Lab, kind: str, mode: CompressionMode) -> None:
    """As a folder, and its only file alone."""
    bag = bags.walk(lab.folder, "walk", kind, lab.joints)
    bag.compression = mode
    folder = bag.close()
    lab.draft(folder)
    whole = lab.imported().read(1)
    (file,) = (path for path in folder.iterdir() if path.name != "metadata.yaml")
    lab.edit(trials=[{"motion": "walking", "bag": f"walk/{file.name}"}])
    alone = lab.imported(lab.folder / "alone").read(1)
    np.testing.assert_array_equal(alone.joints.position, whole.joints.position)


@pytest.mark.parametrize(
    ("name", "problem"),
    [
        ("walk.bag.bz2", "is compressed; unpack it: `bunzip2 walk.bag.bz2`"),
        ("walk.mcap.zst", "is not compressed by zstd, as its name says; copy it again"),
    ],
)
def test_a_file_that_is_packed_otherwise(lab: Lab, name: str, problem: str) -> None:
    file = lab.folder / name
    file.write_bytes(b"BZh91AY&SY")
    with pytest.raises(FileError) as caught:
        lab.draft(file)
    assert str(caught.value) == f"{file}: {problem}"


BOMB = 96 * 2**20
"""Bytes of zeros, which zstd packs into some kilobytes."""


def test_a_chunk_that_would_fill_the_memory_is_refused_before_it_is_unpacked(lab: Lab) -> None:
    bomb = lab.folder / "bomb.mcap"
    with bomb.open("wb") as target:
        writer = Writer(target, chunk_size=2 * BOMB, compression=CompressionType.ZSTD)
        writer.start("ros2")
        channel = writer.register_channel("/zeros", "cdr", 0)
        writer.add_message(channel, 0, bytes(BOMB), 0)
        writer.finish()
    assert bomb.stat().st_size < BOMB / 1000
    tracemalloc.start()
    with pytest.raises(FileTooLargeError, match="holds a chunk of 96 MiB, more than 64; write"):
        lab.draft(bomb)
    _, peak = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert peak < BOMB / 10


def test_chunks_compressed_by_lz4_are_read(lab: Lab) -> None:
    folder = bags.walk(lab.folder, "walk", "mcap", lab.joints).close()
    packed = lab.folder / "packed.mcap"
    bags.rewritten(folder / "walk.mcap", packed, compression=CompressionType.LZ4)
    lab.draft(packed)
    assert len(lab.imported().read(1).joints.time) == 200


@pytest.mark.parametrize(
    ("suffix", "cure"), [(".zst", "zstd -d walk.mcap.zst"), (".gz", "gunzip walk.mcap.gz")]
)
def test_files_packed_after_recording_name_the_command(lab: Lab, suffix: str, cure: str) -> None:
    folder = bags.walk(lab.folder, "walk", "mcap", lab.joints).close()
    file = folder / "walk.mcap"
    file.rename(file.with_name(f"walk.mcap{suffix}"))
    with pytest.raises(FileError) as caught:
        lab.draft(folder)
    assert str(caught.value).startswith(f"{file}{suffix}: is compressed")
    assert f"unpack it: `{cure}`" in str(caught.value)


@pytest.mark.parametrize(
    ("old", "new", "problem"),
    [
        ("", "", "walk/walk.mcap: is listed in metadata.yaml, but does not exist; put it back"),
        ("rosbag2_bagfile", "x", "walk/metadata.yaml: does not list the files of a bag; make it"),
        ("version: 9", "version: 99", "version 99 not supported); convert it with `ros2 bag conv"),
    ],
)
def test_a_folder_that_is_not_whole(lab: Lab, old: str, new: str, problem: str) -> None:
    folder = bags.walk(lab.folder, "walk", "mcap", lab.joints).close()
    metadata = folder / "metadata.yaml"
    if old:
        metadata.write_text(metadata.read_text().replace(old, new))
    else:
        (folder / "walk.mcap").unlink()
    with pytest.raises(FileError) as caught:
        lab.draft(folder)
    assert problem in str(caught.value)
    if isinstance(caught.value, FileMissingError):
        assert caught.value.named == (folder / "walk.mcap", folder)


def test_a_file_that_was_renamed_is_named(lab: Lab) -> None:
    folder = bags.walk(lab.folder, "walk", "mcap", lab.joints).close()
    (folder / "walk.mcap").rename(folder / "run_5.mcap")
    with pytest.raises(FileError, match=r"walk.mcap: is listed .*; give run_5.mcap its name again"):
        lab.draft(folder)


def test_a_recording_that_is_missing_is_no_other_trials(lab: Lab) -> None:
    """Of what is named together with it none is taken for it."""
    recorded = bags.walk(lab.folder, "walk_1", "mcap", lab.joints).close()
    missing = lab.folder / "walk_2"
    with pytest.raises(FileMissingError) as caught:
        lab.draft(recorded, missing)
    assert caught.value.path == missing
    assert set(caught.value.named) == {recorded, missing}
    lab.draft(recorded)
    lab.edit(trials=[{"bag": name, "motion": "walk"} for name in ("walk_1", "walk_2")])
    with pytest.raises(FileMissingError) as caught:
        lab.imported()
    assert set(caught.value.named) == {recorded, missing}


@pytest.mark.parametrize("kind", ["ros1", "mcap"])
@pytest.mark.parametrize("text", ["1.5,-3", "FL: 12, FR: 7", "812"])
def test_readings_as_text_are_refused_with_the_cure(lab: Lab, kind: str, text: str) -> None:
    """At the draft, and wherever a mapping names such a topic."""
    bag = bags.BagWriter(lab.folder, "lines", kind)
    for time in np.arange(0.0, 1.0, 0.1):
        bag.joints(time, lab.joints)
        bag.add(time, "/arduino", bag.make("std_msgs/msg/String", data=text))
        bag.add(time, "/state", bag.make("std_msgs/msg/String", data="ready"))
    bag.add(0.0, "/robot_description", bag.make("std_msgs/msg/String", data="<mass value='1'/>"))
    recorded = bag.close()
    problem = (
        "/arduino holds text (std_msgs/msg/String), which is not read: publish numbers, or export "
        "it to CSV and use `shoecal import csv`"
    )
    with pytest.raises(FileError) as caught:
        lab.draft(recorded)
    assert f"): {problem}; it holds /arduino" in str(caught.value)
    trials = [{"bag": recorded.name, "motion": "walk"}]
    for cells in ({"topics": ["/arduino"]}, {"/arduino": {"data": "left/fz"}}):
        mapping = {
            "format": 1, "robot": "wren.yaml", "urdf": "wren.urdf", "shoe": "ankles.yaml",
            "joints": {"topics": ["/joint_states"]}, "cells": cells, "trials": trials,
        }  # fmt: skip
        write_yaml(lab.mapping, mapping)
        with pytest.raises(FileError) as caught:
            lab.imported()
        assert str(caught.value).startswith(f"{lab.mapping}: cells.")
        assert str(caught.value).endswith(problem)


def test_joint_angles_as_text_are_refused_with_the_cure(lab: Lab) -> None:
    bag = bags.BagWriter(lab.folder, "lines", "mcap")
    for time in np.arange(0.0, 1.0, 0.1):
        for topic in ("/servo_1", "/servo_2"):
            bag.add(time, topic, bag.make("std_msgs/msg/String", data="0.25"))
    with pytest.raises(FileError, match=r"/servo_1, /servo_2 hold text .*: publish numbers, or"):
        lab.draft(bag.close())


def test_errors_of_libraries_are_without_python(lab: Lab) -> None:
    file = lab.folder / "text.mcap"
    file.write_text("hello world, this is no bag")
    with pytest.raises(FileError, match="is no MCAP file, though its name says so"):
        lab.draft(file)
    file.write_text("")
    with pytest.raises(FileError, match="is empty; copy it again"):
        lab.draft(file)
    assert reason_of(ValueError("damaged: ('cut',), ['a']")) == "damaged: cut, 'a'"
    for error in (AssertionError(), KeyError("topic")):
        assert reason_of(error) == "its content is not of its kind"


def test_stamps_that_cannot_be_are_refused(lab: Lab) -> None:
    bag = bags.walk(lab.folder, "walk", "mcap", lab.joints)
    bag.add(0.0, "/imu/data", bag.imu(-bags.START_S - 5.0, "body"))
    lab.draft(bag.close())
    with pytest.raises(FileError, match=r"walk: /imu/data: has stamps before 1970 or after 2038"):
        lab.imported()


def test_a_topic_of_other_joints_is_refused(lab: Lab) -> None:
    lab.draft(bags.walk(lab.folder, "walk", "mcap", lab.joints, prefix=PREFIX).close())
    lab.edit(joints={"topics": ["/joint_states"]})
    with pytest.raises(FileError, match="/joint_states: names no joint of the robot"):
        lab.imported()


@pytest.mark.parametrize("prefix", ["nao6/", "/nao6_"])
def test_frames_with_a_robots_prefix(lab: Lab, prefix: str) -> None:
    """Sensors are found by their frames all the same, and the notes say so."""
    bag = bags.walk(lab.folder, "walk", "mcap", lab.joints)
    bag.prefix_frames(prefix)
    mapping = lab.draft(bag.close())
    assert mapping["wrenches"] == {
        "left": {"topic": "/left_ankle/wrench", "rotation_rpy_rad": [0.0, 0.0, 1.570796327]},
        "right": {"topic": "/right_ankle/wrench"},
    }
    assert mapping["base_pose"] == {"topic": "/odom"}
    run = lab.imported().read(1)
    assert f"/imu/data: frame '{prefix}body' is taken as the URDF's 'body'" in run.info.notes
    assert run.imu is not None
    assert run.imu.frame == "body"


def test_angles_in_degrees(lab: Lab) -> None:
    """The draft says so; an import without that is refused."""
    unit = float(np.degrees(1.0))
    mapping = lab.draft(standing(lab, "stands", unit))
    assert mapping["angle_unit"] == "deg"
    run = lab.imported().read(1)
    np.testing.assert_allclose(run.joints.position[3], load_robot(lab.robot).posture, atol=1e-12)
    lab.edit(angle_unit=None)
    with pytest.raises(FileError, match=r"stands: joint '.*' is at .* rad, beyond its limits "):
        lab.imported(lab.folder / "other")


def test_a_joint_beyond_its_limits_is_noted(lab: Lab) -> None:
    lab.draft(bags.walk(lab.folder, "walk", "mcap", lab.joints).close())
    urdf = lab.folder / "wren.urdf"
    urdf.write_text(urdf.read_text().replace('lower="-1.5" upper="1.5"', 'lower="-2" upper="-1"'))
    note = "joint 'head_pan' is at 0.1 rad, beyond its limits -2 to -1 rad in the URDF: check unit"
    assert any(one.startswith(note) for one in lab.imported().runs[0].info.notes)


def test_a_support_of_the_opposite_sign_is_refused(lab: Lab) -> None:
    lab.draft(standing(lab, "stands"))
    trial = {"motion": "standing", "bag": "stands"}
    dx, dy, dtheta = read_yaml(lab.mapping).items("trials")[0].array("support", (3,)).tolist()
    lab.edit(trials=[{**trial, "support": [dx, -dy, dtheta]}])
    with pytest.raises(FileError) as caught:
        lab.imported()
    expected = f"trials[0].support: dy is {-dy:.4g} m, but {dy:.4g} m by the joint angles of stands"
    assert expected in str(caught.value)
    assert "the sign is opposite" in str(caught.value)
    lab.edit(trials=[{**trial, "support": [dx + 0.1, dy, dtheta]}])
    assert lab.imported().runs[0].info.notes[0].startswith(f"support: dx is {dx + 0.1:.4g} m, but")


def sways(lab: Lab, name: str, angles: FloatArray, *, exchanged: bool) -> Path:
    """A bag of angles (T, m) [rad], each leg's under the other one's names."""
    other = {joint: joint for joint in lab.joints}
    if exchanged:
        for left, right in leg_pairs(Kinematics(load_robot(lab.robot))):
            other |= {left: right, right: left}
    bag = bags.BagWriter(lab.folder, name, "mcap")
    for row, posture in enumerate(angles):
        bag.joints(0.02 * row, [other[joint] for joint in lab.joints], posture)
        bag.feet(0.02 * row)
    return bag.close()


def test_legs_at_each_others_place_are_named(lab: Lab) -> None:
    """By the draft, and by an import that is given the support."""
    angles = standing_angles(Kinematics(load_robot(lab.robot, load_shoe(lab.shoe))), ASTRIDE)
    names = ("sound", "exchanged")
    lab.draft(*(sways(lab, one, angles, exchanged=one != "sound") for one in names))
    told = "the left and the right leg are exchanged (best fit: the joints of both legs"
    assert lab.mapping.read_text().count("are exchanged") == 1
    assert told in " ".join(lab.mapping.read_text().replace("#", " ").split())
    support = [ASTRIDE.dx, ASTRIDE.dy, ASTRIDE.dtheta]
    trials = [{"motion": "sways", "bag": one, "support": support} for one in names]
    lab.edit(trials=trials[:1])
    assert not lab.imported().runs[0].info.notes
    lab.edit(trials=trials)
    sound, exchanged = lab.imported(lab.folder / "other").runs
    assert not sound.info.notes
    assert any(told in note for note in exchanged.info.notes)


def test_angles_and_readings_of_two_clocks_are_refused(lab: Lab) -> None:
    """Unless their times meet, if only partly."""
    for late, refused in ((0.5, False), (90.0, True)):
        bag = bags.BagWriter(lab.folder, f"late_{refused}", "mcap")
        for time in np.arange(0.0, 1.0, 0.01):
            bag.joints(time, lab.joints)
            for side in ("left", "right"):
                wrench = bag.wrench(time + late, f"{side}_sensor", [0.0, 0.0, 50.0])
                bag.add(time, f"/{side}", wrench)
        lab.draft(bag.close())
        lab.edit(received=None)
        if not refused:
            assert len(lab.imported(lab.folder / "partly").read(1).joints.time) == 100
            continue
        with pytest.raises(FileError) as caught:
            lab.imported()
        assert "its joint angles are stamped 1700000000.000 to 1700000000.990 s" in str(
            caught.value
        )
        assert "its readings 1700000090.000 to 1700000090.990 s, none in" in str(caught.value)
        lab.edit(received=["/joint_states", "/left", "/right"])
        assert len(lab.imported().read(1).readings.time) == 100


@pytest.mark.parametrize(
    ("files", "problem"),
    [
        (["walk_0.mcap"], "name the .mcap or .db3 file in it"),
        (["monday.mcap", "tuesday.mcap"], "name the .mcap or .db3 file in it"),
        (["a_0.mcap", "b_0.mcap"], "name the .mcap or .db3 file in it"),
        (["w_0.db3", "w_1.db3", "w_1.db3-wal"], "w_0.db3 to w_1.db3 in it are 2 parts of one bag"),
        (["w_0.mcap.zstd", "w_1.mcap.zstd", "w_2.mcap"], "to w_2.mcap in it are 3 parts of one"),
    ],
)
def test_a_folder_without_metadata(lab: Lab, files: list[str], problem: str) -> None:
    """Of one bag's parts none is a run of its own."""
    folder = lab.folder / "killed"
    folder.mkdir()
    for name in files:
        (folder / name).write_bytes(b"")
    with pytest.raises(FileError) as caught:
        lab.draft(folder)
    assert f"killed: has no metadata.yaml; {problem}" in str(caught.value).replace(
        "w_0.mcap.zstd ", ""
    )
    assert ("name the" in str(caught.value)) == (len(files) < 3)
    assert "`ros2 bag reindex" in str(caught.value)


def test_a_joint_without_angles_is_refused(lab: Lab) -> None:
    names = list(lab.joints)
    angles = np.where(np.array(names) == "left_knee", np.nan, 0.0)
    lab.draft(joint_states(lab, names, angles))
    with pytest.raises(FileError, match="joints: holds no angle of joint 'left_knee'"):
        lab.imported()


@pytest.mark.parametrize("drafted", [True, False])
@pytest.mark.parametrize(
    ("more", "positions", "problem"),
    [
        ([], 0, "none of its messages has a position for each of its names (the first has"),
        ([], -2, "correct its sender, or name the topic of the measured joint angles"),
        (["left_knee"], None, "names 'left_knee' twice, so which of its numbers count is not"),
    ],
)
def test_joint_states_of_other_numbers_than_names_are_named(
    lab: Lab, more: list[str], positions: int | None, problem: str, drafted: bool
) -> None:
    """Positions left out, two fewer than names, and a name twice."""
    names = [*lab.joints, *more]
    bag = joint_states(lab, names, np.zeros(len(names))[:positions])
    if not drafted:
        lab.draft(joint_states(lab, lab.joints, np.zeros(len(lab.joints)), "sound"))
        lab.edit(trials=[{"motion": "standing", "bag": bag.name, "support": [0.0, -0.1, 0.0]}])
    with pytest.raises(FileError) as caught:
        lab.draft(bag) if drafted else lab.imported()
    assert f"{bag.name}: /joint_states: " in str(caught.value)
    assert problem in str(caught.value)


def test_a_name_twice_of_what_is_no_joint_of_the_robot_is_left_out(lab: Lab) -> None:
    names = [*lab.joints, "gripper", "gripper"]
    lab.draft(joint_states(lab, names, np.zeros(len(names))))
    assert lab.imported().runs


def joint_states(
    lab: Lab, names: Sequence[str], positions: FloatArray, name: str = "joints"
) -> Path:
    """A bag of joint states with these names and positions, and of one foot."""
    bag = bags.BagWriter(lab.folder, name, "mcap")
    for time in np.arange(0.0, 0.5, 0.01):
        bag.add(time, "/joint_states", bag.joint_state(time, list(names), positions))
        bag.feet(time, ["left"])
    return bag.close()


def test_a_joint_that_the_robot_needs_is_asked_for(lab: Lab) -> None:
    bag = bags.BagWriter(lab.folder, "stands", "mcap")
    for time in np.arange(0.0, 0.5, 0.01):
        bag.joints(time, lab.joints[:-1])
        bag.feet(time, ["left"])
    lab.draft(bag.close())
    lab.edit(trials=[{"motion": "standing", "bag": "stands", "support": [0.0, -0.1, 0.0]}])
    with pytest.raises(FileError, match=f"stands: robot 'wren' needs joint.* {lab.joints[-1]}"):
        lab.imported()


def test_a_base_pose_without_poses_is_refused(lab: Lab) -> None:
    bag = bags.walk(lab.folder, "walk", "mcap", lab.joints)
    lab.draft(bag.close())
    bag = bags.BagWriter(lab.folder, "again", "mcap")
    for time in np.arange(0.0, 0.5, 0.01):
        bag.add(time, "/odom", bag.odometry(time, "body", [0, 0, 0.8], [0, 0, 0, 0]))
        bag.joints(time, lab.joints)
        bag.feet(time, ["left"])
    lab.draft(bag.close())
    with pytest.raises(FileError, match="again: /odom: none of its poses has a position and"):
        lab.imported()
