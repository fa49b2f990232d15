"""Files of every kind, mutated: each is refused with one line that names it, or loads as it says.

The files are those of config/, and a calibration, a session, runs and logs of serial bytes that are
made here. They are mutated as bytes (bits, cuts, pieces repeated or moved, lengths and numbers at
their extremes), as trees (values of another kind, keys gone or renamed, deep nesting) and with
texts that a careless parser would run, fetch or unfold. A load gets 2 GiB and 10 s of the
processor's time, opens no other file and runs nothing.

- Calibration: one that loads, saved and loaded again, is the same.
- Recording: its records are changed too, with checksums made right again, and its chunks unfold
  into gigabytes. Half of the mutants are read, the others recovered first. Where no checksum was
  made right, all that is read was recorded.
- Serial log: binary packets or lines of text. The replay ends, its stamps grow, and every frame of
  the binary protocol was sent (unless its checksum was made right on purpose).
- Session: also files gone, swapped, renamed, or links, folders and pipes in their place. Every run
  that can be read has the readings that were recorded.
- URDF: also entities, and meshes that name other files. The model that loads is finite, and its
  mass is the robot's.
- YAML: robots, shoes, realities and parameters of nodes. Robots and shoes that load are finite.
"""

from __future__ import annotations

import os
import shutil
from collections.abc import Callable, Mapping
from functools import partial
from pathlib import Path
from zlib import crc32

import numpy as np

from reliability import originals
from reliability.loading import Draw, Lay, Load, WrongLoadError, try_mutants
from reliability.mcap_mutations import mutate_records, unfold
from reliability.mutations import Rng, mutate_bytes, mutate_xml, mutate_yaml, pick
from reliability.row import Row
from reliability.same import same
from shoecal_core.calibration.calibration import load_calibration, save_calibration
from shoecal_core.calibration.settings import CalibrationSettings
from shoecal_core.errors import FieldError, FileError
from shoecal_core.model.robot_file import load_robot
from shoecal_core.model.urdf import UrdfError, read_urdf
from shoecal_core.planning.settings import PlannerSettings
from shoecal_core.recording import session as sessions
from shoecal_core.recording.reader import read_run
from shoecal_core.recording.recover import recover
from shoecal_core.recording.run import Run
from shoecal_core.recording.session import Session
from shoecal_core.sensing.shoe import load_shoe
from shoecal_core.settings import Settings, load_settings
from shoecal_core.simulation.reality_file import load_reality
from shoecal_ros.serial.channel_map import Channel, ChannelMap, Converter, Encoding
from shoecal_ros.serial.cobs import stuff, unstuff
from shoecal_ros.serial.config import load_driver_config
from shoecal_ros.serial.driver import ShoeDriver
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

Loader = Callable[[Path], object]
Mutate = Callable[[bytes, Rng, Path], bytes]


def lay_config(loaders: Mapping[str, Loader], mutate: Mutate, folder: Path) -> Draw:
    """Copies of config/ of which one file is a mutant."""
    config = folder / "config"
    shutil.copytree(originals.CONFIG, config)
    for name, load in loaders.items():
        load(config / name)

    def draw(rng: Rng) -> Load:
        for name in loaders:
            shutil.copy(originals.CONFIG / name, config / name)
        path = config / (name := pick(rng, list(loaders)))
        path.write_bytes(mutate(path.read_bytes(), rng, folder))
        return partial(loaders[name], path)

    return draw


def _finite(*numbers: object) -> None:
    if not all(np.isfinite(np.asarray(one, float)).all() for one in numbers):
        raise WrongLoadError("a number that is not finite")


def _robot(path: Path) -> None:
    robot = load_robot(path)
    _finite(robot.mass, robot.mass_std, robot.posture, robot.support_range.step)
    _finite(*(foot.placement.homogeneous for foot in robot.feet))
    _finite(*(end for capsule in robot.capsules for end in (capsule.start, capsule.end)))
    if abs(sum(inertia.mass for inertia in robot.model.inertias) - robot.mass) > 1e-6 * robot.mass:
        raise WrongLoadError(f"the model's masses are not the robot's {robot.mass:g} kg")


def _shoe(path: Path) -> None:
    shoe = load_shoe(path)
    gains = [one.nominal_gain for one in shoe.channels if one.nominal_gain is not None]
    _finite(shoe.columns, shoe.positions, shoe.height, shoe.mass, gains)


def _settings(kind: type[Settings], node: str, section: str, path: Path) -> None:
    load_settings(kind, path, node, section)


