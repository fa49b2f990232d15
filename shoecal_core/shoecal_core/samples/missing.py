"""What a session lacks, and whether its clocks agree, before anything is fitted to it."""

from __future__ import annotations

import numpy as np

from shoecal_core.errors import ShoecalError
from shoecal_core.recording.errors import RecordingError
from shoecal_core.recording.run import Run
from shoecal_core.robot.double_support import count_distinct
from shoecal_core.samples.samples import Samples

FAR_S = 1.0
"""What was recorded together starts and ends within this of each other."""
ALIKE = 0.5
"""A shift is as long at both ends, to within this share of it; what broke off is not."""


def check_clocks(run: Run) -> None:
    """Refuse a run whose joints and readings both start and end apart, by about the same time.

    Smaller differences are what the effect `latency` is looked for by.

    Raises:
        RecordingError: the stamps are of two clocks.
    """
    first = float(run.joints.time[0] - run.readings.time[0])
    last = float(run.joints.time[-1] - run.readings.time[-1])
    shift = 0.5 * (first + last)
    if abs(shift) > FAR_S and abs(first - last) < ALIKE * abs(shift):
        raise RecordingError(
            run.path,
            f"the stamps of joints and readings are {abs(shift):.1f} s apart, so none of them "
            "belong together; set both devices' clocks and record it again",
        )


MOVES_M = 0.003
"""Way of the CoM below which a robot stands still; encoders' steps make less."""
UNSURE_MASS = 0.02
"""Standard uncertainty of the robot's mass, over the mass, from which it is reported."""


def missing(samples: Samples) -> list[str]:
    """What is not there, and what it costs.

    Raises:
        ShoecalError: when nothing is identifiable in what is there.
    """
    robot, tracks = samples.robot, samples.tracks
    notes = []
    if walking := [str(track.run) for track in tracks if track.walks]:
        notes.append(
            f"runs {', '.join(walking)} walk: CoP and GRF are compared with the zero-moment point "
            "of joints and base pose, in single and double supports of flat, still feet"
        )
    if robot.mass_std > UNSURE_MASS * robot.mass:
        notes.append(
            f"the robot's weight is known to {robot.mass_std / robot.mass:.0%} only, and a wrong "
            "one looks exactly like a common error of all gains: put it on a scale"
        )
    if any(track.up is None for track in tracks):
        notes.append("no /imu in every run: a tilt of the floor is only seen by the CoP")
    if all(track.temperature is None for track in tracks):
        notes.append("no temperature: only drifts over time are looked for")
    if samples.efforts is None:
        notes.append("no joint efforts in every run: loads sideways on cells are not looked for")
    if samples.loaded.all():
        notes.append("no foot is ever in the air: how the feet share the load is weakly fixed")
    moved = max(float(np.ptp(track.mean(track.com)[..., :2], axis=0).max()) for track in tracks)
    if moved < MOVES_M:
        raise ShoecalError(
            f"the CoM moves by {1e3 * moved:.1f} mm at most, so nothing is identifiable: "
            "record runs in which the robot moves"
        )
    if len(tracks) < 2:
        raise ShoecalError(
            "in one run alone gaps and parameters cannot be separated: record at least two double "
            "supports"
        )
    stances = list(zip(samples.supports, samples.standing, strict=True))
    lifted = {feet for _, feet in stances if not all(feet)}
    if count_distinct(support for support, feet in stances if all(feet)) < 2 and len(lifted) < 2:
        raise ShoecalError(
            "all runs stand in one double support, where gaps and parameters cannot be separated: "
            "record at least two that differ in yaw, or lift each foot once"
        )
    return notes
