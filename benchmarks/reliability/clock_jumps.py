"""The host's clock is set while the driver reads, the calibrator joins and a run is recorded.

One hour forward, one hour back, several jumps of up to an hour one after the other, or (half of all
tries) several of 0.1 to 10 s, at random moments of fifteen seconds, at 20 to 1000 frames a second
that arrive with jitter. The parts that a clock goes through are tried in one process, without
nodes: the driver's mapping of the device's time, the calibrator's joining of frames, and a run's
file. Nothing may raise; frames keep their order; within a stretch between two jumps the stamps
differ as the device's counter does, not as the frames arrived; every frame is joined or counted as
left out, which only those are whose stamps a step back of less than a second puts behind others;
some time after a jump (the worst is told) they are the host's again. A jump forward of little more
than a tenth of a second may look like frames that are late: stamps keep to the device's time and
follow some seconds later, by the jump and for a while as if the device's clock drifted; how late is
not judged then. A run that was recorded meanwhile is read with its times growing, and says what was
left out.
"""

from __future__ import annotations

import tempfile
from collections.abc import Iterator
from itertools import pairwise
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from reliability import originals
from reliability.row import Progress, Result, Row
from shoecal_core.errors import ShoecalError
from shoecal_core.recording import messages, schemas
from shoecal_core.recording.reader import read_run
from shoecal_core.recording.session import Session
from shoecal_ros.common.conversions import VoltageFrame
from shoecal_ros.inputs.joining import FrameJoiner
from shoecal_ros.serial.clock import DeviceClock

SMALL = "jumping a little"
KINDS = ("an hour forward", SMALL, "an hour back", SMALL, "jumping", SMALL)
SECONDS = 15.0
HOUR_NS = 3600 * 10**9
MOST_UNTIL_BACK_S = 2.0
_JITTER_S = 0.0004
_SAME_NS = 2_000_000
"""Two stamps may differ so much from what the device counted between them."""
_AT_HOST_NS = 20_000_000
_SET_NS = 10**9
"""A step back by more begins a new order; after a smaller one frames are left out."""
_LIKE_LATE_NS = 150_000_000
"""A jump forward by less could be frames that are late."""
_LED_ON_NS = 150_000_000
"""Where one was taken for that, stamps may be corrected so far, or be led on by so much with the
largest drift that an oscillator may have, before a jump is made out."""

Ints = NDArray[np.int64]


class WrongTimeError(Exception):
    """Stamps that are not what they should be."""


def run(first: int, count: int, seed: int, progress: Progress) -> Result:
    failed, worst, longest = 0, "", 0.0
    with tempfile.TemporaryDirectory(prefix="shoecal-clock-") as name:
        session = originals.session(Path(name) / "session")
        for number in range(first, first + count):
            rng = np.random.default_rng([seed, number])
            kind = KINDS[number % len(KINDS)]
            try:
                until = _try(session, kind, rng)
                problem = f"{until:.2f} s until stamps are the host's again"
                bad = until > MOST_UNTIL_BACK_S
            except (WrongTimeError, ShoecalError, ArithmeticError, ValueError) as error:
                problem, bad, until = f"try {number}, {kind}: {error}", True, longest
            if not failed and (bad or until >= longest):
                worst = problem
            failed, longest = failed + bad, max(longest, until)
            progress(number - first + 1)
    return Result(count, failed, worst, longest)


def _try(session: Session, kind: str, rng: np.random.Generator) -> float:
    """One stream of frames; how long its stamps were not the host's after a jump [s]."""
    rate = float(rng.choice([20.0, 80.0, 100.0, 1000.0]))
    device_us = np.round(np.arange(0.0, SECONDS, 1.0 / rate) * 1e6).astype(np.int64)
    jumps = _jumps(kind, rng)
    host = originals.START_NS + device_us * 1000 + _set_by(jumps, device_us)
    received = host + np.round(rng.exponential(_JITTER_S, len(host)) * 1e9).astype(np.int64)
    clock = DeviceClock()
    stamps, resets = [], []
    for device, receipt in zip(device_us.tolist(), received.tolist(), strict=True):
        stamps += clock.stamps([device], receipt)
        resets.append(clock.resets)
    stamped = np.array(stamps, dtype=np.int64)
    _check_stretches(device_us, stamped, np.array(resets), _like_late(jumps))
    _check_joined(device_us, stamped)
    if rate <= 100.0:
        _check_recorded(session, stamped, received)
    return max(
        (
            _until_back(at, device_us, stamped - host, jumps)
            for number, (at, _) in enumerate(jumps)
            if not _like_late(jumps[: number + 1])
        ),
        default=0.0,
    )


def _jumps(kind: str, rng: np.random.Generator) -> list[tuple[float, int]]:
    """When [s], and by how much [ns]; three seconds apart."""
    if "jumping" not in kind:
        sign = 1 if kind.endswith("forward") else -1
        return [(float(rng.uniform(3.0, SECONDS - 4.0)), sign * HOUR_NS)]
    times = np.arange(2.5, SECONDS - 3.0, 3.0) + rng.uniform(0.0, 0.4)
    return [(float(at), _by(kind, rng)) for at in times]