def _urdf(path: Path) -> None:
    model = read_urdf(path).model
    _finite(*(inertia.matrix() for inertia in model.inertias))
    _finite(*(placement.homogeneous for placement in model.jointPlacements))
    try:
        _robot(path.with_suffix(".yaml"))
    except (FieldError, UrdfError):
        return  # the robot file names links and joints that have become others


CONFIGURATION: Mapping[str, Loader] = {
    "robots/nao.yaml": _robot,
    "robots/wren.yaml": _robot,
    "shoes/nao_shoe.yaml": _shoe,
    "shoes/wren_shoe.yaml": _shoe,
    "realities/default.yaml": load_reality,
    "nodes/shoe_driver.yaml": load_driver_config,
    "nodes/planner.yaml": partial(_settings, PlannerSettings, "planner", "planning"),
    "nodes/calibrator.yaml": partial(_settings, CalibrationSettings, "calibrator", "calibration"),
}
URDFS: Mapping[str, Loader] = {"robots/nao.urdf": _urdf, "robots/wren.urdf": _urdf}


def lay_calibration(folder: Path) -> Draw:
    """One calibration."""
    path, again = folder / "calibration.yaml", folder / "again.yaml"
    save_calibration(originals.calibration(), path)
    whole = path.read_bytes()

    def load() -> None:
        loaded = load_calibration(path)
        _finite(loaded.parameters.gain, loaded.parameters.offset, loaded.weight)
        save_calibration(loaded, again)
        try:
            reloaded = load_calibration(again)
        except FileError as error:
            raise WrongLoadError(f"saved again it is refused: {error}") from error
        if not same(loaded, reloaded):
            raise WrongLoadError("saved again it is another")

    def draw(rng: Rng) -> Load:
        path.write_bytes(mutate_yaml(whole, rng, folder))
        return load

    load()
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


def lay_recording(folder: Path) -> Draw:
    """One run, read or recovered."""
    path = originals.session(folder / "session", runs=1, samples=SAMPLES).runs[0].path
    recovered, whole = folder / "recovered.mcap", path.read_bytes()

    def read(*, checked: bool) -> None:
        run = read_run(path, originals.shoe())
        if checked:
            if not len(run.readings.time) == len(run.joints.time) == SAMPLES:
                raise WrongLoadError(f"{len(run.readings.time)} of {SAMPLES} readings")
            _check_recorded(run)

    def recover_and_read(*, checked: bool) -> None:
        recovered.unlink(missing_ok=True)
        recover(path, recovered)
        run = read_run(recovered, originals.shoe())
        if checked:
            _check_recorded(run)

    def draw(rng: Rng) -> Load:
        kind = rng.random()
        if kind < 0.47:
            path.write_bytes(mutate_bytes(whole, rng))
        else:
            path.write_bytes((mutate_records if kind < 0.97 else unfold)(whole, rng))
        if kind < 0.005:
            os.truncate(path, 3 * 2**30)  # zeros, none of them on the disk
        return partial(pick(rng, (read, recover_and_read)), checked=kind < 0.47)

    read(checked=True)
    return draw


def lay_session(folder: Path) -> Draw:
    """A session of two runs."""
    whole, path = folder / "whole", folder / "session"
    originals.session(whole, runs=2)

    def load() -> None:
        session = Session.open(path)
        entries = session.runs
        _ = session.missing, session.unfinished
        session.check_hashes()
        for entry in entries:
            _check_recorded(session.read(entry.run))

    def draw(rng: Rng) -> Load:
        shutil.rmtree(path, ignore_errors=True)
        shutil.copytree(whole, path)
        if rng.random() < 0.7:
            file = path / sessions.FILE
            file.write_bytes(mutate_yaml(file.read_bytes(), rng, folder))
        else:
            _rearrange(path, rng)
        return load

    shutil.copytree(whole, path)
    load()
    return draw


