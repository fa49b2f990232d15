"""Run files (MCAP) that were tampered with, read and recovered.

Mutants of the bytes as they lie there, and of what is inside: records altered, dropped, repeated or
swapped with every length and checksum made right again, messages of wrong content and stamps at
their extremes, chunks that unfold into gigabytes, endless files of zeros. A run is refused with one
line that names the file, or read; where no checksum was forged, what is read is what was recorded,
to the last number. What `shoecal recover` saves of it are values that were recorded.
"""

from __future__ import annotations

import struct
import zlib
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import numpy as np
import zstandard

from reliability import originals
from reliability.byte_mutations import mutate_bytes
from reliability.loading import WrongLoadError, try_mutants
from reliability.row import Row
from shoecal_core.recording import schemas
from shoecal_core.recording.reader import read_run
from shoecal_core.recording.recover import recover
from shoecal_core.recording.run import Run
from shoecal_core.recording.writer import RunWriter

Rng = np.random.Generator
SAMPLES = 60
_MAGIC = b"\x89MCAP0\r\n"
_SCHEMA, _CHANNEL, _MESSAGE, _CHUNK, _INDEX, _DATA_END = 3, 4, 5, 6, 7, 15
_STAMPS = (0, 1, 2**31 * 10**9 - 1, 10**9, originals.START_NS - 3600 * 10**9,
           originals.START_NS + 3600 * 10**9)  # fmt: skip
_HUGE = 3 * 2**30
_CHUNK_HEAD = struct.calcsize("<QQQI") + struct.calcsize("<I4sQ")
"""Bytes before what a chunk holds: times, size, checksum; name of the compression and its size."""


def target(folder: Path) -> RunFile:
    """One run."""
    return RunFile(folder)


class RunFile:
    """A run, a mutant soon."""

    codes = frozenset({"recording", "damaged", "version", "file-too-large"})

    def __init__(self, folder: Path) -> None:
        session = originals.session(folder / "session", runs=1, samples=SAMPLES)
        self._path = session.runs[0].path
        self._info = session.runs[0].info
        self._out, self._made = folder / "recovered.mcap", folder / "made.mcap"
        self._whole = self._path.read_bytes()
        self._forged = self._recovers = False

    def mutate(self, rng: Rng) -> str:
        kind = rng.random()
        self._forged = kind >= 0.45
        if kind < 0.45:
            what, mutant = mutate_bytes(self._whole, rng)
        elif kind < 0.75:
            what, mutant = _of_records(self._whole, rng)
        elif kind < 0.97:
            what, mutant = self._of_messages(rng)
        else:
            what, mutant = _huge(self._whole, rng)
        self._path.write_bytes(mutant)
        if what.startswith("zeros"):
            with self._path.open("r+b") as file:
                file.truncate(_HUGE)
        self._recovers = bool(rng.integers(2))
        return what

    def load(self) -> None:
        """Read it, or recover what is left of it."""
        if self._recovers:
            self._out.unlink(missing_ok=True)
            recover(self._path, self._out)
            self._check(read_run(self._out, originals.shoe()), whole=False)
        else:
            self._check(read_run(self._path, originals.shoe()), whole=True)

    def _check(self, run: Run, *, whole: bool) -> None:
        if self._forged:
            return
        count = len(run.readings.time)
        if whole and (count != SAMPLES or len(run.joints.time) != SAMPLES):
            raise WrongLoadError(f"read {count} of {SAMPLES} readings")
        for time, values, wanted in (
            (run.readings.time, run.readings.value, originals.volts),
            (run.joints.time, run.joints.position, originals.angles),
        ):
            stamps = run.start_ns - originals.START_NS + time * 1e9
            rows = np.rint(stamps / originals.STEP_NS).astype(int)
            expected = np.stack([wanted(int(row)) for row in rows])
            if not np.array_equal(values, expected):
                raise WrongLoadError("a value that was not recorded at its time")

    def _of_messages(self, rng: Rng) -> tuple[str, bytes]:
        """A run of whose messages some are altered before they are written."""
        messages: list[tuple[str, bytes, int]] = []
        for index in range(SAMPLES):
            stamp = originals.START_NS + index * originals.STEP_NS
            wrong = _STAMPS[int(rng.integers(len(_STAMPS)))] if rng.random() < 0.05 else None
            for topic, data in originals.sample(index, wrong).items():
                messages.append((topic, data, stamp))
        done = []
        for _ in range(int(rng.geometric(0.4))):
            at = int(rng.integers(len(messages)))
            topic, data, stamp = messages[at]
            if rng.random() < 0.2:
                topic = str(rng.choice(list(schemas.RUN_TOPICS)))
                what = f"sent on {topic}"
            elif rng.random() < 0.5:
                what, data = _count(data, rng)
            else:
                what, data = mutate_bytes(data, rng)
            messages[at] = (topic, data, stamp)
            done.append(f"{topic}: {what}")
        self._made.unlink(missing_ok=True)
        with RunWriter(self._made, self._info, live=False) as writer:
            for topic, data, stamp in messages:
                writer.write(topic, data, stamp)
        return ", ".join(done)[:200], self._made.read_bytes()