def _by(kind: str, rng: np.random.Generator) -> int:
    """One of several jumps [ns]; small ones are as often of tenths of seconds as of seconds."""
    if kind != SMALL:
        return round(float(rng.uniform(-1.0, 1.0)) * HOUR_NS)
    return round(float(rng.choice([-1.0, 1.0]) * 10.0 ** rng.uniform(-1.0, 1.0)) * 1e9)


def _like_late(jumps: list[tuple[float, int]]) -> int:
    """How much of them could be frames that are late [ns]."""
    return sum(by for _, by in jumps if 0 < by < _LIKE_LATE_NS)


def _set_by(jumps: list[tuple[float, int]], device_us: Ints) -> Ints:
    total = np.zeros(len(device_us), dtype=np.int64)
    for at, by in jumps:
        total[device_us >= at * 1e6] += by
    return total


def _check_stretches(device_us: Ints, stamps: Ints, resets: Ints, like_late: int) -> None:
    """Between two beginnings of the mapping time is the device's, but for jumps like delays."""
    slack = _SAME_NS + (_LED_ON_NS if like_late else 0)
    for reset in np.unique(resets):
        part = resets == reset
        if (np.diff(stamps[part]) <= 0).any():
            raise WrongTimeError("stamps of one stretch do not grow")
        # The first half second of a mapping knows few delays.
        late = device_us[part] > device_us[part][0] + 500_000
        if late.sum() > 1:
            off = stamps[part][late] - 1000 * device_us[part][late]
            off -= off[0]
            if off.min() < -slack or off.max() > like_late + slack:
                raise WrongTimeError(
                    f"stamps run {off.min() / 1e6:.1f} to {off.max() / 1e6:.1f} ms off what the "
                    "device counted"
                )


def _until_back(at: float, device_us: Ints, off_ns: Ints, jumps: list[tuple[float, int]]) -> float:
    """How long after a jump stamps were off the host's clock [s]."""
    following = [other for other, _ in jumps if other > at]
    stop = min([*following, SECONDS])
    part = (device_us >= at * 1e6) & (device_us < stop * 1e6)
    wrong = np.flatnonzero(part & (np.abs(off_ns) > _AT_HOST_NS))
    return 0.0 if not len(wrong) else float(device_us[wrong[-1]] / 1e6 - at)


def _check_joined(device_us: Ints, stamps: Ints) -> None:
    """What the calibrator makes of the frames keeps their order; what is left out is counted."""
    names = originals.shoe().names
    joiner = FrameJoiner(names, 0.03)
    good = np.zeros(len(names), dtype=np.uint8)
    seen = []
    for sequence, stamp in enumerate(stamps.tolist()):
        volts = np.full(len(names), float(sequence))
        joined = joiner.add(VoltageFrame(stamp, "driver", sequence, names, volts, good, 25.0))
        if joined is not None:
            if joined.stamp_ns != stamp or (joined.readings != sequence).any():
                raise WrongTimeError("readings of another frame under this stamp")
            seen.append(sequence)
    if len(seen) + joiner.left_out != len(stamps):
        missing = len(stamps) - len(seen) - joiner.left_out
        raise WrongTimeError(f"{missing} frames are neither joined nor counted as left out")
    back = [one - two for one, two in pairwise(stamps.tolist()) if 0 <= one - two < _SET_NS]
    gap_us = int(np.diff(device_us[seen]).max())
    period_us = int(np.diff(device_us).max())
    if gap_us > period_us + 2 * max(back, default=0) / 1000 + _SAME_NS / 1000:
        raise WrongTimeError(f"frames of {gap_us / 1e6:.2f} s are left out")


def _check_recorded(session: Session, stamps: Ints, received: Ints) -> None:
    """A run of these frames, joint angles stamped by the host."""
    names = originals.shoe().names
    with session.new_run("landmarks", originals.SUPPORT, live=False) as writer:
        for topic, data, log_ns in _messages(stamps, received):
            writer.write(topic, data, log_ns)
    found = read_run(writer.path, originals.shoe())
    writer.path.unlink()
    indices = found.readings.value[:, 0].astype(int)
    if (np.diff(indices) <= 0).any():
        raise WrongTimeError("readings of a run are not in their order")
    expected = (stamps[indices] - found.start_ns) / 1e9
    if not np.allclose(found.readings.time, expected, rtol=0.0, atol=1e-6):
        raise WrongTimeError(f"readings of {len(names)} cells under other times")
    if len(indices) < len(stamps) and not any("dropped" in note for note in found.notes):
        raise WrongTimeError("readings were left out and nothing said so")


def _messages(stamps: Ints, received: Ints) -> Iterator[tuple[str, bytes, int]]:
    names, joints = originals.shoe().names, originals.robot().joint_names
    good = np.zeros(len(names))
    for index, (stamp, log_ns) in enumerate(zip(stamps.tolist(), received.tolist(), strict=True)):
        volts = np.full(len(names), float(index))
        yield schemas.VOLTAGES, messages.shoe_voltages(stamp, index, names, volts, good), log_ns
        yield (
            schemas.JOINT_STATES,
            messages.joint_state(log_ns, joints, np.zeros(len(joints))),
            log_ns,
        )


ROW = Row(
    key="clock-jumps",
    fault="clock one hour forward, back, jumping",
    holds="no crash, order kept, time from the device counter",
    tries=300,
    step=50,
    run=run,
)
