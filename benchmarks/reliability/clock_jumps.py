"""The host's clock is set while the driver reads, the calibrator joins and a run is recorded.

One hour forward, one hour back, several jumps of up to an hour one after the other, or (half of all
tries) several of 0.1 to 10 s, at random moments of fifteen seconds, at 20 to 1000 frames a second
that arrive with jitter. The parts that a clock goes through are tried in one process, without
nodes: the driver's mapping of the device's time, the calibrator's joining of frames, and a run's
file. Nothing may raise; frames keep their order; within a stretch between two jumps the stamps
differ as the device's counter does, not as the frames arrived; every frame is joined or counted as
left out, which only those are whose stamps a step back of less than a second puts behind others;
within 2 s of a jump (the worst is reported) they are the host's again. A jump forward of little
more than a tenth of a second may look like frames that are late: stamps keep to the device's time
and follow some seconds later, by the jump and for a while as if the device's clock drifted; how
late is not judged then. A run that was recorded meanwhile is read with its times growing, and says
what was left out.
"""

from __future__ import annotations

import tempfile
from pathlib import Path

import numpy as np

from reliability import originals
from reliability.row import Progress, Result, Row
from reliability.tries import BrokenError, run_tries
from shoecal_core.arrays import IntArray
from shoecal_core.recording import schemas
from shoecal_core.recording.reader import read_run
from shoecal_core.recording.session import Session
from shoecal_ros.common.voltage_frame import VoltageFrame
from shoecal_ros.inputs.joining import FrameJoiner
from shoecal_ros.serial.clock import DeviceClock

FORWARD, BACK, JUMPING, SMALL = "forward", "back", "jumping", "jumping a little"
KINDS = (FORWARD, SMALL, BACK, SMALL, JUMPING, SMALL)
SECONDS = 15.0
HOUR_NS = 3600 * 10**9
MOST_UNTIL_BACK_S = 2.0
JITTER_S = 0.0004
SAME_NS = 2_000_000
"""Two stamps may differ so much from what the device counted between them."""
AT_HOST_NS = 20_000_000
SET_NS = 10**9
"""A step back by more begins a new order; after a smaller one frames are left out."""
LIKE_LATE_NS = 150_000_000
"""A jump forward by less could be frames that are late."""
LED_ON_NS = 150_000_000
"""Where one was taken for that, stamps may be corrected so far, or be led on by so much with the
largest drift that an oscillator may have, before a jump is made out."""


def run(first: int, count: int, seed: int, progress: Progress) -> Result:
    """One stream of frames a try."""
    with tempfile.TemporaryDirectory(prefix="shoecal-clock-") as name:
        session = originals.session(Path(name) / "session")

        def attempt(number: int, rng: np.random.Generator) -> float:
            kind = KINDS[number % len(KINDS)]
            until_s = _try(session, kind, rng)
            if until_s > MOST_UNTIL_BACK_S:
                raise BrokenError(f"{kind}: {until_s:.2f} s until stamps are the host's again")
            return until_s

        words = "{:.2f} s until stamps are the host's again"
        return run_tries(attempt, first, count, seed, progress, words)


def _try(session: Session, kind: str, rng: np.random.Generator) -> float:
    """One stream of frames; how long its stamps were not the host's after a jump [s]."""
    rate = float(rng.choice([20.0, 80.0, 100.0, 1000.0]))
    device_us = np.round(np.arange(0.0, SECONDS, 1.0 / rate) * 1e6).astype(np.int64)
    jump_us, jump_ns = _jumps(kind, rng)
    set_by = jump_ns @ (device_us >= jump_us[:, None])
    host = originals.START_NS + device_us * 1000 + set_by
    received = host + np.round(rng.exponential(JITTER_S, len(host)) * 1e9).astype(np.int64)
    clock = DeviceClock()
    stamps, resets = np.empty_like(host), np.empty_like(host)
    for index, (device, receipt) in enumerate(zip(device_us, received, strict=True)):
        (stamps[index],) = clock.stamps([int(device)], int(receipt))
        resets[index] = clock.resets
    like_late = np.where((jump_ns > 0) & (jump_ns < LIKE_LATE_NS), jump_ns, 0)
    _check_stretches(device_us, stamps, resets, int(like_late.sum()))
    _check_joined(device_us, stamps)
    if rate <= 100.0:
        _check_recorded(session, stamps, received)
    off_us = device_us[np.abs(stamps - host) > AT_HOST_NS]
    ends = [*jump_us[1:], SECONDS * 1e6]
    until_us = [
        int(off - begin)
        for begin, end, late in zip(jump_us, ends, like_late.cumsum(), strict=True)
        for off in off_us[(off_us >= begin) & (off_us < end)]
        if not late
    ]
    return max(until_us, default=0) / 1e6


