"""Making one set: a simulated robot follows the motions, and a session is written."""

from __future__ import annotations

import dataclasses
import shutil
from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np

from blind.answers import Answer
from blind.felt import felt
from blind.gap import AddedNoise, gap_of_change
from blind.motions import PlannedMotion
from blind.noise import coloured
from blind.sizing import as_shown
from blind.unknowns import Unknown
from population import RATE_HZ, nao
from shoecal_core.arrays import FloatArray
from shoecal_core.recording.session import TRUTH, Session
from shoecal_core.simulation.reality import PlantVariation
from shoecal_core.simulation.robot import SimulatedRobot
from shoecal_core.simulation.sampled_robot import draw
from shoecal_core.simulation.samples import SimulatedSamples, run
from shoecal_core.workflows.simulated_recording import record_run

HOLD_S = 1.0
"""Standing still before and after a motion."""
PAUSE_S = 1.0
"""From run to run, about: until the robot stands still in the next double support."""
_DAY_NS = 86_400_000_000_000


class Recorded(NamedTuple):
    """What came of a set.

    Attributes:
        starts: when each run's recording began, in the simulated robot's session time [s].
        sizes: of the drawn laws, those of its effects and then of what is unknown; see `laws`.
        noise: of its cells.
    """

    starts: list[float]
    sizes: list[float]
    noise: AddedNoise


def record(
    folder: Path,
    answer: Answer,
    reality: PlantVariation,
    motions: Sequence[PlannedMotion],
    foreign: Unknown | None,
    rate: float = RATE_HZ,
) -> Recorded:
    """Simulate and write a set's session; whole or not at all.

    Nothing of the truth stays in it, nor a seed, nor a date that tells one set from another.

    Args:
        folder: to make.
        answer: what it is.
        reality: its world, the effects whose laws are the simulator's included.
        motions: to follow, in this order.
        foreign: what acts on it beside the library.
        rate: samples a second [Hz].

    Raises:
        ShoecalError: when the robot cannot stand so, or falls.
    """
    robot, shoe = nao()
    if foreign is not None:
        reality = dataclasses.replace(reality, effects=(*reality.effects, foreign))
    rng = np.random.default_rng([answer.seed, 7])
    drawn = draw(reality, robot, shoe, answer.seed)
    # Laws act on forces as they are; noise is added to what they make of them.
    silent = dataclasses.replace(drawn.shoes, noise=np.zeros_like(drawn.shoes.noise))
    simulated = SimulatedRobot(
        robot, shoe, dataclasses.replace(drawn, shoes=silent),
        np.random.default_rng([answer.seed, 8]),
    )  # fmt: skip
    converter = drawn.shoes.parameters
    starts: list[float] = []
    runs: list[SimulatedSamples] = []
    forces: list[FloatArray] = []
    for motion in motions:
        simulated.place(motion.trajectory.positions[0])
        starts.append(simulated.session_time)
        samples = run(simulated, motion.trajectory, rate, hold=HOLD_S)
        own = converter.gain * samples.readings.voltages + converter.offset
        forces.append(own if foreign is None else foreign.forces(simulated, samples, own))
        runs.append(samples)
    shown, sizes = as_shown(answer, felt(shoe, motions, runs, forces, starts))
    noise_rng = np.random.default_rng([answer.seed, 9])
    shapes = [one.shape for one in forces]
    colour = [coloured(shape, rate, answer.slope, noise_rng) for shape in shapes]
    noise = drawn.shoes.noise * np.concatenate(colour)
    added = noise / converter.gain
    begun = folder.with_name(f".{folder.name}")
    shutil.rmtree(begun, ignore_errors=True)
    session = Session.create(begun, robot.path, robot.urdf, shoe.path)
    begin_ns = int(rng.integers(15_000, 20_000)) * _DAY_NS + int(rng.integers(_DAY_NS))
    for motion, samples, part, start in zip(motions, runs, shown.runs, starts, strict=True):
        voltages = (shown.forces[part] - converter.offset) / converter.gain + added[part]
        readings = dataclasses.replace(samples.readings, voltages=voltages)
        start_ns = begin_ns + round(1e9 * (start - starts[0]))
        record_run(
            session, simulated, motion.run, motion.trajectory,
            dataclasses.replace(samples, readings=readings), start_ns=start_ns, hold=HOLD_S,
        )  # fmt: skip
    shutil.rmtree(begun / TRUTH)
    shutil.rmtree(folder, ignore_errors=True)
    begun.rename(folder)
    parts = list(enumerate(shown.runs, start=1))
    return Recorded(
        starts,
        sizes,
        AddedNoise(
            {run: shown.since[part] for run, part in parts},
            {run: added[part] for run, part in parts},
            gap_of_change(shown, noise),
        ),
    )
