"""The bench of a manual calibration: known weights on a shoe, or on one cell of it."""

from __future__ import annotations

import math

import mujoco
import numpy as np

from shoecal_core.arrays import FloatArray
from shoecal_core.errors import ShapeError, ShoecalError
from shoecal_core.robot.gravity import GRAVITY
from shoecal_core.shoe.shoe import FEET, Shoe
from shoecal_core.simulation.converter import AdConverter, ConvertedReadings
from shoecal_core.simulation.reality import PlantVariation
from shoecal_core.simulation.sampled_parts import SampledShoes
from shoecal_core.simulation.sensor_chain import SensorChain
from shoecal_core.simulation.shoe_physics import (
    ChannelOutputs,
    ShoeBuilder,
    add_floor,
)
from shoecal_core.simulation.stepping import advance

_MARGIN = 0.02
"""m; the shoe's outline on the bench beyond its channels: wide enough not to tip."""
_REST_SPEED, _PATIENCE = 1e-5, 5.0
"""m/s, rad/s: slower is at rest; and the simulated time to wait for it [s]."""
_SETTLE = 0.05
"""s; between two looks whether it is at rest."""
_STANDS, _LOOKS = 5.0, 50
"""s; for which a weight stands before it is read (readings may lag, creep and drift), and in how
many steps this is reckoned."""


class LoadingRig:
    """One shoe after the other on the floor, and upright weights.

    Readings have all channels of the shoe; those of the other foot feel nothing.
    """

    def __init__(
        self, shoe: Shoe, rules: PlantVariation, drawn: SampledShoes, noise: np.random.Generator
    ) -> None:
        """Set up the bench.

        Args:
            shoe: as its file says.
            rules, drawn: as it truly is.
            noise: draws where a weight stands exactly, and the noise of readings.
        """
        self.shoe = shoe
        self._noise = noise
        self._placement_std = rules.rig.placement_error_std_m
        self._chain, self._time = SensorChain(drawn), 0.0
        self._converter = AdConverter(shoe, rules, drawn, noise)
        self._benches = tuple(_Bench(shoe, rules, drawn, foot) for foot in (0, 1))

    def readings(
        self, mass: float, foot: int, position: FloatArray, *, count: int = 1
    ) -> ConvertedReadings:
        """Readings (count, n) with a weight on the top plate.

        Args:
            mass: of the weight [kg]; 0 for the bare shoe.
            foot: 0 left, 1 right.
            position: (2,) where it is meant to stand, in the sole frame [m].
            count: how many, one after the other.

        Raises:
            ShoecalError: for a weight below zero, or when the shoe tips over.
        """
        if not mass >= 0.0:
            raise ShoecalError(f"a weight of {mass:g} kg cannot be put on a shoe; give 0 or more")
        if position.shape != (2,):
            raise ShapeError("position", "(2,)", position.shape)
        stands = position + self._noise.normal(0.0, self._placement_std, 2)
        return self._read(self._benches[foot].load(mass, stands), count)

    def cell_readings(self, mass: float, channel: str, *, count: int = 1) -> ConvertedReadings:
        """Readings (count, n) with one cell off its shoe, carrying a weight alone [kg].

        Raises:
            NameNotFoundError: when there is no such channel.
        """
        outputs = np.zeros(len(self.shoe.channels))
        outputs[self.shoe.index(channel)] = mass * GRAVITY
        return self._read(outputs, count)

    def _read(self, outputs: FloatArray, count: int) -> ConvertedReadings:
        """Readings of outputs (n,) that came and stood; the load before was taken off."""
        self._chain.lift()
        for _ in range(_LOOKS):
            self._chain.take(outputs, self._time)
            self._time += _STANDS / _LOOKS
        return self._converter(np.tile(self._chain.latest(), (count, 1)), self._chain.time)


class _Bench:
    """One shoe, its top plate free, on the floor."""

    def __init__(self, shoe: Shoe, rules: PlantVariation, drawn: SampledShoes, foot: int) -> None:
        self._name = f"{FEET[foot]} shoe"
        spec = mujoco.MjSpec()
        add_floor(spec, rules, drawn)
        places = shoe.positions[shoe.of_foot(foot)]
        (left, low), (right, high) = places.min(axis=0) - _MARGIN, places.max(axis=0) + _MARGIN
        outline = np.array([[left, low], [right, low], [right, high], [left, high]])
        plate = spec.worldbody.add_body(name="plate")
        plate.add_freejoint(name="plate")
        plate.mass, plate.inertia, plate.explicitinertial = 1e-6, [1e-9] * 3, True
        level = np.array([1.0, 0.0, 0.0, 0.0])
        ShoeBuilder(shoe, rules, drawn).add(spec, plate, foot, np.zeros(3), level, outline)
        self._model = spec.compile()
        self._data = mujoco.MjData(self._model)
        self._plate = self._model.body("plate").id
        self._outputs = ChannelOutputs(self._model, shoe, (foot,))

    def load(self, mass: float, position: FloatArray) -> FloatArray:
        """Outputs (n,) [N or N m] at rest with a weight [kg] at `position` (2,) [m]."""
        model, data = self._model, self._data
        mujoco.mj_resetData(model, data)
        force = mass * model.opt.gravity
        data.xfrc_applied[self._plate, :3] = force
        data.xfrc_applied[self._plate, 3:] = np.cross([*position, 0.0], force)
        steps = max(1, math.ceil(_SETTLE / model.opt.timestep))
        speed = math.inf
        while speed > _REST_SPEED:
            advance(model, data, steps)
            speed = float(np.abs(data.qvel).max())
            if data.time > _PATIENCE or abs(data.xmat[self._plate, 8] - 1.0) > 0.01:
                raise ShoecalError(
                    f"the {self._name} does not stand still under {mass:g} kg at "
                    f"({position[0]:g}, {position[1]:g}) m; put the weight between the cells"
                )
        mujoco.mj_forward(model, data)
        return self._outputs(data)
