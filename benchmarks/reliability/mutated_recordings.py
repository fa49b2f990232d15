"""Mutants of recorded runs, of sessions and of logs of serial bytes."""

from __future__ import annotations

import os
import shutil
from collections.abc import Callable
from functools import partial
from pathlib import Path
from zlib import crc32

import numpy as np

from reliability import originals
from reliability.loading import Draw, Load, WrongLoadError
from reliability.mcap_mutations import mutate_records, unfold
from reliability.mutations import Rng, mutate_bytes, mutate_yaml, pick
from shoecal_core.recording import session as sessions
from shoecal_core.recording.reader import read_run
from shoecal_core.recording.recover import recover
from shoecal_core.recording.run import Run
from shoecal_core.recording.session import Session
from shoecal_ros.serial.channel_map import ChannelMap, Converter, DeviceChannel, Encoding
from shoecal_ros.serial.cobs import stuff, unstuff
from shoecal_ros.serial.driver import SerialDriver
from shoecal_ros.serial.frame import Frame, Info
from shoecal_ros.serial.protocol import BinaryDecoder, encode_frame, encode_info
from shoecal_ros.serial.replay import ReplaySource
from shoecal_ros.serial.text_protocol import TextDecoder, TextTime

SAMPLES = 60
"""Of a run."""
FRAMES, CELLS = 150, 4
"""Of a serial log."""
_MOST_READS = 100_000
"""More than any log of this size gives."""
_RENAMED = (
    "run_1.mcap", "run_007.mcap", "run_000.mcap", "run_001.mcap.part", "run_٠٠١.mcap",
    f"run_{'9' * 200}.mcap", "session.yml",
)  # fmt: skip


def lay_run(folder: Path) -> Draw:
    """One run, read or recovered."""
    path = originals.session(folder / "session", runs=1, samples=SAMPLES).runs[0].path
    recovered, whole = folder / "recovered.mcap", path.read_bytes()

    def load(*, recovers: bool, forged: bool) -> None:
        if recovers:
            recovered.unlink(missing_ok=True)
            recover(path, recovered)
        run = read_run(recovered if recovers else path, originals.shoe())
        if forged:
            return
        if not (recovers or len(run.readings.time) == len(run.joints.time) == SAMPLES):
            raise WrongLoadError(f"{len(run.readings.time)} of {SAMPLES} readings")
        _check_recorded(run)

    def draw(rng: Rng) -> Load:
        kind = rng.random()
        forged = kind < 0.5
        if kind < 0.47:
            path.write_bytes(mutate_records(whole, rng))
        elif forged:
            path.write_bytes(unfold(whole, rng))
        else:
            path.write_bytes(mutate_bytes(whole, rng))
        if kind > 0.995:
            os.truncate(path, 3 * 2**30)  # zeros that take no room on the disk
        return partial(load, recovers=bool(rng.integers(2)), forged=forged)

    load(recovers=False, forged=False)
    return draw


def _check_recorded(run: Run) -> None:
    """Check that every value of a run was recorded at its time."""
    for time, values, wanted in (
        (run.readings.time, run.readings.value, originals.volts),
        (run.joints.time, run.joints.position, originals.angles),
    ):
        stamps = run.start_ns - originals.START_NS + time * 1e9
        indices = np.rint(stamps / originals.STEP_NS).astype(int)
        if not np.array_equal(values, np.stack([wanted(int(index)) for index in indices])):
            raise WrongLoadError("a value that was not recorded at its time")


def lay_session(folder: Path) -> Draw:
    """A session of two runs, of which all is read."""
    whole, path = folder / "whole", folder / "session"
    originals.session(whole, runs=2)
    shutil.copytree(whole, path)

    def load() -> None:
        session = Session.open(path)
        entries = session.runs
        _ = session.missing, session.unfinished
        for entry in entries:
            _check_recorded(session.read(entry.run))

    def draw(rng: Rng) -> Load:
        shutil.rmtree(path)
        shutil.copytree(whole, path)
        if rng.random() < 0.7:
            file = path / sessions.FILE
            file.write_bytes(mutate_yaml(file.read_bytes(), rng, folder))
        else:
            _rearrange(path, rng)
        return load

    load()
    return draw