def _count(data: bytes, rng: Rng) -> tuple[str, bytes]:
    """Another count where a message of CDR may have one: every four bytes."""
    at = 4 + 4 * int(rng.integers(max(1, (len(data) - 8) // 4)))
    value = int(rng.choice([0, 1, 2, 2**16, 2**31 - 1, 2**32 - 1, 1000]))
    return f"count {value} at byte {at}", data[:at] + struct.pack("<I", value) + data[at + 4 :]


@dataclass(frozen=True)
class _Record:
    """One record of MCAP: its kind and what is in it."""

    opcode: int
    body: bytes

    @property
    def bytes(self) -> bytes:
        return struct.pack("<BQ", self.opcode, len(self.body)) + self.body


def _records(data: bytes) -> list[_Record]:
    found, at = [], 0
    while at < len(data):
        opcode, length = struct.unpack_from("<BQ", data, at)
        found.append(_Record(opcode, data[at + 9 : at + 9 + length]))
        at += 9 + length
    return found


def _of_records(whole: bytes, rng: Rng) -> tuple[str, bytes]:
    """Records altered, with all lengths and checksums right again."""
    outer = _records(whole[len(_MAGIC) : -len(_MAGIC)])
    chunks = [place for place, record in enumerate(outer) if record.opcode == _CHUNK]
    if chunks and rng.random() < 0.7:
        at = int(rng.choice(chunks))
        start, end, _, _ = struct.unpack_from("<QQQI", outer[at].body)
        unpacker = zstandard.ZstdDecompressor().decompressobj()
        inner = _records(unpacker.decompress(outer[at].body[_CHUNK_HEAD:]))
        what, inner = _altered(inner, rng)
        outer[at] = _chunk(start, end, b"".join(record.bytes for record in inner))
    else:
        what, outer = _altered(outer, rng)
    return what, _sealed(outer)


def _chunk(start: int, end: int, content: bytes, size: int | None = None) -> _Record:
    packed = zstandard.compress(content)
    told = len(content) if size is None else size
    head = struct.pack("<QQQI", start, end, told, zlib.crc32(content))
    return _Record(_CHUNK, head + struct.pack("<I4sQ", 4, b"zstd", len(packed)) + packed)


def _altered(records: list[_Record], rng: Rng) -> tuple[str, list[_Record]]:
    """One record altered, dropped, repeated or elsewhere."""
    changed = list(records)
    at, other = (int(rng.integers(len(records))) for _ in range(2))
    kind, name = int(rng.integers(6)), f"record {records[at].opcode}"
    if kind == 0:
        del changed[at]
        return f"{name} dropped", changed
    if kind == 1:
        times = int(10 ** rng.uniform(0.0, 4.0)) if len(records[at].body) < 200 else 3
        return f"{name} repeated {times} times", changed[:at] + [records[at]] * times + changed[at:]
    if kind == 2:
        changed[at], changed[other] = changed[other], changed[at]
        return f"{name} swapped with {records[other].opcode}", changed
    if kind == 3:
        opcode = int(rng.integers(256))
        changed[at] = _Record(opcode, records[at].body)
        return f"{name} made {opcode}", changed
    what, body = mutate_bytes(records[at].body or b" ", rng)
    changed[at] = _Record(records[at].opcode, body)
    return f"{name}: {what}", changed


def _sealed(outer: list[_Record]) -> bytes:
    """A file of records whose data checksum is right."""
    parts, crc = [_MAGIC], zlib.crc32(_MAGIC)
    for record in outer:
        ends = record.opcode == _DATA_END
        sealed = _Record(_DATA_END, struct.pack("<I", crc)) if ends else record
        parts.append(sealed.bytes)
        crc = zlib.crc32(sealed.bytes, crc)
    return b"".join([*parts, _MAGIC])


def _huge(whole: bytes, rng: Rng) -> tuple[str, bytes]:
    """Little on the disk, much in memory."""
    outer = _records(whole[len(_MAGIC) : -len(_MAGIC)])
    at = next(place for place, record in enumerate(outer) if record.opcode == _CHUNK)
    makers: tuple[tuple[str, Callable[[], bytes]], ...] = (
        ("zeros to 3 GiB", lambda: whole[: int(rng.integers(len(whole)))]),
        ("a chunk of many messages", lambda: _many(outer, at, 2**22, 1)),
        ("many chunks of many messages", lambda: _many(outer, at, 2**17, 40)),
        ("a chunk of zeros", lambda: _with(outer, at, _chunk(0, 1, bytes(2**28)))),
        ("a chunk that tells little", lambda: _with(outer, at, _chunk(0, 1, bytes(2**27), 100))),
        ("a chunk that tells much", lambda: _with(outer, at, _chunk(0, 1, bytes(99), 2**60))),
        ("a chunk without its size", lambda: _with(outer, at, _unsized(2**27))),
    )
    what, make = makers[int(rng.integers(len(makers)))]
    return what, make()


def _with(outer: list[_Record], at: int, *fresh: _Record) -> bytes:
    return _sealed([*outer[:at], *fresh, *outer[at:]])


def _many(outer: list[_Record], at: int, messages: int, chunks: int) -> bytes:
    """Empty messages on the first channel, so many."""
    empty = _Record(_MESSAGE, struct.pack("<HIQQ", 1, 0, 5, 5)).bytes
    fresh = _chunk(5, 5, empty * messages)
    return _sealed([*outer[: at + 1], *[fresh] * chunks, *outer[at + 1 :]])


def _unsized(size: int) -> _Record:
    """A chunk whose compressed content does not say how large it is."""
    packer = zstandard.ZstdCompressor(write_content_size=False)
    packed = packer.compress(bytes(size))
    head = struct.pack("<QQQI", 0, 1, 100, 0)
    return _Record(_CHUNK, head + struct.pack("<I4sQ", 4, b"zstd", len(packed)) + packed)


ROW = Row(
    key="mutants-mcap",
    fault="mutated recording (MCAP), read and recovered",
    holds="refused with one line that names the file, or read as it was recorded; at most 2 GiB "
    "and 10 s of the processor",
    tries=10_000,
    step=500,
    run=partial(try_mutants, "mutated_recordings"),
)
