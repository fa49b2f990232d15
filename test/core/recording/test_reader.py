from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from mcap.writer import Writer

from core.recording import samples
from core.recording.samples import JOINTS, START_NS, STEP_NS
from shoecal_core.errors import FileMissingError, VersionError
from shoecal_core.recording import messages, schemas
from shoecal_core.recording.errors import DamagedError, RecordingError
from shoecal_core.recording.reader import read_run
from shoecal_core.recording.run import Run
from shoecal_core.recording.writer import RunWriter
from shoecal_core.shoe.shoe import Shoe

Message = tuple[str, bytes]


def joints(step: int, *, names: tuple[str, ...] = JOINTS, value: float = 0.5) -> Message:
    data = messages.joint_state(START_NS + step * STEP_NS, names, np.full(len(names), value))
    return schemas.JOINT_STATES, data


def volts(
    step: int,
    cells: Iterable[str],
    value: float = 1.0,
    *,
    sequence: int | None = None,
    frame: str = "",
) -> Message:
    cells = tuple(cells)
    stamp = START_NS + step * STEP_NS
    data = messages.shoe_voltages(
        stamp,
        step if sequence is None else sequence,
        cells,
        np.full(len(cells), value),
        np.zeros(len(cells)),
        temperature=21.0,
        frame_id=frame,
    )
    return schemas.VOLTAGES, data


@pytest.fixture
def record(tmp_path: Path, shoe: Shoe) -> Callable[[list[Message]], Run]:
    """Write messages, received one a step, and read them again."""

    def write_and_read(recorded: list[Message], of: Shoe = shoe) -> Run:
        path = tmp_path / "run_001.mcap"
        with RunWriter(path, samples.INFO) as writer:
            for place, (topic, data) in enumerate(recorded):
                writer.write(topic, data, START_NS + place)
        return read_run(path, of)

    return write_and_read


Record = Callable[..., Run]


def test_round_trip(tmp_path: Path, shoe: Shoe) -> None:
    sample = samples.make_sample(50)
    path = samples.write_run(tmp_path / "run_001.mcap", sample, shoe.names)
    run = read_run(path, shoe)
    assert (run.info, run.path, run.start_ns, run.notes) == (samples.INFO, path, START_NS, ())
    assert run.joints.names == JOINTS
    np.testing.assert_allclose(run.joints.time, 0.01 * np.arange(50), atol=1e-12)
    np.testing.assert_array_equal(run.joints.position, sample.angles)
    np.testing.assert_array_equal(run.joints.effort, sample.efforts)
    assert run.readings.names == shoe.names
    np.testing.assert_array_equal(run.readings.time, run.joints.time)
    np.testing.assert_array_equal(run.readings.value, sample.volts)
    np.testing.assert_array_equal(run.readings.status, 0)
    np.testing.assert_array_equal(run.readings.sequence[:, 0], np.arange(50))
    assert (run.commanded, run.base_pose, run.imu, run.shoe_temperature) == ((), None, None, None)


def test_cells_are_put_in_the_shoes_order(record: Record, shoe: Shoe) -> None:
    cells = shoe.names[::-1]
    data = messages.shoe_voltages(START_NS, 3, cells, np.arange(6.0), [0, 1, 2, 3, 0, 0])
    run = record([joints(0), (schemas.VOLTAGES, data)])
    np.testing.assert_array_equal(run.readings.value, [[5, 4, 3, 2, 1, 0]])
    np.testing.assert_array_equal(run.readings.status, [[0, 0, 3, 2, 1, 0]])


def test_boards_are_joined_by_stamp(record: Record, shoe: Shoe) -> None:
    left, right = shoe.names[:3], shoe.names[3:]
    run = record(
        [
            joints(0),
            volts(0, left, 1.0, frame="l"),
            volts(1, left, 3.0, frame="l"),
            volts(0, right, 2.0, frame="r"),  # the other board's messages come late
            volts(2, right, 4.0, frame="r"),
        ]
    )
    nan = np.nan
    np.testing.assert_array_equal(
        run.readings.value[:, [0, 5]], [[1.0, 2.0], [3.0, nan], [nan, 4.0]]
    )
    np.testing.assert_array_equal(run.readings.status[:, [0, 5]], [[0, 0], [0, 2], [2, 0]])
    np.testing.assert_array_equal(run.readings.sequence[:, [0, 5]], [[0, 0], [1, -1], [-1, 2]])
    assert run.notes == ("2 of 3 readings lack some channels",)


