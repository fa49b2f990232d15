from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from rosbags.typesys.stores import ros2_jazzy as ros

from shoecal_core.errors import ShoecalError
from shoecal_core.recording import messages, schemas
from shoecal_core.recording.columns import decode_columns

JOINT_STATE = "sensor_msgs/msg/JointState"

# What rclpy 7.1 made of names (ab, cde), positions (1, 2), velocities, efforts (3, 4): padding
# of any content within, and without velocities eight bytes of it behind.
FROM_RCLPY = {
    0: "000100000500000007000000020000006200ab01020000000300000061620003040000006364650002000000"
    "000000000000f03f00000000000000400000000002000000000000000000084000000000000010407700770078"
    "035900",
    2: "0001000005000000070000000200000062001603020000000300000061620000040000006364650002000000"
    "000000000000f03f000000000000004002000000a0da1603000000000000f03f000000000000004002000000f0"
    "12e80300000000000008400000000000001040",
}


@pytest.mark.parametrize("velocities", FROM_RCLPY)
def test_bytes_of_the_real_serialiser(velocities: int) -> None:
    (block,) = decode_columns(JOINT_STATE, [bytes.fromhex(FROM_RCLPY[velocities])])
    assert block.texts == {"header.frame_id": ("b",), "name": ("ab", "cde")}
    assert block.stamp_ns.tolist() == [5_000_000_007]
    assert block.numbers["position"].tolist() == [[1.0, 2.0]]
    assert block.numbers["velocity"].shape == (1, velocities)
    assert block.numbers["effort"].tolist() == [[3.0, 4.0]]


def test_padding_of_any_content_keeps_one_layout() -> None:
    data = bytearray(messages.joint_state(1, ("ab", "cde"), [1, 2]))
    other = bytearray(data)
    other[4 + 8 + 4 + 1] = 0xAB  # behind the empty frame_id
    assert len(decode_columns(JOINT_STATE, [bytes(data), bytes(other)])) == 1


joint_states = st.lists(
    st.tuples(
        st.integers(0, 2**40),
        st.lists(st.sampled_from(("a", "knee", "é")), max_size=3),
        st.booleans(),
    ),
    max_size=12,
)


@given(joint_states, st.booleans())
def test_agrees_with_decoding_one_by_one(
    drawn: list[tuple[int, list[str], bool]], little: bool
) -> None:
    store = schemas.typestore()
    data = []
    for stamp, names, effort in drawn:
        values = np.arange(len(names)) + stamp * 1e-3
        message = messages.joint_state(stamp, names, values, values if effort else None)
        again = store.deserialize_cdr(message, JOINT_STATE)
        data.append(bytes(store.serialize_cdr(again, JOINT_STATE, little_endian=little)))
    seen: list[int] = []
    for block in decode_columns(JOINT_STATE, data):
        assert np.all(np.diff(block.index) > 0)
        seen += block.index.tolist()
        for row, place in enumerate(block.index):
            one = store.deserialize_cdr(data[place], JOINT_STATE)
            assert isinstance(one, ros.sensor_msgs__msg__JointState)
            assert block.texts["name"] == tuple(one.name)
            assert block.stamp_ns[row] == one.header.stamp.sec * 10**9 + one.header.stamp.nanosec
            np.testing.assert_array_equal(block.numbers["position"][row], one.position)
            np.testing.assert_array_equal(block.numbers["effort"][row], one.effort)
    assert sorted(seen) == list(range(len(data)))


@given(st.lists(st.binary(max_size=90).map(lambda tail: b"\x00\x01\x00\x00" + tail), max_size=4))
def test_bytes_of_anything_else_are_refused_or_bounded(data: list[bytes]) -> None:
    try:
        blocks = decode_columns(schemas.SHOE_VOLTAGES_TYPE, data)
    except ShoecalError:
        return
    assert sum(len(block.index) for block in blocks) == len(data)


@pytest.mark.parametrize("data", [b"", b"\x00\x01", b"\x00\x03\x00\x00" + bytes(60)])
def test_no_cdr_is_refused(data: bytes) -> None:
    with pytest.raises(ShoecalError, match="JointState"):
        decode_columns(JOINT_STATE, [data])


def test_a_count_gone_wrong_does_not_run_for_ever() -> None:
    data = bytearray(messages.joint_state(1, ("a",), [1.0]))
    data[20:24] = b"\xff\xff\xff\xff"
    with pytest.raises(ShoecalError, match="ends at byte"):
        decode_columns(JOINT_STATE, [bytes(data)])
