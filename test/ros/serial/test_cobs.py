from __future__ import annotations

from hypothesis import given
from hypothesis import strategies as st

from shoecal_ros.serial.cobs import MAX_PACKET, stuff, unstuff

packets = st.binary(min_size=1, max_size=MAX_PACKET)
mostly_zeros = st.lists(st.sampled_from((0, 1)), min_size=1, max_size=MAX_PACKET).map(bytes)


@given(packets | mostly_zeros)
def test_stuffing_removes_zeros_for_one_byte_and_is_undone(packet: bytes) -> None:
    stuffed = stuff(packet)
    assert 0 not in stuffed
    assert len(stuffed) == len(packet) + 1
    assert unstuff(stuffed) == packet


def test_published_examples() -> None:
    assert stuff(b"\x00") == b"\x01\x01"
    assert stuff(b"\x11\x22\x00\x33") == b"\x03\x11\x22\x02\x33"
    assert stuff(b"\x11\x22\x33\x44") == b"\x05\x11\x22\x33\x44"
    assert stuff(bytes(range(1, 255))) == b"\xff" + bytes(range(1, 255))


@given(st.lists(st.integers(1, 255), max_size=300).map(bytes))
def test_other_bytes_give_nothing_or_the_packet_they_come_from(stuffed: bytes) -> None:
    packet = unstuff(stuffed)
    assert packet is None or stuff(packet) == stuffed