def test_a_value_that_is_none_is_marked(record: Record, shoe: Shoe) -> None:
    data = messages.shoe_voltages(
        START_NS, 0, shoe.names, [np.nan, np.inf, np.nan, 1.0, 1.0, 1.0], [0, 0, 3, 0, 1, 0]
    )
    run = record([joints(0), (schemas.VOLTAGES, data)])
    assert np.isnan(run.readings.value[0, :3]).all()
    np.testing.assert_array_equal(run.readings.status, [[2, 2, 3, 0, 1, 0]])
    assert "channel 'left/front' has no readings" in run.notes


def test_repeated_and_backward_stamps_are_dropped_and_counted(record: Record, shoe: Shoe) -> None:
    run = record(
        [
            *(
                joints(step, value=value)
                for step, value in ((0, 1), (1, 2), (1, 9), (0, 9), (2, 3))
            ),
            *(volts(step, shoe.names, sequence=place) for place, step in enumerate((0, 1, 1, 2))),
        ]
    )
    np.testing.assert_array_equal(run.joints.position[:, 0], [1, 2, 3])
    np.testing.assert_array_equal(run.readings.sequence[:, 0], [0, 1, 3])
    assert run.notes == (
        "/joint_states: 2 of 5 messages dropped, their stamps repeat or go back",
        "/shoe/voltages: 1 of 4 messages dropped, their stamps repeat or go back",
    )


def test_stamps_that_were_never_set_are_an_error(record: Record, shoe: Shoe) -> None:
    data = messages.joint_state(0, JOINTS, np.zeros(3))
    with pytest.raises(RecordingError, match=r"/joint_states: its messages carry no stamp"):
        record([(schemas.JOINT_STATES, data)] * 3)


def test_readings_that_no_cell_gives_are_none(record: Record, shoe: Shoe) -> None:
    run = record([joints(0), volts(0, shoe.names, value=1e300), volts(1, shoe.names)])
    assert np.isnan(run.readings.value[0]).all()
    assert (run.readings.status[0] == schemas.NO_DATA).all()


def test_joints_that_lack_angles_now_and_then_are_noted(record: Record, shoe: Shoe) -> None:
    told = [joints(step, value=np.nan if step == 1 else 0.0) for step in range(4)]
    run = record([*told, volts(0, shoe.names)])
    listed = ", ".join(f"'{joint}'" for joint in JOINTS)
    assert f"joints {listed} have no angle (NaN) in 1 of 4 messages" in run.notes


def test_joints_of_two_publishers_are_joined(record: Record, shoe: Shoe) -> None:
    run = record(
        [
            joints(0, names=("a", "b"), value=1.0),
            joints(0, names=("c",), value=np.nan),
            joints(1, names=("a", "b"), value=2.0),
            volts(0, shoe.names),
        ]
    )
    assert run.joints.names == ("a", "b", "c")
    np.testing.assert_array_equal(run.joints.position[:, :2], [[1.0, 1.0], [2.0, 2.0]])
    assert run.joints.effort is None
    assert run.notes == ("joint 'c' was never recorded",)