def _rearrange(session: Path, rng: Rng) -> None:
    """Put something else in the place of one of the session's files, or nothing."""
    runs = ("run_001.mcap", "run_002.mcap")
    names = (sessions.FILE, sessions.ROBOT, sessions.SHOE, sessions.URDF, *runs)
    file, other = session / pick(rng, names), session / pick(rng, names)
    content, elsewhere = file.read_bytes(), other.read_bytes()
    file.unlink()
    changes: tuple[Callable[[], object], ...] = (
        lambda: None,
        file.touch,
        file.mkdir,
        lambda: os.mkfifo(file),
        lambda: file.symlink_to("nowhere"),
        lambda: file.symlink_to(file.name),
        lambda: file.write_bytes(elsewhere),
        lambda: file.write_bytes(mutate_bytes(content, rng)),
        lambda: (session / pick(rng, _RENAMED)).write_bytes(content),
    )
    pick(rng, changes)()


def lay_serial_log(folder: Path) -> Draw:
    """A log of raw bytes, binary or text, replayed by the driver."""
    path = folder / "raw.log"
    sent = [_frame(index) for index in range(FRAMES)]
    packets = [encode_info(Info("test 1.0", 1, CELLS, 100.0)), *map(encode_frame, sent)]
    lines = [",".join(map(str, (one.device_time_us, *one.counts))) + "\n" for one in sent]

    def draw(rng: Rng) -> Load:
        kind = rng.random()
        if kind < 0.4:
            path.write_bytes(mutate_bytes("".join(lines).encode(), rng))
            return partial(_replay, path, TextDecoder(TextTime.MICROSECONDS, CELLS))
        if kind < 0.6:
            at = int(rng.integers(len(packets)))
            forged = _forge(pick(rng, sent), rng)
            path.write_bytes(b"".join([*packets[:at], forged, *packets[at + 1 :]]))
            return partial(_replay, path, BinaryDecoder())
        path.write_bytes(mutate_bytes(b"".join(packets), rng))
        return partial(_replay, path, BinaryDecoder(), sent)

    path.write_bytes(b"".join(packets))
    _replay(path, BinaryDecoder(), sent)
    return draw


def _frame(index: int) -> Frame:
    return Frame(
        sequence=index,
        device_time_us=5_000_000 + index * 10_000,
        index=tuple(range(CELLS)),
        status=(0,) * CELLS,
        counts=tuple((index * 37 + cell * 1000) % 8000 - 4000 for cell in range(CELLS)),
        temperature=25.0,
    )


def _forge(frame: Frame, rng: Rng) -> bytes:
    """A mutant of a packet whose checksum is right."""
    content = unstuff(encode_frame(frame)[:-1])
    assert content is not None
    forged = mutate_bytes(content[:-4], rng)[:250]
    return stuff(forged + crc32(forged).to_bytes(4, "little")) + b"\0"


def _replay(
    path: Path, decoder: BinaryDecoder | TextDecoder, sent: list[Frame] | None = None
) -> None:
    """Replay a log to its end.

    Args:
        path: of the log.
        decoder: of its protocol.
        sent: the frames that may appear; None where any may.
    """
    converter = Converter(1e-6, 24, Encoding.SIGNED)
    cells = ChannelMap(
        tuple(DeviceChannel(cell, f"cell_{cell}", converter) for cell in range(CELLS))
    )
    # The clock is far in the future: every frame is due.
    driver = SerialDriver(ReplaySource(path, decoder, lambda: 2**62, start_ns=10**18), cells)
    last_ns, resets = 0, 0
    try:
        for _ in range(_MOST_READS):
            readings, status = driver.read(0.0), driver.status()
            for reading in readings:
                if status.clock_resets == resets and reading.stamp_ns <= last_ns:
                    raise WrongLoadError(f"stamp {reading.stamp_ns} after {last_ns}")
                last_ns, at = reading.stamp_ns, reading.sequence
                if sent is not None:
                    counts = np.array(sent[at].counts if at < len(sent) else np.nan)
                    if not np.allclose(reading.cells.voltage, counts * 1e-6, rtol=0, atol=1e-12):
                        raise WrongLoadError(f"frame {at} was not sent like this")
            resets = status.clock_resets
            if not status.source.connected and not readings:
                return
    finally:
        driver.close()
    raise WrongLoadError(f"not at its end after {_MOST_READS} reads")