def _jumps(kind: str, rng: np.random.Generator) -> tuple[IntArray, IntArray]:
    """When by the device's time [us], and by how much [ns]; at least three seconds apart."""
    times = np.arange(2.5, SECONDS - 3.0, 3.0) + rng.uniform(0.0, 0.4)
    if kind == JUMPING:
        steps = rng.uniform(-1.0, 1.0, len(times)) * HOUR_NS
    elif kind == SMALL:  # as often of tenths of seconds as of seconds
        steps = rng.choice([-1e9, 1e9], len(times)) * 10.0 ** rng.uniform(-1.0, 1.0, len(times))
    else:
        times = rng.uniform(3.0, SECONDS - 4.0, 1)
        steps = np.array([HOUR_NS if kind == FORWARD else -HOUR_NS])
    return np.round(times * 1e6).astype(np.int64), np.round(steps).astype(np.int64)


def _check_stretches(
    device_us: IntArray, stamps: IntArray, resets: IntArray, like_late: int
) -> None:
    """Between two beginnings of the mapping time is the device's, but for jumps like delays."""
    slack = SAME_NS + (LED_ON_NS if like_late else 0)
    for reset in np.unique(resets):
        part = resets == reset
        if (np.diff(stamps[part]) <= 0).any():
            raise BrokenError("stamps of one stretch do not grow")
        # The first half second of a mapping knows few delays.
        late = part & (device_us > device_us[part][0] + 500_000)
        if late.any():
            off = stamps[late] - 1000 * device_us[late]
            off -= off[0]
            if off.min() < -slack or off.max() > like_late + slack:
                raise BrokenError(
                    f"stamps run {off.min() / 1e6:.1f} to {off.max() / 1e6:.1f} ms off what the "
                    "device counted"
                )


def _check_joined(device_us: IntArray, stamps: IntArray) -> None:
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
                raise BrokenError("readings of another frame under this stamp")
            seen.append(sequence)
    missing = len(stamps) - len(seen) - joiner.left_out
    if missing:
        raise BrokenError(f"{missing} frames are neither joined nor counted as left out")
    back = -np.diff(stamps)
    most_back_us = back[(back >= 0) & (back < SET_NS)].max(initial=0) / 1000
    gap_us = np.diff(device_us[seen]).max()
    if gap_us > np.diff(device_us).max() + 2 * most_back_us + SAME_NS / 1000:
        raise BrokenError(f"frames of {gap_us / 1e6:.2f} s are left out")


def _check_recorded(session: Session, stamps: IntArray, received: IntArray) -> None:
    """A run of these frames, joint angles stamped by the host."""
    with session.new_run("landmarks", originals.SUPPORT, live=False) as writer:
        for index, (stamp, host) in enumerate(zip(stamps.tolist(), received.tolist(), strict=True)):
            for topic, stamped in ((schemas.VOLTAGES, stamp), (schemas.JOINT_STATES, host)):
                writer.write(topic, originals.sample(index, stamped)[topic], host)
    found = read_run(writer.path, originals.shoe())
    writer.path.unlink()
    indices = found.readings.sequence[:, 0]
    if (np.diff(indices) <= 0).any():
        raise BrokenError("readings of a run are not in their order")
    if not np.array_equal(found.readings.value, [originals.volts(int(one)) for one in indices]):
        raise BrokenError("readings of a run are others than were recorded")
    expected = (stamps[indices] - found.start_ns) / 1e9
    if not np.allclose(found.readings.time, expected, rtol=0.0, atol=1e-6):
        raise BrokenError("readings of a run have other times")
    if len(indices) < len(stamps) and not any("dropped" in note for note in found.notes):
        raise BrokenError("readings were left out and nothing said so")


ROW = Row(
    key="clock-jumps",
    fault="clock one hour forward, back, jumping",
    holds="no crash, order kept, time from the device counter",
    tries=300,
    step=50,
    run=run,
)
