"""Made-up recordings of a robot that sways over both feet, as screening sees them."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from core.estimation import synthetic
from core.shoe import shoes
from shoecal_core.arrays import FloatArray
from shoecal_core.recording.info import RunInfo
from shoecal_core.recording.run import JointSamples, Readings, Run
from shoecal_core.robot.double_support import DoubleSupport
from shoecal_core.robot.kinematics import BodyStates
from shoecal_core.samples.aligned import Aligned
from shoecal_core.screening.blocks import blocks
from shoecal_core.screening.rough_fit import Statics
from shoecal_core.screening.settings import CalibrationSettings
from shoecal_core.shoe.shoe import Shoe
from shoecal_core.shoe.wrench import ChannelParameters, at_cop, combined, cop, weight_below

SETTINGS = CalibrationSettings()
WEIGHT = 54.0
HEIGHT = 0.25
RATE = 100.0
SECONDS = 30.0
NOISE_N = 0.01
WANDER_M, WANDER_RAD = 1e-4, 5e-4
"""What encoder steps make of one sole seen from the other."""
MODEL_ERROR_M = 0.0015


@dataclass(frozen=True)
class Recording:
    """Runs in double support, and the truth behind them."""

    shoe: Shoe
    parameters: ChannelParameters
    aligned: Mapping[int, Aligned]

    @property
    def statics(self) -> Statics:
        """What screening solves."""
        parts = {number: blocks(one, self.shoe) for number, one in self.aligned.items()}
        return Statics.of(self.shoe, parts, WEIGHT, SETTINGS)

    @property
    def runs(self) -> dict[int, Run]:
        """The same as it was recorded."""
        return {number: self._run(number, one) for number, one in self.aligned.items()}

    def with_readings(self, change: Callable[[int, FloatArray], FloatArray]) -> Recording:
        """Other readings: a function of the run's number and its readings (T, n)."""
        changed = {
            number: replace(one, readings=change(number, one.readings.copy()))
            for number, one in self.aligned.items()
        }
        return replace(self, aligned=changed)

    def with_channel(
        self, channel: int, change: Callable[[int, FloatArray], FloatArray]
    ) -> Recording:
        """Other readings of one channel (T,)."""

        def changed(number: int, readings: FloatArray) -> FloatArray:
            readings[:, channel] = change(number, readings[:, channel])
            return readings

        return self.with_readings(changed)

    def with_run(self, number: int, **changes: object) -> Recording:
        """One run with other fields."""
        one = replace(self.aligned[number], **changes)  # type: ignore[arg-type]
        return replace(self, aligned={**self.aligned, number: one})

    def _run(self, number: int, one: Aligned) -> Run:
        shape, digest = one.readings.shape, "0" * 64
        return Run(
            path=Path(f"run_{number:03d}.mcap"),
            info=RunInfo(
                number, "landmarks", one.states.support(), "nao", self.shoe.name,
                digest, digest, digest,
            ),
            start_ns=0,
            joints=JointSamples(one.time, ("joint",), np.zeros((len(one.time), 1)), None),
            readings=Readings(
                one.time, self.shoe.names, one.readings, np.zeros(shape, dtype=np.uint8),
                np.zeros(shape, dtype=np.int64), np.full(shape, np.nan),
            ),
        )  # fmt: skip


def recording(
    seed: int = 1,
    *,
    count: int = 3,
    noise: float = NOISE_N,
    shoe: str | Shoe = "nao_shoe",
    seconds: float = SECONDS,
) -> Recording:
    """A robot without fault on rigid shoes; its model is a little off, and slowly."""
    rng = np.random.default_rng(seed)
    worn = shoes.shoe(shoe) if isinstance(shoe, str) else shoe
    parameters = synthetic.truth(worn, rng)
    supports = synthetic.SUPPORTS[:count]
    return Recording(
        worn,
        parameters,
        {
            number: _sway(worn, parameters, support, rng, noise, seconds)
            for number, support in enumerate(supports, start=1)
        },
    )


def read_coarsely(whole: Recording, bits: int, noise: float, seed: int = 7) -> Recording:
    """The same through a poor converter of 10 V [V of noise]."""
    rng, step = np.random.default_rng(seed), 10.0 / 2**bits
    return whole.with_readings(
        lambda _, values: (
            np.rint((values + noise * rng.standard_normal(values.shape)) / step) * step
        )
    )


def _sway(
    shoe: Shoe,
    parameters: ChannelParameters,
    support: DoubleSupport,
    rng: np.random.Generator,
    noise: float,
    seconds: float,
) -> Aligned:
    time = np.arange(round(seconds * RATE)) / RATE

    def wave(size: float, period: float) -> FloatArray:
        pace, start = rng.uniform(0.8, 1.2) / period, rng.uniform(0.0, 2.0 * np.pi)
        return np.asarray(size * np.sin(2.0 * np.pi * pace * time + start))

    share = 0.5 + wave(0.36, 22.0)
    quick = np.stack((wave(0.0015, 1.5), wave(0.0015, 1.2)), axis=1)
    wrenches = []
    for foot, load in ((0, share), (1, 1.0 - share)):
        middle = shoe.positions[shoe.of_foot(foot)].mean(axis=0)
        place = middle + quick + np.stack((wave(0.03, 13.0), wave(0.012, 9.0)), axis=1)
        wrenches.append(at_cop(WEIGHT * load, place))
    wrench = np.stack(wrenches, axis=1)
    outputs = np.zeros((len(time), len(shoe.names)))
    for foot in (0, 1):
        own = shoe.of_foot(foot)
        carried = wrench[:, foot] - weight_below(shoe)[foot]
        outputs[:, own] = carried @ np.linalg.pinv(shoe.columns[own])
    outputs += noise * rng.standard_normal(outputs.shape)
    error = np.stack((wave(MODEL_ERROR_M, 18.0), wave(MODEL_ERROR_M, 18.0)), axis=1)
    return Aligned(
        time,
        (outputs - parameters.offset) / parameters.gain,
        np.zeros((len(time), 1)),
        _states(cop(combined(wrench, support), 0.0) + error, support, rng),
    )


def _states(place: FloatArray, support: DoubleSupport, rng: np.random.Generator) -> BodyStates:
    count = len(place)
    com = np.concatenate((place, np.full((count, 1), HEIGHT)), axis=1)
    shift = np.array([support.dx, support.dy, 0.0])
    return BodyStates(
        com=np.stack((com, com), axis=1),
        rotation=turned(support.dtheta + WANDER_RAD * rng.standard_normal(count)),
        translation=shift + WANDER_M * rng.standard_normal((count, 3)),
        left_rotation=np.tile(np.eye(3), (count, 1, 1)),
        left_translation=np.zeros((count, 3)),
    )


def turned(yaw: FloatArray) -> FloatArray:
    """(T, 3, 3) turns about z by angles (T,) [rad]."""
    c, s, zero, one = np.cos(yaw), np.sin(yaw), np.zeros_like(yaw), np.ones_like(yaw)
    rows = [np.stack(row, axis=-1) for row in ((c, -s, zero), (s, c, zero), (zero, zero, one))]
    return np.stack(rows, axis=-2)
