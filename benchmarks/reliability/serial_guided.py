"""Bytes on the serial line, guided by the code that they reach.

Inputs are bred: one that makes new pairs of lines of the serial code follow each other is kept, and
mutated further. An input is bytes as they come from the port, or packets that get a right checksum
(firmware gone wrong), or lines of text with or without a time, together with the times at which
they are received. All of it goes the whole way: decoder, device clock, channel map, message, its
bytes, and the joiner of the calibrator. None may raise anything but the typed error that the node
tells; stamps must stay within a minute of the receipt; buffers must stay bounded; a good frame
afterwards must be read.

The guide is a loop of our own on Python's tracing, since it can be repeated from a seed and be
taken up again; every 5,000 inputs it begins anew from the same few seeds. The bytes and the code
are real; there is no port, and the clock is drawn.
"""

from __future__ import annotations

import random
import struct
from functools import partial
from pathlib import Path
from zlib import crc32

import numpy as np
from rclpy.serialization import deserialize_message, serialize_message
from shoecal_msgs.msg import ShoeVoltages

import shoecal_ros.inputs.joining
import shoecal_ros.serial
from reliability.coverage_guided import Corpus, Tracer
from reliability.row import Progress, Result, Row
from reliability.serial_bytes import BrokenError, frame
from reliability.serial_mutated import MUTATIONS
from shoecal_core.errors import ShoecalError
from shoecal_ros.common.conversions import VoltageFrame, voltages_from_ros, voltages_to_ros
from shoecal_ros.inputs.joining import FrameJoiner
from shoecal_ros.serial.channel_map import Channel, ChannelMap, Converter
from shoecal_ros.serial.cobs import MAX_PACKET, stuff, unstuff
from shoecal_ros.serial.decoder import Decoder
from shoecal_ros.serial.driver import ShoeDriver
from shoecal_ros.serial.frame import Frame, Info
from shoecal_ros.serial.protocol import BinaryDecoder, encode_frame, encode_info
from shoecal_ros.serial.source import Received, SourceStatus
from shoecal_ros.serial.text_protocol import MAX_LINE, TextDecoder, TextTime

FILES = (
    *Path(shoecal_ros.serial.__path__[0]).glob("*.py"),
    Path(shoecal_ros.inputs.joining.__file__),
)
CELLS = tuple(f"{foot}/{place}" for foot in ("left", "right") for place in "abcd")
START_NS = 1_780_000_000 * 10**9
FAR_NS = 60 * 10**9
LONGEST = 500
"""An input is cut to so many bytes."""
PROGRESS = 500
TOKENS = (
    b"\0", b"\n", b"\r\n", b"nan", b"-inf", b"1e999", b"9" * 20, b"4294967295", b"=", b",", b" ",
    b"\xff" * 8, b"\x80" + b"\0" * 7, b"\x7f" + b"\xff" * 7, b"\x01\x01", b"\x01\x02",
)  # fmt: skip


class ByteSource:
    """Bytes in pieces, as a port would give them."""

    def __init__(self, decoder: Decoder) -> None:
        self.decoder = decoder
        self.pieces: list[tuple[bytes, int]] = []

    def open(self) -> None:
        """Nothing to do."""

    def close(self) -> None:
        """Nothing to do."""

    def read(self, timeout_s: float) -> list[Received]:  # noqa: ARG002 - as sources are
        """What the next piece completes."""
        data, receive_ns = self.pieces.pop(0)
        return [Received(event, receive_ns) for event in self.decoder.feed(data)]

    def status(self) -> SourceStatus:
        """Of no port."""
        return SourceStatus("bytes", True, 0.0, None, self.decoder.counts, 0, None, None)


def read_input(data: bytes) -> None:
    """Let one input go the whole way.

    Raises:
        BrokenError: when something that must hold does not; whatever else is one, too.
    """
    mode, gap, body = data[0] % 5, data[1] if len(data) > 1 else 0, data[2:]
    decoder: Decoder = BinaryDecoder()
    if mode >= 2:
        time = (TextTime.NONE, TextTime.MILLISECONDS, TextTime.MICROSECONDS)[mode - 2]
        decoder = TextDecoder(time, None if gap % 2 else len(CELLS))
    pieces = _sealed(body) if mode == 1 else _pieces(body)
    good = frame(random.Random(0), 7)
    end = encode_frame(good)
    if mode >= 2:
        numbers = [0 if mode == 2 else 5, *good.counts][1 if mode == 2 else 0 :]
        end = ",".join(map(str, numbers)).encode() + b"\n"
    source = ByteSource(decoder)
    driver = ShoeDriver(source, ChannelMap(_channels()))
    joiner = FrameJoiner(CELLS, 0.03)
    now = START_NS
    for piece in [*pieces, b"\0\n", end]:
        now += gap**3 * 1000
        source.pieces.append((piece, now))
        _pass_on(driver, joiner, now)
        if decoder.pending > (MAX_LINE if mode >= 2 else MAX_PACKET + 1):
            raise BrokenError(f"the decoder holds {decoder.pending} bytes")
    source.pieces.append((end, now))
    last = [one.event for one in source.read(0.0) if isinstance(one.event, Frame)]
    if not last or last[-1].counts != good.counts:
        raise BrokenError("the good frame was not read")


