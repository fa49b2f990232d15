"""Whether the errors that `/shoe/forces` states hold: sessions replayed through the live path.

    .venv/bin/python benchmarks/live_error.py SESSION... [--jobs 2]

Each simulated session is calibrated by default, its calibration written and read again, and every
so many samples of its test runs go through what the calibrator node calls. Prints the RMS of true
error over stated standard deviation, live and by the fit itself, and the time of a message.
"""

from __future__ import annotations

import argparse
import json
import tempfile
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from shoecal_msgs.msg import FootForce, ShoeForces

from held import COPS, STEP, Held, hold
from shoecal_core.arrays import FloatArray
from shoecal_core.error_sources.tolerances import Tolerances
from shoecal_core.estimation.calibration import Calibration, load_calibration, save_calibration
from shoecal_core.estimation.outcome import CalibrationOutcome
from shoecal_core.estimation.series import truth_series
from shoecal_core.estimation.session_data import load_data
from shoecal_core.recording.session import Session
from shoecal_core.recording.truth import read_truth
from shoecal_core.robot.kinematics import BodyStates
from shoecal_core.robot.robot import Robot
from shoecal_core.samples.stance import Stance
from shoecal_core.screening.settings import CalibrationSettings
from shoecal_core.shoe.shoe import Shoe
from shoecal_core.workflows.calibrate import calibrate_session
from shoecal_core.workflows.many_jobs import over_cores
from shoecal_ros.calibrator.force_samples import STANCE, ForceSamples
from shoecal_ros.calibrator.live import FootFlags, Live, LiveSensing, OutputFilter
from shoecal_ros.calibrator.load import LoadSwitch
from shoecal_ros.inputs.joining import Joined
from true_sources import read_drawn

GRF = "GRF"
WHAT = (GRF, *COPS)
SOLES = ("l_sole", "r_sole")
LOAD_ON_N, LOAD_OFF_N = 6.0, 3.0
FINE = FootFlags(loaded=True, valid=True, stale=False, extrapolating=False, status=())
Maker = Callable[[Calibration, Robot, Shoe], ForceSamples]


@dataclass(frozen=True)
class LiveHeld:
    """One session.

    Attributes:
        live: by quantity, errors over stated standard deviations of the messages.
        offline: the same by the fit.
        grf_bias: mean error of the GRF [N].
        message_us: median time of a message.
    """

    live: dict[str, FloatArray]
    offline: Held
    grf_bias: float
    message_us: float


@dataclass(frozen=True)
class Instant:
    """What one message is made from."""

    live: Live
    states: BodyStates


def forces(calibration: Calibration, robot: Robot, shoe: Shoe) -> ForceSamples:
    """As the node makes them."""
    return ForceSamples(calibration, robot, shoe, Tolerances(), SOLES, STANCE)


def measure(folder: Path) -> LiveHeld:
    """Calibrate a session and replay its test runs."""
    session = Session.open(folder)
    train = tuple(entry.run for entry in session.runs if entry.hint == "train")
    test = tuple(entry.run for entry in session.runs if entry.run not in train)
    outcome = calibrate_session(session, train, test)
    drawn = read_drawn(session)
    gain = np.array([drawn["gain"][name] for name in outcome.calibration.channels])
    live, grf_bias, message_us = replay(session, outcome, forces)
    return LiveHeld(live, hold(session, outcome, gain), grf_bias, message_us)


def replay(
    session: Session, outcome: CalibrationOutcome, maker: Maker
) -> tuple[dict[str, FloatArray], float, float]:
    """Ratios by quantity, mean error of the GRF [N] and median time of a message [us]."""
    with tempfile.TemporaryDirectory() as scratch:
        file = Path(scratch) / "calibration.yaml"
        save_calibration(outcome.calibration, file)
        calibration = load_calibration(file)
    data = load_data(session, outcome.test, CalibrationSettings())
    made = maker(calibration, data.robot, data.shoe)
    silent = np.zeros(len(data.shoe.names))
    ratios: dict[str, list[float]] = {name: [] for name in WHAT}
    off, times = [], []
    for stance in data.of(outcome.test):
        few = stance.part(slice(None, None, STEP))
        truth = read_truth(session.truth_path(stance.run), data.runs[stance.run].start_ns)
        true = truth_series(truth, few)
        for index, one in enumerate(instants(calibration, data.shoe, few, data.kinematics.states)):
            begin = time.perf_counter()
            message = made.message(one.live, (FINE, FINE), one.states, silent)
            times.append(time.perf_counter() - begin)
            off.append(message.both.wrench.force.z - true.grf[index])
            ratios[GRF].append(off[-1] / np.sqrt(message.both.covariance[0]))
            places = (true.cop[index], *true.foot_cop[index])
            for name, foot, place in zip(COPS, feet(message), places, strict=True):
                ratios[name] += over_stated(foot, place)
    found = {name: np.array(values) for name, values in ratios.items()}
    finite = {name: values[np.isfinite(values)] for name, values in found.items()}
    return finite, float(np.nanmean(off)), 1e6 * float(np.median(times))


def instants(
    calibration: Calibration,
    shoe: Shoe,
    stance: Stance,
    states: Callable[[FloatArray], BodyStates],
) -> list[Instant]:
    """Samples of a stance as the node has them."""
    assert stance.angles is not None
    sensing = LiveSensing(
        [shoe.of_foot(0), shoe.of_foot(1)], LoadSwitch(LOAD_ON_N, LOAD_OFF_N), OutputFilter(0.0)
    )
    sensing.sensing = calibration.sensing(shoe)
    good = np.zeros(len(shoe.names), dtype=np.uint8)
    new = np.ones(len(shoe.names), dtype=bool)
    found = []
    for index, readings in enumerate(stance.readings):
        body = states(stance.angles[index : index + 1])
        joined = Joined(round(1e9 * float(stance.time[index])), readings, good, new)
        (live,) = sensing.take([joined], body.support())
        found.append(Instant(live, body))
    return found


def feet(message: ShoeForces) -> tuple[FootForce, FootForce, FootForce]:
    """In the order of COPS."""
    return message.both, message.left, message.right


def over_stated(foot: FootForce, place: FloatArray) -> list[float]:
    """Errors of the CoP along x and y over their standard deviations."""
    spread = np.array(foot.cop_covariance)[[0, 3]]
    error = np.array([foot.cop.x, foot.cop.y]) - place
    return [float(one) for one in error / np.sqrt(spread)]


def rms(ratios: FloatArray) -> float:
    """Root mean square; NaN of nothing."""
    return float(np.sqrt(np.mean(ratios**2))) if ratios.size else float("nan")


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("sessions", nargs="+", type=Path)
    parser.add_argument("--jobs", type=int, default=2, help="processes at a time")
    args = parser.parse_args()
    done = []
    for number, one in over_cores(measure, args.sessions, args.jobs):
        done.append(one)
        row = {name: [rms(one.live[name]), rms(one.offline.ratios[name])] for name in WHAT}
        print(
            args.sessions[number].name,
            json.dumps({name: [round(value, 2) for value in pair] for name, pair in row.items()}),
            f"GRF off by {one.grf_bias:+.2f} N on average, message {one.message_us:.0f} us",
            flush=True,
        )
    for name in WHAT:
        live, offline = (
            float(np.sqrt(np.mean([rms(ratios[name]) ** 2 for ratios in side])))
            for side in ([one.live for one in done], [one.offline.ratios for one in done])
        )
        print(f"{name}: RMS of error over stated, live {live:.2f}, offline {offline:.2f}")


if __name__ == "__main__":
    main()
