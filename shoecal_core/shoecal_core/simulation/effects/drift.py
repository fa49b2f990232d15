"""Effects that grow with the time of a session, or with the temperature of the shoes."""

from __future__ import annotations

import math
from dataclasses import dataclass

from shoecal_core.arrays import FloatArray, IntArray
from shoecal_core.files import Fields
from shoecal_core.simulation.effects.effect import SensorEffect
from shoecal_core.simulation.effects.location import Channels
from shoecal_core.simulation.sampled_parts import SampledShoes
from shoecal_core.simulation.stage import Instant, Memoryless, Place
from shoecal_core.simulation.temperature import WarmUp

_SESSION = 300.0
"""s; over this time the mean rate is the stated one."""
_WARM_UP = 600.0
"""s; time constant with which electronics come to rest after power-on."""
_BEHIND = 10.0
"""s; by which a cell's body is behind the sensor that measures its temperature."""


@dataclass(frozen=True)
class Course:
    """How far a drift has come.

    With time it slows down, as after power-on:
    d(t) = rate S (1 - exp(-t / T)) / (1 - exp(-S / T)), S = 300 s and T = 600 s, so that the mean
    rate over 300 s is the stated one (at first 1.27 times, at 300 s 0.77 times as much). With
    temperature it is in proportion to how warm the shoes were 10 s before.

    Attributes:
        rate: a second.
        per_kelvin: a kelvin.
        temperature: how the shoes warm up.
    """

    rate: float
    per_kelvin: float
    temperature: WarmUp

    def at(self, time: float) -> float:
        """At a time since the session began [s]."""
        come = _SESSION * math.expm1(-time / _WARM_UP) / math.expm1(-_SESSION / _WARM_UP)
        warmer = self.temperature.above_ambient(time - _BEHIND)
        return self.rate * come + self.per_kelvin * warmer


@dataclass(frozen=True)
class _Drift(SensorEffect):
    """What both drifts are read from.

    Attributes:
        channels: which drift.
        rate: a second.
        per_kelvin: a kelvin.
    """

    channels: Channels
    rate: float
    per_kelvin: float

    def course(self, shoes: SampledShoes) -> Course:
        """How it goes on in these shoes.

        Raises:
            FileError: for a drift with the temperature of shoes that do not warm up.
        """
        if self.per_kelvin and not shoes.temperature.rise:
            raise self.channels.error(
                "the shoes of this reality do not warm up, so nothing drifts by the kelvin; give "
                "shoes.warm_up_k, or a rate a second"
            )
        return Course(self.rate, self.per_kelvin, shoes.temperature)


@dataclass(frozen=True)
class ZeroDrift(_Drift):
    """Zeros wander: f^ = f + d; rate in N/s, per_kelvin in N/K."""

    @classmethod
    def read(cls, fields: Fields) -> ZeroDrift:
        """From the item of a reality file."""
        return cls(*_read(fields, "rate_n_per_s", "per_kelvin_n_per_k"))

    def stage(self, shoes: SampledShoes) -> ZeroShift:
        """Its law."""
        return ZeroShift(self.channels.forces(shoes.shoe), self.course(shoes))


@dataclass(frozen=True)
class ZeroShift(Memoryless):
    """The law of `ZeroDrift`."""

    channels: IntArray
    course: Course
    place = Place.ZERO

    def passed(self, signal: FloatArray, instant: Instant) -> FloatArray:
        """The signal (n,) behind it [N or N m]."""
        shifted = signal.copy()
        shifted[self.channels] += self.course.at(instant.time)
        return shifted


@dataclass(frozen=True)
class SpanDrift(_Drift):
    """Gains wander: f^ = f (1 + d); rate in 1/s, per_kelvin in 1/K."""

    @classmethod
    def read(cls, fields: Fields) -> SpanDrift:
        """From the item of a reality file."""
        return cls(*_read(fields, "rate_per_s", "per_kelvin_per_k"))

    def stage(self, shoes: SampledShoes) -> SpanShift:
        """Its law."""
        return SpanShift(self.channels.every(shoes.shoe), self.course(shoes))


@dataclass(frozen=True)
class SpanShift(Memoryless):
    """The law of `SpanDrift`."""

    channels: IntArray
    course: Course
    place = Place.SPAN

    def passed(self, signal: FloatArray, instant: Instant) -> FloatArray:
        """The signal (n,) behind it [N or N m]."""
        spread = signal.copy()
        spread[self.channels] *= 1.0 + self.course.at(instant.time)
        return spread


def _read(fields: Fields, rate: str, per_kelvin: str) -> tuple[Channels, float, float]:
    """Where, and the size a second and a kelvin, of which at least one is given."""
    fields.only("effect", "location", rate, per_kelvin)
    if per_kelvin not in fields:
        fields.value(rate)
    channels = Channels.read(fields, areas=True)
    return channels, fields.number(rate, 0.0), fields.number(per_kelvin, 0.0)


EFFECTS = {"zero_drift": ZeroDrift.read, "span_drift": SpanDrift.read}
"""Effects of this family by identifier."""