def _pass_on(driver: ShoeDriver, joiner: FrameJoiner, now_ns: int) -> None:
    for reading in driver.read(0.0):
        if abs(reading.stamp_ns - now_ns) > FAR_NS:
            raise BrokenError(f"received at {now_ns} ns, stamped {reading.stamp_ns} ns")
        cells = reading.cells
        message = voltages_to_ros(
            VoltageFrame(
                reading.stamp_ns, "driver", reading.sequence, cells.cell,
                np.array(cells.voltage), np.array(cells.status, dtype=np.uint8),
                reading.temperature,
            )
        )  # fmt: skip
        heard = deserialize_message(serialize_message(message), ShoeVoltages)
        try:
            joiner.add(voltages_from_ros(heard))
        except ShoecalError:
            continue  # The node tells it.
    driver.status()


def _channels() -> list[Channel]:
    return [Channel(index, cell, Converter(5.96e-7, 24)) for index, cell in enumerate(CELLS)]


def _pieces(body: bytes) -> list[bytes]:
    """Cut behind some of the bytes."""
    size = 1 + (len(body) % 97)
    return [body[start : start + size] for start in range(0, len(body), size)]


def _sealed(body: bytes) -> list[bytes]:
    """Packets with a right checksum; their lengths stand in front of them."""
    packets = []
    while body:
        packet, body = body[1 : 1 + body[0] % (MAX_PACKET - 3)], body[1 + body[0] % 251 :]
        packets.append(stuff(packet + struct.pack("<I", crc32(packet))) + b"\0")
    together = b"".join(packets)
    return packets if len(packets) % 2 else [together]


def seeds() -> list[bytes]:
    """One input of each kind."""
    rng = random.Random(0)
    frames = [frame(rng, sequence, 3) for sequence in range(3)]
    wire = b"".join(map(encode_frame, frames)) + encode_info(Info("seed", 1, 8, 100.0))
    packets = [_packet(encode_frame(one)) for one in frames]
    sealed = b"".join(bytes((len(packet),)) + packet for packet in packets)
    lines = b"".join(b"%d,1,-2,fl=3;4 5 6.5,7,8\r\n" % (10 * n) for n in range(4))
    return [
        b"\0\x20" + wire, b"\1\x20" + sealed, b"\2\x20" + lines, b"\3\x21" + lines,
        b"\4\x20" + lines,
    ]  # fmt: skip


def _packet(wire: bytes) -> bytes:
    """What `encode_frame` stuffed, without its checksum."""
    packet = unstuff(wire[:-1])
    assert packet is not None
    return packet[:-4]


def mutate(data: bytes, other: bytes, rng: random.Random) -> bytes:
    """A child: damaged as on the line, or with a token put in."""
    child = bytearray(data)
    for _ in range(rng.choice((1, 1, 2, 4, 8))):
        if child and rng.random() < 0.7:
            rng.choice(MUTATIONS)(child, rng, other)
        else:
            place = rng.randrange(len(child) + 1)
            token = rng.choice(TOKENS)
            child[place : place + rng.choice((0, len(token)))] = token
    return bytes(child[:LONGEST]) or b"\0"


def run(first: int, count: int, seed: int, progress: Progress) -> Result:
    """Inputs of one breeding, drawn from (seed, first)."""
    rng = random.Random(seed * 2**40 + first)
    corpus = Corpus(seeds(), mutate, rng)
    failed, told = 0, ""
    for turn in range(count):
        data = corpus.draw(turn)
        tracer = Tracer(FILES)
        try:
            tracer.trace(partial(read_input, data))
        except Exception as error:  # noqa: BLE001 - any exception is what is looked for
            failed, told = failed + 1, told or f"{error!r} by {data.hex()}"
        corpus.learn(data, tracer.edges)
        if turn % PROGRESS == 0:
            progress(turn)
    reached = f"{len(corpus.edges)} pairs of lines reached by {len(corpus.inputs)} inputs kept"
    return Result(count, failed, told or reached, -float(len(corpus.edges)))


ROW = Row(
    key="serial-guided",
    fault="serial bytes bred for the code they reach",
    holds="only typed errors, sane stamps, bounded buffers, the next good frame is read",
    tries=200_000,
    step=5_000,
    run=run,
)