@pytest.mark.parametrize(
    ("recorded", "problem"),
    [
        ([volts(0, ["left/front"])], "holds no joint angles"),
        ([joints(0)], "holds no readings of 'test_shoe'"),
        ([joints(0), volts(0, ["left/toe"])], "names 'left/toe', known are: left/front"),
        ([joints(0), volts(0, ["left/front"] * 2)], "has a name twice"),
        ([joints(0, names=("a", "a")), volts(0, ["left/front"])], "has a name twice"),
        (
            [joints(0), volts(0, ["left/front"]), volts(0, ["left/front", "right/front"])],
            "'left/front' is recorded twice",
        ),
        (
            [
                joints(0),
                volts(0, ["left/front"], frame="a"),
                volts(1, ["left/front"], frame="b"),
            ],
            "'left/front' comes from /shoe/voltages with frame 'a' and from",
        ),
        (
            [
                joints(0),
                *(volts(step, ["left/front"], sequence=step % 2 * 90 + step) for step in range(9)),
            ],
            "two devices send left/front",
        ),
        ([joints(0), (schemas.VOLTAGES, b"\x00\x01\x00\x00junk")], "/shoe/voltages: not a shoecal"),
    ],
)
def test_contradictions_are_errors(record: Record, recorded: list[Message], problem: str) -> None:
    with pytest.raises(RecordingError) as caught:
        record(recorded)
    assert problem in str(caught.value)
    assert "run_001.mcap" in str(caught.value)


def test_one_value_a_cell(record: Record, shoe: Shoe) -> None:
    store = schemas.typestore()
    message = store.types[schemas.SHOE_VOLTAGES_TYPE](
        header=store.types["std_msgs/msg/Header"](
            stamp=store.types["builtin_interfaces/msg/Time"](sec=1, nanosec=0), frame_id=""
        ),
        sequence=0,
        cell=["left/front", "right/front"],
        voltage=np.zeros(1),
        status=np.zeros(2, dtype=np.uint8),
        temperature=0.0,
    )
    data = bytes(store.serialize_cdr(message, schemas.SHOE_VOLTAGES_TYPE))
    with pytest.raises(RecordingError, match=r"1 values of 'voltage' for 2 cells"):
        record([joints(0), (schemas.VOLTAGES, data)])


def test_a_counter_may_overflow_and_restart(record: Record, shoe: Shoe) -> None:
    sequences = [2**32 - 2, 2**32 - 1, 0, 1, 0, 1]
    recorded = [volts(step, shoe.names, sequence=seq) for step, seq in enumerate(sequences)]
    run = record([joints(0), *recorded])
    np.testing.assert_array_equal(run.readings.sequence[:, 0], sequences)
    assert run.notes == ("/shoe/voltages: the device counter ran back 1 times",)


def test_six_axis_feet(record: Record, ankles: Shoe) -> None:
    force, torque = [1.0, 2.0, 3.0], [4.0, 5.0, 6.0]
    left = messages.wrench(START_NS, "l_ankle", force, torque)
    right = messages.wrench(START_NS, "r_ankle", force, torque)
    run = record([joints(0), ("/ft/left", left), ("/ft/right", right)], ankles)
    assert run.readings.names[:5] == ("left/fx", "left/fy", "left/fz", "left/mx", "left/my")
    np.testing.assert_array_equal(run.readings.value, [[1, 2, 3, 4, 5, 3, 4, 5]])
    np.testing.assert_array_equal(run.readings.status, 0)
    np.testing.assert_array_equal(run.readings.sequence, -1)
    with pytest.raises(RecordingError, match="holds no readings"):
        record_elsewhere(run.path.with_name("run_002.mcap"), [joints(0)], ankles)


def record_elsewhere(path: Path, recorded: list[Message], shoe: Shoe) -> Run:
    with RunWriter(path, samples.INFO) as writer:
        for topic, data in recorded:
            writer.write(topic, data, START_NS)
    return read_run(path, shoe)


def test_commanded_trajectories(record: Record, shoe: Shoe) -> None:
    position = np.arange(4.0).reshape(2, 2)
    later = messages.joint_trajectory(START_NS + 10**9, ("a", "b"), [0.5, 1.5], position)
    at_once = messages.joint_trajectory(0, ("a", "b"), [0.5, 1.5], position)
    back = messages.joint_trajectory(0, ("a", "b"), [1.5, 0.5], position)
    stop = messages.joint_trajectory(0, ("a", "b"), [], np.empty((0, 2)))
    recorded = [(schemas.JOINT_TRAJECTORY, data) for data in (later, at_once, back, stop)]
    run = record([joints(0), *recorded, volts(0, shoe.names)])
    first, second = run.commanded
    assert first.start == 1.0
    np.testing.assert_array_equal(first.time, [0.5, 1.5])
    np.testing.assert_array_equal(first.position, position)
    assert first.names == ("a", "b")
    assert second.start == pytest.approx(2e-9)  # when it was received
    assert [note.startswith("/joint_trajectory: one trajectory") for note in run.notes] == [
        True
    ] * 2


