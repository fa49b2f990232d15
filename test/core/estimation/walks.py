"""Walks on ankle sensors, made up: known gains and zeros, and a model that misses the same thing in
every step."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from core.shoe import shoes
from shoecal_core.arrays import FloatArray
from shoecal_core.robot.double_support import DoubleSupport
from shoecal_core.robot.gravity import GRAVITY
from shoecal_core.samples.stance import Stance, make_stance
from shoecal_core.samples.zeros import Zero
from shoecal_core.shoe.shoe_file import load_shoe

ANKLES = load_shoe(shoes.ROOT / "config/shoes/reemc.yaml")
HEIGHT = 0.12
WEIGHT = 70.0 * GRAVITY
RATE = 50.0
SUPPORT = DoubleSupport(0.0, -0.2, 0.0)


def step(
    run: int,
    foot: int,
    rng: np.random.Generator,
    zeros: FloatArray,
    gain: FloatArray,
    missed: float,
    axes: FloatArray | None = None,
) -> Stance:
    """A second on one foot.

    Args:
        zeros: (10,) readings of hanging feet.
        gain: (10,) of the sensors.
        missed: by how much the model's CoP is too far along x at the step's end, each time [m].
        axes: (2, 2) of fx, fy on the sideways force; the unit matrix by default.
    """
    time = np.arange(0.0, 1.0, 1.0 / RATE)
    push = np.stack((40.0 * np.sin(5.0 * time), 20.0 * np.cos(4.0 * time)), axis=1)
    force = WEIGHT + 30.0 * np.sin(7.0 * time)
    place = np.stack((0.03 * np.sin(5.0 * time), 0.01 * np.cos(3.0 * time)), axis=1)
    wrench = np.stack((force, force * place[:, 1], -force * place[:, 0]), axis=1)
    shown = push if axes is None else push @ axes.T
    outputs = np.zeros((len(time), 10))
    own = 5 * foot + np.arange(5)
    outputs[:, own] = np.stack(
        (
            shown[:, 0],
            shown[:, 1],
            force,
            wrench[:, 1] + HEIGHT * push[:, 1],
            wrench[:, 2] - HEIGHT * push[:, 0],
        ),
        axis=1,
    )
    readings = outputs / gain + zeros + 0.3 * rng.standard_normal((len(time), 10))
    model = place + missed * np.stack((time + 0.2 * push[:, 0] / 40.0, 0.0 * time), axis=1)
    loaded = (foot == 0, foot == 1)
    stance = make_stance(run, ANKLES, SUPPORT, loaded, time, readings, force, model)
    return Stance(**{**vars(stance), "push": push})


def walk(
    runs: Sequence[int],
    rng: np.random.Generator,
    gain: FloatArray,
    missed: float = 0.02,
    axes: FloatArray | None = None,
) -> tuple[list[Stance], list[Zero], dict[int, FloatArray]]:
    """Four steps a run, whose zeros are 20 N apart; stances, zeros, and the true zeros by run."""
    stances, found, true = [], [], {}
    for run in runs:
        zeros = np.where(ANKLES.torque, 0.1, 1.0) * rng.normal(-50.0, 20.0, 10)
        true[run] = zeros
        stances += [step(run, foot, rng, zeros, gain, missed, axes) for foot in (0, 1, 0, 1)]
        phase = np.repeat(np.arange(4), 20)
        hanging = zeros + 0.3 * rng.standard_normal((len(phase), 10))
        found += [Zero(run, foot, phase, hanging) for foot in (0, 1)]
    return stances, found, true
