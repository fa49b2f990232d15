"""Logs of raw serial bytes that were tampered with, then replayed by the driver.

Logs of the binary protocol and of text lines. Whatever stands in one, the driver replays it to its
end without an exception, or says in one line why it cannot be replayed. Every frame of the binary
protocol that it gives is one that was sent (mutants with a right checksum aside, which are made on
purpose); the stamps of its readings grow; buffers stay bounded.
"""

from __future__ import annotations

from functools import partial
from pathlib import Path
from zlib import crc32

import numpy as np

from reliability.byte_mutations import NUMBERS, mutate_bytes, pick
from reliability.loading import WrongLoadError, try_mutants
from reliability.row import Row
from shoecal_ros.serial.channel_map import Channel, ChannelMap, Converter, Encoding
from shoecal_ros.serial.cobs import stuff, unstuff
from shoecal_ros.serial.driver import ShoeDriver
from shoecal_ros.serial.frame import Frame, Info
from shoecal_ros.serial.protocol import BinaryDecoder, encode_frame, encode_info
from shoecal_ros.serial.replay import ReplaySource
from shoecal_ros.serial.text_protocol import TextDecoder, TextTime

Rng = np.random.Generator
FRAMES = 150
CELLS = 4
_READS = 100_000
"""No log of this size gives more readings."""


def target(folder: Path) -> SerialLog:
    """One log."""
    return SerialLog(folder)


class SerialLog:
    """A log of bytes, binary or text."""

    codes = frozenset({"replay"})

    def __init__(self, folder: Path) -> None:
        self._path = folder / "raw.log"
        self._sent = {frame.sequence: frame for frame in map(_frame, range(FRAMES))}
        packets = [encode_info(Info("test 1.0", 1, CELLS, 100.0))]
        packets += [encode_frame(frame) for frame in self._sent.values()]
        self._packets = packets
        self._lines = [_line(frame) for frame in self._sent.values()]
        self._text, self._forged = False, False
        self._path.write_bytes(b"".join(packets))

    def mutate(self, rng: Rng) -> str:
        self._text, self._forged = rng.random() < 0.4, False
        if self._text:
            what, mutant = self._text_mutant(rng)
        elif rng.random() < 0.35:
            self._forged = True
            what, mutant = "packet with a right checksum", self._forgery(rng)
        else:
            what, mutant = mutate_bytes(b"".join(self._packets), rng)
        self._path.write_bytes(mutant)
        return f"{'text' if self._text else 'binary'}: {what}"

    def load(self) -> None:
        converter = Converter(1e-6, 24, Encoding.SIGNED)
        cells = ChannelMap(tuple(Channel(i, f"cell_{i}", converter) for i in range(CELLS)))
        decoder = TextDecoder(TextTime.MICROSECONDS, CELLS) if self._text else BinaryDecoder()
        # A clock at the end of all times: every frame is due.
        source = ReplaySource(self._path, decoder, lambda: 2**62, start_ns=10**18)
        driver = ShoeDriver(source, cells)
        try:
            self._replay(driver)
        finally:
            driver.close()

    def _replay(self, driver: ShoeDriver) -> None:
        last_ns, resets = 0, 0
        for _ in range(_READS):
            readings = driver.read(0.0)
            status = driver.status()
            for reading in readings:
                if status.clock_resets == resets and reading.stamp_ns <= last_ns:
                    raise WrongLoadError(f"stamp {reading.stamp_ns} after {last_ns}")
                last_ns = reading.stamp_ns
                if not (self._text or self._forged):
                    self._check(reading.sequence, reading.cells.voltage)
            resets = status.clock_resets
            if not status.source.connected and not readings:
                return
        raise WrongLoadError(f"not at its end after {_READS} reads")

    def _check(self, sequence: int, volts: object) -> None:
        sent = self._sent.get(sequence)
        wanted = None if sent is None else np.array(sent.counts) * 1e-6
        if wanted is None or not np.allclose(np.asarray(volts), wanted, rtol=0, atol=1e-12):
            raise WrongLoadError(f"frame {sequence} was never sent so")

    def _forgery(self, rng: Rng) -> bytes:
        packets = list(self._packets)
        packet = bytearray(mutate_bytes(_unsealed(_frame(int(rng.integers(FRAMES)))), rng)[1])
        sealed = stuff(bytes(packet[:250]) + crc32(packet[:250]).to_bytes(4, "little")) + b"\0"
        packets[int(rng.integers(len(packets)))] = sealed
        return b"".join(packets)

    def _text_mutant(self, rng: Rng) -> tuple[str, bytes]:
        if rng.random() < 0.5:
            return mutate_bytes("".join(self._lines).encode(), rng)
        lines = list(self._lines)
        words = lines[at := int(rng.integers(len(lines)))].split(",")
        words[int(rng.integers(len(words)))] = pick(rng, NUMBERS)
        lines[at] = ",".join(words) + "\n"
        return f"{lines[at][:30]!r}", "".join(lines).encode()


def _frame(index: int) -> Frame:
    counts = tuple(float((index * 37 + cell * 1000) % 8000 - 4000) for cell in range(CELLS))
    return Frame(
        sequence=index,
        device_time_us=5_000_000 + index * 10_000,
        index=tuple(range(CELLS)),
        status=(0,) * CELLS,
        counts=tuple(map(int, counts)),
        temperature=25.0,
    )


def _line(frame: Frame) -> str:
    return ",".join(map(str, (frame.device_time_us, *map(int, frame.counts)))) + "\n"


def _unsealed(frame: Frame) -> bytes:
    packet = unstuff(encode_frame(frame)[:-1])
    assert packet is not None
    return packet[:-4]


ROW = Row(
    key="mutants-serial",
    fault="mutated log of serial bytes, replayed",
    holds="replayed to its end without an exception and without a frame that was never sent, or "
    "refused in one line; at most 2 GiB and 10 s of the processor",
    tries=10_000,
    step=1_000,
    run=partial(try_mutants, "mutated_serial_logs"),
)