def _rearrange(session: Path, rng: Rng) -> None:
    """Do something to one of the session's files."""
    runs = ("run_001.mcap", "run_002.mcap")
    names = (sessions.FILE, sessions.ROBOT, sessions.SHOE, sessions.URDF, *runs)
    file, other = session / pick(rng, names), session / pick(rng, names)
    content, elsewhere = file.read_bytes(), other.read_bytes()
    file.unlink()
    renamed = (
        "run_1.mcap", "run_007.mcap", "run_000.mcap", "run_001.mcap.part", "run_٠٠١.mcap",
        f"run_{'9' * 200}.mcap", "session.yml",
    )  # fmt: skip
    changes: tuple[Callable[[], object], ...] = (
        lambda: None,
        file.touch,
        file.mkdir,
        lambda: os.mkfifo(file),
        lambda: file.symlink_to("nowhere"),
        lambda: file.symlink_to(file.name),
        lambda: file.write_bytes(elsewhere),
        lambda: file.write_bytes(mutate_bytes(content, rng)),
        lambda: (session / pick(rng, renamed)).write_bytes(content),
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
        if kind < 0.6:  # a mutant of a packet, with a right checksum
            content = unstuff(encode_frame(pick(rng, sent))[:-1])
            assert content is not None
            forged = mutate_bytes(content[:-4], rng)[:250]
            packet = stuff(forged + crc32(forged).to_bytes(4, "little")) + b"\0"
            at = int(rng.integers(len(packets)))
            path.write_bytes(b"".join([*packets[:at], packet, *packets[at + 1 :]]))
            return partial(_replay, path, BinaryDecoder())
        path.write_bytes(mutate_bytes(b"".join(packets), rng))
        return partial(_replay, path, BinaryDecoder(), sent)

    path.write_bytes(b"".join(packets))
    _replay(path, BinaryDecoder(), sent)
    return draw


def _frame(index: int) -> Frame:
    counts = tuple((index * 37 + cell * 1000) % 8000 - 4000 for cell in range(CELLS))
    return Frame(
        sequence=index,
        device_time_us=5_000_000 + index * 10_000,
        index=tuple(range(CELLS)),
        status=(0,) * CELLS,
        counts=counts,
        temperature=25.0,
    )


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
    cells = ChannelMap(tuple(Channel(cell, f"cell_{cell}", converter) for cell in range(CELLS)))
    # The clock is far in the future: every frame is due.
    driver = ShoeDriver(ReplaySource(path, decoder, lambda: 2**62, start_ns=10**18), cells)
    last_ns, resets = 0, 0
    try:
        for _ in range(_MOST_READS):
            readings, status = driver.read(0.0), driver.status()
            for reading in readings:
                if status.clock_resets == resets and reading.stamp_ns <= last_ns:
                    raise WrongLoadError(f"stamp {reading.stamp_ns} after {last_ns}")
                last_ns = reading.stamp_ns
                if sent is not None:
                    _check_sent(reading.sequence, np.asarray(reading.cells.voltage), sent)
            resets = status.clock_resets
            if not status.source.connected and not readings:
                return
    finally:
        driver.close()
    raise WrongLoadError(f"not at its end after {_MOST_READS} reads")


def _check_sent(
    sequence: int, volts: np.ndarray[tuple[int], np.dtype[np.float64]], sent: list[Frame]
) -> None:
    wanted = np.array(sent[sequence].counts) * 1e-6 if sequence < len(sent) else None
    if wanted is None or not np.allclose(volts, wanted, rtol=0, atol=1e-12):
        raise WrongLoadError(f"frame {sequence} was not sent like this")


def _row(key: str, fault: str, holds: str, codes: set[str], lay: Lay) -> Row:
    return Row(
        key=f"mutants-{key}",
        fault=f"mutated {fault}",
        holds=f"{holds}; at most 2 GiB and 10 s of the processor",
        tries=10_000,
        step=500,
        run=partial(try_mutants, lay, frozenset(codes)),
    )


_PLAIN = {"file-missing", "file-unreadable", "file-too-large", "file-syntax"}
"""Codes of files of every kind, from the system or the parser."""
_REFUSED = "refused with one line that names the file, or"

ROWS = (
    _row(
        "calibration",
        "calibration",
        f"{_REFUSED} loaded as it says, and nothing of it runs",
        {"file-syntax", "file-too-large", "field", "version", "calibration-file"},
        lay_calibration,
    ),
    _row(
        "mcap",
        "recording (MCAP), read and recovered",
        f"{_REFUSED} read as it was recorded",
        {"recording", "damaged", "version", "file-too-large"},
        lay_recording,
    ),
    _row(
        "serial",
        "log of serial bytes, replayed",
        "replayed to its end without an exception and without a frame that was never sent, or "
        "refused in one line",
        {"replay"},
        lay_serial_log,
    ),
    _row(
        "session",
        "session: session.yaml and the files of the folder",
        f"{_REFUSED} read as it was recorded",
        _PLAIN | {"field", "version", "session", "recording", "damaged", "hash-mismatch"},
        lay_session,
    ),
    _row(
        "urdf",
        "URDF, entities and meshes that name other files among them",
        f"{_REFUSED} a model of finite numbers, and nothing is fetched",
        {"file-syntax", "urdf"},
        partial(lay_config, URDFS, mutate_xml),
    ),
    _row(
        "yaml",
        "YAML: robot, shoe, reality, driver, settings",
        f"{_REFUSED} loaded as it says, and nothing of it runs",
        _PLAIN | {"field", "version", "urdf"},  # a robot file may name another file as its URDF
        partial(lay_config, CONFIGURATION, mutate_yaml),
    ),
)
