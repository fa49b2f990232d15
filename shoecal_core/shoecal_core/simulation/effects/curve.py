"""Effects of what a cell gives for a force when that is no straight line."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from shoecal_core.arrays import FloatArray, IntArray
from shoecal_core.files import Fields
from shoecal_core.simulation.effects.effect import SensorEffect
from shoecal_core.simulation.effects.location import Channels
from shoecal_core.simulation.sampled_parts import SampledShoes
from shoecal_core.simulation.stage import Instant, Memoryless, Place

_BEND = 0.5
"""Over the full scale: force in whose measure a curve of sines bends."""
_KNEE = 0.02
"""Over the level: width of the knee of a saturation."""


@dataclass(frozen=True)
class Nonlinearity(SensorEffect):
    """f + quadratic f^2 + cubic f^3 for small forces; sines of the force for large ones.

    f^ = f + 2 quadratic L^2 (1 - cos(f / L)) + 6 cubic L^3 (f / L - sin(f / L))

    with L half of the full scale: at a third of that (20 N of 60 N) the quadratic part is 4 % and
    the cubic part 2 % less than the polynomial.

    Attributes:
        channels: that read a force.
        quadratic: [1/N].
        cubic: [1/N^2].
    """

    channels: Channels
    quadratic: float
    cubic: float

    @classmethod
    def read(cls, fields: Fields) -> Nonlinearity:
        """From the item of a reality file; a size that is left out is 0, but not both."""
        fields.only("effect", "location", "quadratic_per_n", "cubic_per_n2")
        if "cubic_per_n2" not in fields:
            fields.value("quadratic_per_n")
        return cls(
            Channels.read(fields),
            fields.number("quadratic_per_n", 0.0, minimum=-0.1, maximum=0.1),
            fields.number("cubic_per_n2", 0.0, minimum=-0.01, maximum=0.01),
        )

    def stage(self, shoes: SampledShoes) -> Curve:
        """Its law."""
        chosen = self.channels.forces(shoes.shoe)
        return Curve(chosen, self.quadratic, self.cubic, _BEND * shoes.full_scale[chosen])


@dataclass(frozen=True)
class Curve(Memoryless):
    """The law of `Nonlinearity`; scale: (k,) its L [N]."""

    channels: IntArray
    quadratic: float
    cubic: float
    scale: FloatArray
    place = Place.CURVE

    def passed(self, signal: FloatArray, instant: Instant) -> FloatArray:  # noqa: ARG002
        """The signal (n,) behind it [N or N m]."""
        bent, scale = signal.copy(), self.scale
        ratio = signal[self.channels] / scale
        bent[self.channels] += 2.0 * self.quadratic * scale**2 * (1.0 - np.cos(ratio))
        bent[self.channels] += 6.0 * self.cubic * scale**3 * (ratio - np.sin(ratio))
        return bent


@dataclass(frozen=True)
class Saturation(SensorEffect):
    """Nothing above a level is felt; the converter's status stays good.

    A smooth knee: f^ = level - w log(1 + exp((level - f) / w)) with w = 2 % of the level, so
    that 1.4 % of it are missing at the level itself.

    Attributes:
        channels: that read a force.
        level: [N].
    """

    channels: Channels
    level: float

    @classmethod
    def read(cls, fields: Fields) -> Saturation:
        """From the item of a reality file."""
        fields.only("effect", "location", "level_n")
        return cls(Channels.read(fields), fields.number("level_n", above=0.0))

    def stage(self, shoes: SampledShoes) -> SaturationCurve:
        """Its law."""
        return SaturationCurve(self.channels.forces(shoes.shoe), self.level)


@dataclass(frozen=True)
class SaturationCurve(Memoryless):
    """The law of `Saturation`."""

    channels: IntArray
    level: float
    place = Place.STOP

    def passed(self, signal: FloatArray, instant: Instant) -> FloatArray:  # noqa: ARG002
        """The signal (n,) behind it [N or N m]."""
        ended, width = signal.copy(), _KNEE * self.level
        below = (self.level - signal[self.channels]) / width
        ended[self.channels] = self.level - width * np.logaddexp(0.0, below)
        return ended


EFFECTS = {"nonlinearity": Nonlinearity.read, "saturation": Saturation.read}
"""Effects of this family by identifier."""