def test_optional_topics(record: Record, shoe: Shoe) -> None:
    run = record(
        [
            joints(0),
            volts(0, shoe.names),
            (schemas.BASE_POSE, messages.pose(START_NS, "w", [1, 2, 3], [0, 0, 0, 1])),
            (schemas.BASE_POSE, messages.pose(START_NS + 1, "w", [1, 2, 3], [0, 0, 0, 0])),
            (schemas.IMU, messages.imu(START_NS, "torso", [0, 0, 1, 0], [1, 2, 3], [4, 5, 6])),
            (schemas.IMU, messages.imu(START_NS + 1, "torso", None, [1, 2, 3], [4, 5, 6])),
            (schemas.IMU, messages.imu(START_NS + 2, "torso", [0, 0, 0, 0], [1, 2, 3], [4, 5, 6])),
            (schemas.SHOE_TEMPERATURE, messages.temperature(START_NS, "", 25.5)),
            (schemas.JOINT_TEMPERATURES, messages.temperature(START_NS, "LKneePitch", 40.0)),
            (schemas.JOINT_TEMPERATURES, messages.temperature(START_NS, "RKneePitch", 41.0)),
            (schemas.JOINT_TEMPERATURES, messages.temperature(START_NS + 1, "LKneePitch", 42.0)),
        ]
    )
    assert run.base_pose is not None
    np.testing.assert_array_equal(run.base_pose.position, [[1, 2, 3]])
    assert run.notes == (
        "/base_pose: 1 are no poses, left out",
        "/imu: 1 of 3 orientations are no unit quaternions; taken as not there",
    )
    assert run.imu is not None
    assert run.imu.frame == "torso"
    np.testing.assert_array_equal(run.imu.quaternion, [[0, 0, 1, 0], *2 * [[np.nan] * 4]])
    np.testing.assert_array_equal(run.imu.linear_acceleration[0], [4, 5, 6])
    assert run.shoe_temperature is not None
    assert run.shoe_temperature.value.tolist() == [25.5]


def test_two_senders_of_a_pose_are_an_error(record: Record, shoe: Shoe) -> None:
    poses = [messages.pose(START_NS, frame, [1, 2, 3], [0, 0, 0, 1]) for frame in "ab"]
    with pytest.raises(
        RecordingError, match=r"/base_pose: is sent for several frames \('a', 'b'\)"
    ):
        record([joints(0), volts(0, shoe.names), *((schemas.BASE_POSE, data) for data in poses)])


def test_unfinished_and_foreign_files_are_refused(tmp_path: Path, shoe: Shoe) -> None:
    missing = tmp_path / "missing.mcap"
    with pytest.raises(FileMissingError, match="cannot be read"):
        read_run(missing, shoe)
    text = tmp_path / "text.mcap"
    text.write_text("format: 1\n")
    with pytest.raises(RecordingError, match="is no MCAP file"):
        read_run(text, shoe)
    for profile, problem in (("", "no recording of ROS 2"), ("ros2", "no run of shoecal")):
        foreign = tmp_path / f"foreign{profile}.mcap"
        with foreign.open("wb") as file:
            writer = Writer(file, enable_data_crcs=True)
            writer.start(profile)
            writer.finish()
        with pytest.raises(RecordingError, match=problem):
            read_run(foreign, shoe)


