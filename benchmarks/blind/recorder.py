"""Making one set: a simulated robot follows the motions, and a session is written."""

from __future__ import annotations

import dataclasses
import shutil
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from blind.answers import Answer
from blind.motions import PlannedMotion
from blind.unknowns import Unknown
from population import RATE_HZ, nao
from shoecal_core.recording.session import TRUTH, Session
from shoecal_core.simulation.reality import PlantVariation
from shoecal_core.simulation.robot import SimulatedRobot
from shoecal_core.simulation.sampled_robot import draw
from shoecal_core.simulation.samples import run
from shoecal_core.workflows.simulated_recording import record_run

HOLD_S = 1.0
"""Standing still before and after a motion."""
PAUSE_S = 1.0
"""From run to run, about: until the robot stands still in the next double support."""
_DAY_NS = 86_400_000_000_000


def record(
    folder: Path,
    answer: Answer,
    reality: PlantVariation,
    motions: Sequence[PlannedMotion],
    foreign: Unknown | None,
    rate: float = RATE_HZ,
) -> list[float]:
    """Simulate and write a set's session; whole or not at all.

    Nothing of the truth stays in it, nor a seed, nor a date that tells one set from another.

    Args:
        folder: to make.
        answer: what it is.
        reality: its world, effects included.
        motions: to follow, in this order.
        foreign: what it has beside the library.
        rate: samples a second [Hz].

    Returns:
        When each run's recording began, in the session's time of the simulated robot [s].

    Raises:
        ShoecalError: when the robot cannot stand so, or falls.
    """
    robot, shoe = nao()
    if foreign is not None:
        reality = dataclasses.replace(reality, effects=(*reality.effects, foreign))
    rng = np.random.default_rng([answer.seed, 7])
    drawn = draw(reality, robot, shoe, answer.seed)
    simulated = SimulatedRobot(robot, shoe, drawn, np.random.default_rng([answer.seed, 8]))
    begun = folder.with_name(f".{folder.name}")
    shutil.rmtree(begun, ignore_errors=True)
    session = Session.create(begun, robot.path, robot.urdf, shoe.path)
    begin_ns = int(rng.integers(15_000, 20_000)) * _DAY_NS + int(rng.integers(_DAY_NS))
    starts: list[float] = []
    for motion in motions:
        simulated.place(motion.trajectory.positions[0])
        starts.append(simulated.session_time)
        samples = run(simulated, motion.trajectory, rate, hold=HOLD_S)
        if foreign is not None:
            told = dataclasses.replace(
                samples.readings, voltages=foreign.readings(simulated, samples)
            )
            samples = dataclasses.replace(samples, readings=told)
        start_ns = begin_ns + round(1e9 * (starts[-1] - starts[0]))
        record_run(
            session, simulated, motion.run, motion.trajectory, samples, start_ns=start_ns,
            hold=HOLD_S,
        )  # fmt: skip
    shutil.rmtree(begun / TRUTH)
    shutil.rmtree(folder, ignore_errors=True)
    begun.rename(folder)
    return starts
