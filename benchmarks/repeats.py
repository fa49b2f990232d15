"""How far one robot's gains differ when it calibrates itself again in other double supports.

    .venv/bin/python benchmarks/repeats.py [--repeats 10] [--robot 1]

Writes a table of docs/evidence/trust.md and the key `repeats` of out/bench.json.
"""

from __future__ import annotations

import argparse
import os
from collections.abc import Sequence
from concurrent.futures import ProcessPoolExecutor

import numpy as np

from pages import TRUST, Row, markdown, record, write_section
from population import Member, one_robot, sessions
from shoecal_core.arrays import FloatArray
from shoecal_core.estimation.uncertainty.assessment import NORMAL_95
from shoecal_core.recording.session import Session
from shoecal_core.workflows.calibrate import calibrate_session


def gains(member: Member) -> tuple[FloatArray, FloatArray]:
    """(n,) gains of a session's calibration, and their stated standard deviations."""
    outcome = calibrate_session(Session.open(member.folder), member.train, member.test)
    gain = outcome.calibration.parameters.gain
    std = np.sqrt(np.diag(outcome.assessment.covariance))
    return gain, std[: len(gain)]


def repeats(found: Sequence[tuple[FloatArray, FloatArray]]) -> Row:
    """How far gains differ, against what is stated [%]."""
    gain, std = (np.array(part) for part in zip(*found, strict=True))
    first, second = np.triu_indices(len(gain), 1)
    ratios = np.abs(gain[first] - gain[second]) / np.hypot(std[first], std[second])
    spread = np.mean(gain.std(axis=0, ddof=1) / np.abs(gain.mean(axis=0)))
    return {
        "calibrations": len(gain),
        "spread of gains [%]": 100.0 * float(spread),
        "stated standard deviation [%]": 100.0 * float(np.mean(std / np.abs(gain))),
        "differences inside 95 % [%]": 100.0 * float(np.mean(ratios < NORMAL_95)),
    }


def main() -> None:
    """Measure and write."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--repeats", type=int, default=10)
    parser.add_argument("--robot", type=int, default=1, help="seed of the robot")
    args = parser.parse_args()
    made = [member for member, _ in sessions(one_robot(args.robot, args.repeats))]
    with ProcessPoolExecutor(os.cpu_count()) as pool:
        again = repeats(list(pool.map(gains, made)))
    record("repeats", again)
    write_section("repeats", markdown([again]), TRUST)
    print(again)


if __name__ == "__main__":
    main()