def write_raw(
    path: Path, metadata: dict[str, str], *, schema: str, hashed: str, crcs: bool = True
) -> Path:
    """A file whose only channel /joint_states is as told."""
    with path.open("wb") as file:
        writer = Writer(file, enable_data_crcs=crcs)
        writer.start("ros2")
        writer.add_metadata("shoecal", metadata)
        schema_id = writer.register_schema(schema, "ros2msg", b"float64 x")
        channel = writer.register_channel(
            schemas.JOINT_STATES, "cdr", schema_id, {"topic_type_hash": hashed}
        )
        writer.add_message(channel, 1, b"\x00\x01\x00\x00", 1)
        writer.finish()
    return path


def test_other_types_versions_and_files_without_checksum_are_refused(
    tmp_path: Path, shoe: Shoe
) -> None:
    joint_state = schemas.RUN_TOPICS[schemas.JOINT_STATES]
    good = schemas.type_hash(joint_state)
    metadata = samples.INFO.to_metadata()
    other = write_raw(tmp_path / "a", metadata, schema="std_msgs/msg/Float64", hashed=good)
    with pytest.raises(RecordingError, match=r"/joint_states: is std_msgs/msg/Float64 in cdr"):
        read_run(other, shoe)
    old = write_raw(tmp_path / "b", metadata, schema=joint_state, hashed="RIHS01_0")
    with pytest.raises(RecordingError, match="another definition of sensor_msgs/msg/JointState"):
        read_run(old, shoe)
    newer = {**metadata, "format_version": "2"}
    with pytest.raises(VersionError, match="version 2 is not known"):
        read_run(write_raw(tmp_path / "c", newer, schema=joint_state, hashed=good), shoe)
    bare = write_raw(tmp_path / "d", metadata, schema=joint_state, hashed=good, crcs=False)
    with pytest.raises(DamagedError, match="no checksum"):
        read_run(bare, shoe)
    changed = {**metadata, "support": "0.03 -0.1 0.3"}
    with pytest.raises(DamagedError, match="fails its checksum"):
        read_run(write_raw(tmp_path / "e", changed, schema=joint_state, hashed=good), shoe)


@pytest.fixture(scope="module")
def small(tmp_path_factory: pytest.TempPathFactory, shoe: Shoe) -> tuple[bytes, Run]:
    """A run of several chunks, and what it holds."""
    path = tmp_path_factory.mktemp("small") / "run_001.mcap"
    samples.write_run(path, samples.make_sample(120), shoe.names)
    return path.read_bytes(), read_run(path, shoe)


def same(one: Run, other: Run) -> bool:
    return (
        replace(one.info) == other.info
        and one.start_ns == other.start_ns
        and np.array_equal(one.joints.time, other.joints.time)
        and np.array_equal(one.joints.position, other.joints.position)
        and np.array_equal(one.readings.value, other.readings.value)
        and np.array_equal(one.readings.time, other.readings.time)
        and one.notes == other.notes
    )


@settings(max_examples=300)
@given(data=st.data())
def test_flipped_bits_never_give_wrong_data(
    data: st.DataObject,
    small: tuple[bytes, Run],
    shoe: Shoe,
    tmp_path_factory: pytest.TempPathFactory,
) -> None:
    content, run = small
    altered = bytearray(content)
    for bit in data.draw(st.lists(st.integers(0, 8 * len(content) - 1), min_size=1, max_size=4)):
        altered[bit // 8] ^= 1 << bit % 8
    path = tmp_path_factory.getbasetemp() / "flipped.mcap"
    path.write_bytes(altered)
    try:
        read = read_run(path, shoe)
    except (RecordingError, VersionError):
        return
    assert same(read, run)


@settings(max_examples=150)
@given(share=st.floats(0.0, 1.0, exclude_max=True))
def test_cut_files_are_refused(
    share: float, small: tuple[bytes, Run], shoe: Shoe, tmp_path_factory: pytest.TempPathFactory
) -> None:
    content, _ = small
    path = tmp_path_factory.getbasetemp() / "cut.mcap"
    path.write_bytes(content[: int(share * len(content))])
    with pytest.raises(DamagedError, match="shoecal recover"):
        read_run(path, shoe)
