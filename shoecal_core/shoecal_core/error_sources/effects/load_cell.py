"""Effects of single cells: what a reading has beyond its affine law."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from shoecal_core.arrays import BoolArray, FloatArray, IntArray
from shoecal_core.error_sources.base import Component, Place, Shape, one_at, one_of
from shoecal_core.error_sources.effects import places
from shoecal_core.error_sources.loads import LOOP_WIDTHS
from shoecal_core.error_sources.signal_model import SignalModel
from shoecal_core.samples.filters import low_passed
from shoecal_core.samples.samples import Track
from shoecal_core.shoe.wrench import weight_below

LEAST_HANGING = 5
"""Samples in the air that are enough to know what a cell shows without load."""
FLAT_STUCK, FLAT_AT_TOP = 0.01, 0.5
"""Movement of a channel over what is expected, up to which it may be stuck, or saturated."""
RIDGE, LEAST_SPREAD = 1e-4, 1e-6
"""Of a law's normal matrix, as some directions never move; and of a channel that does not [N]."""
WARM_UP = 0.3
"""Time constant of what warms up, as a share of the session."""


def shown(signal_model: SignalModel, channels: IntArray, values: FloatArray) -> FloatArray:
    """(T, s) when these channels show `values` (T, k) [N or N m] more than they feel."""
    change = np.zeros_like(signal_model.outputs)
    change[:, channels] = values
    return signal_model.by_outputs(change)


def each_shown(signal_model: SignalModel, channels: IntArray, values: FloatArray) -> FloatArray:
    """(k, T, s) the same of each of k courses (T, k) that all the channels have alike."""
    return np.array([shown(signal_model, channels, one[:, None]) for one in values.T])


def unloaded(signal_model: SignalModel, channel: int) -> float:
    """What a cell shows without load, from samples of its foot in the air [N]; else 0.

    Offsets of a foot's cells that change neither its force nor its CoP no other signal fixes.
    """
    samples, shoe = signal_model.samples, signal_model.samples.shoe
    foot = int(shoe.foot[channel])
    hanging = ~samples.loaded[:, foot]
    if np.count_nonzero(hanging) < LEAST_HANGING:
        return 0.0
    # What is below the cells hangs on them all.
    cells = np.count_nonzero(shoe.foot[places.vertical(shoe)] == foot)
    below = float(weight_below(shoe)[foot, 0]) / cells
    return float(np.median(signal_model.outputs[hanging, channel])) + below


KNOTS = 8
"""Of laws that no formula gives: a smooth curve of two bends is followed within a tenth."""


def knots(values: FloatArray) -> tuple[FloatArray, FloatArray]:
    """(k,) knots over the range of values (T,), its ends left out; (T, k) hats that are 1 there.

    Any curve is nearly a sum of hats (linear splines: de Boor, A Practical Guide to Splines, ch.
    III), but for a straight line, which gain and offset are.
    """
    low, high = np.percentile(values, (1.0, 99.0))
    at = np.linspace(low, high, KNOTS)
    hats = np.stack([np.interp(values, at, one) for one in np.eye(KNOTS)[1:-1]], axis=1)
    return at[1:-1], hats


class Nonlinearity:
    """A cell's output bends: f + quadratic f^2 + cubic f^3, or along any curve."""

    identifier, group = "nonlinearity", "load_cell"
    components = (
        Component("quadratic", "1/N", 2e-3, form=2.5), Component("cubic", "1/N^2", 5e-5, form=2.5),
        Component("bend", "N", 2.0),
    )  # fmt: skip

    def places(self, signal_model: SignalModel) -> Iterator[Place]:
        """Every cell."""
        return places.each_cell(signal_model)

    def shapes(self, signal_model: SignalModel, place: Place) -> Iterator[Shape]:
        """Both powers together; or by how much more it shows at some loads than on a straight line
        from the lowest to the highest.
        """
        channels = places.channels_at(signal_model, place)
        force = signal_model.outputs[:, channels] - unloaded(signal_model, int(channels[0]))
        columns = np.array([shown(signal_model, channels, force**power) for power in (2, 3)])
        yield Shape(("quadratic", "cubic"), columns)
        loads, hats = knots(force[:, 0])
        columns = each_shown(signal_model, channels, hats)
        yield Shape(tuple(one_at("bend", f"{load:.1f} N") for load in loads), columns)


SOFT = (0.0, 0.1, 0.2, 0.35, 0.5)
"""Of the span from the top down, where a cell may bend over that saturates softly."""
MOST_SHARE = 3.0
"""By which it may bend there, either way: 1 turns a straight line flat."""


class Saturation:
    """A cell's output ends at a level below its converter's range."""

    identifier, group = "saturation", "load_cell"
    components = (Component("level", "N", 10.0),)

    def places(self, signal_model: SignalModel) -> Iterator[Place]:
        """Every cell."""
        return places.each_cell(signal_model)

    def shapes(self, signal_model: SignalModel, place: Place) -> Iterator[Shape]:
        """Levels near the top of what it showed; the other channels give what is missing there. Or
        softly, by a part of what is missing above each of some levels.
        """
        (channel,) = places.channels_at(signal_model, place)
        force = signal_model.outputs[:, channel]
        by_others = expected(signal_model, int(channel), force <= np.median(force))
        top, zero = force.max(), unloaded(signal_model, int(channel))
        span = top - np.percentile(force, 5.0)
        flat: list[float] = []
        for share in (0.0, 0.04, 0.1, 0.2, 0.35):
            level = float(top - share * span)
            missing = np.maximum(by_others - level, 0.0)
            beyond = missing > 0.0
            if np.count_nonzero(beyond) >= 5 and _flat(
                force[beyond], by_others[beyond], FLAT_AT_TOP
            ):
                columns = shown(signal_model, np.array([channel]), -missing[:, None])[None]
                yield Shape(("share",), columns, {"level": level - zero})
                flat.append(level)
        if flat:
            levels = top - span * np.array(SOFT)
            missing = np.maximum(by_others[:, None] - levels, 0.0)
            columns = each_shown(signal_model, np.array([channel]), -missing)
            names = tuple(one_at("share", f"{level - zero:.1f} N") for level in levels)
            within = dict.fromkeys(names, (-MOST_SHARE, MOST_SHARE))
            yield Shape(names, columns, {"level": flat[-1] - zero}, within=within)


class Hysteresis:
    """Outputs depend on the direction in which the load goes: behind it, or ahead of it."""

    identifier, group = "hysteresis", "load_cell"
    components = (Component("fraction", "", 0.03, form=3.0),)

    def places(self, signal_model: SignalModel) -> Iterator[Place]:
        """Every cell, and all of a foot alike."""
        return places.cells_and_feet(signal_model)

    def shapes(self, signal_model: SignalModel, place: Place) -> Iterator[Shape]:
        """A play operator, its width a share of each cell's usual range; or all widths at once."""
        channels = places.channels_at(signal_model, place)
        each = [shown(signal_model, channels, loop[:, channels]) for loop in signal_model.loops]
        for columns in each:
            yield Shape(("fraction",), columns[None])
        names = tuple(one_at("fraction", f"{width:.0%}") for width in LOOP_WIDTHS)
        yield Shape(names, np.array(each))


CREEP_TIMES = (3.0, 8.0, 20.0, 60.0)
"""Time constants of recovery [s]."""


class Creep:
    """After a change of load the output goes on growing for a while, or comes back in part."""

    identifier, group = "creep", "load_cell"
    components = (
        Component("fraction", "", 0.03, form=4.0), Component("time", "s", 30.0, form=4.0)
    )  # fmt: skip

    def places(self, signal_model: SignalModel) -> Iterator[Place]:
        """Every cell, and all of a foot alike."""
        return places.cells_and_feet(signal_model)

    def shapes(self, signal_model: SignalModel, place: Place) -> Iterator[Shape]:
        """One exponential, of several time constants; or all of them at once."""
        channels = places.channels_at(signal_model, place)
        each = []
        for time in CREEP_TIMES:

            def work(track: Track, time: float = time) -> FloatArray:
                force = signal_model.parameters.outputs(track.readings)[:, channels]
                return low_passed(force, track.time, time)

            columns = shown(signal_model, channels, signal_model.samples.decimated(work))
            each.append(columns)
            yield Shape(("fraction",), columns[None], {"time": time})
        names = tuple(one_at("fraction", f"{time:g} s") for time in CREEP_TIMES)
        yield Shape(names, np.array(each))


class ZeroOffset:
    """Zeros of one run differ from those of the others, and stay there: a load or a tare."""

    identifier, group = "zero_offset", "load_cell"
    components = (Component("offset", "N", 3.0, as_built="run_zero_n"),)

    def places(self, signal_model: SignalModel) -> Iterator[Place]:
        """Every cell, each foot's alike, all alike."""
        return places.cells_feet_and_all(signal_model)

    def shapes(self, signal_model: SignalModel, place: Place) -> Iterator[Shape]:
        """Each channel at the place shows as much more in one run, and right in all others."""
        channels = places.channels_at(signal_model, place)
        for run in np.unique(signal_model.samples.run).tolist():
            here = (signal_model.samples.run == run).astype(np.float64)
            yield Shape(("offset",), shown(signal_model, channels, here[:, None])[None], run=run)


class ZeroDrift:
    """Zeros wander with time, or with temperature."""

    identifier, group = "zero_drift", "load_cell"
    components = (
        Component("rate", "N/s", 3e-3), Component("per_kelvin", "N/K", 0.1),
        Component("zero", "N", 0.5),
    )  # fmt: skip

    def places(self, signal_model: SignalModel) -> Iterator[Place]:
        """Every cell, each foot's alike, all alike."""
        return places.cells_feet_and_all(signal_model)

    def shapes(self, signal_model: SignalModel, place: Place) -> Iterator[Shape]:
        """Over time or temperature; several channels all alike, or each at a rate of its own. Or
        all alike along any course, by how far zeros are off at some times.
        """
        channels = places.channels_at(signal_model, place)
        for name, course in courses(signal_model):
            values = np.repeat(course[:, None], len(channels), axis=1)
            yield from _alike_or_each(signal_model, channels, name, values)
        times, hats = knots(signal_model.samples.clock)
        columns = each_shown(signal_model, channels, hats)
        yield Shape(tuple(one_at("zero", f"{time:.0f} s") for time in times), columns)


class SpanDrift:
    """Gains wander with time, or with temperature."""

    identifier, group = "span_drift", "load_cell"
    components = (Component("rate", "1/s", 2e-4), Component("per_kelvin", "1/K", 5e-3))

    def places(self, signal_model: SignalModel) -> Iterator[Place]:
        """Every cell, each foot's alike, all alike."""
        return places.cells_feet_and_all(signal_model)

    def shapes(self, signal_model: SignalModel, place: Place) -> Iterator[Shape]:
        """Over time or temperature; several channels all alike, or each at a rate of its own."""
        channels = places.channels_at(signal_model, place)
        for name, course in courses(signal_model):
            values = course[:, None] * signal_model.outputs[:, channels]
            yield from _alike_or_each(signal_model, channels, name, values)


class StuckCell:
    """A cell's reading stays where it was."""

    identifier, group = "stuck_cell", "load_cell"
    components = (Component("share", "", 1.0, 0.3), Component("time", "s", 100.0))

    def places(self, signal_model: SignalModel) -> Iterator[Place]:
        """Every cell."""
        return places.each_cell(signal_model)

    def shapes(self, signal_model: SignalModel, place: Place) -> Iterator[Shape]:
        """From the start of each run on; the other channels give what is missing."""
        (channel,) = places.channels_at(signal_model, place)
        samples = signal_model.samples
        # Whatever the gain: compared with another cell, in volts that move as they do under load.
        own = [i for i in places.vertical(samples.shoe) if i != channel]
        others = samples.readings[:, own[int(np.argmax(np.std(samples.readings[:, own], axis=0)))]]
        for start in sorted({track.start for track in samples.tracks}):
            late = samples.clock >= start
            if np.count_nonzero(late) < 10 or not _flat(
                signal_model.samples.readings[late, channel], others[late], FLAT_STUCK
            ):
                continue
            before = ~late if not late.all() else late
            by_others = expected(signal_model, int(channel), before)
            level = float(np.median(signal_model.outputs[late, channel]))
            missing = np.where(late, level - by_others, 0.0)
            columns = shown(signal_model, np.array([channel]), missing[:, None])[None]
            yield Shape(("share",), columns, {"time": start})


def _flat(shown_: FloatArray, expected: FloatArray, share: float) -> bool:
    """Whether a channel hardly moved while it should have."""
    return bool(np.std(shown_) <= share * np.std(expected))


def _alike_or_each(
    signal_model: SignalModel, channels: IntArray, name: str, values: FloatArray
) -> Iterator[Shape]:
    """What shows as values (T, k) a unit: by one number for all channels, or by one for each."""
    yield Shape((name,), shown(signal_model, channels, values)[None])
    if len(channels) > 1:
        each = [shown(signal_model, channels[[at]], values[:, [at]]) for at in range(len(channels))]
        names = signal_model.samples.shoe.names
        yield Shape(tuple(one_of(name, names[at]) for at in channels), np.array(each))


def courses(signal_model: SignalModel) -> Iterator[tuple[str, FloatArray]]:
    """(T,) what drifts can follow: the session's time [s], and the temperature [K] if it changes.

    Over time evenly, or as what warms up: first fast, then slowly, at the same rate on average.
    """
    samples = signal_model.samples
    yield "rate", samples.clock
    lasts = float(samples.clock.max())
    warmed = -np.expm1(-samples.clock / (WARM_UP * lasts)) / -np.expm1(-1.0 / WARM_UP)
    yield "rate", lasts * warmed
    if all(track.temperature is not None for track in samples.tracks):
        temperature = samples.decimated(lambda track: np.asarray(track.temperature)[:, None])[:, 0]
        if np.ptp(temperature) > 0.5:
            yield "per_kelvin", temperature - temperature[0]


def expected(signal_model: SignalModel, channel: int, right: BoolArray) -> FloatArray:
    """(T,) what one cell should feel by the others [N].

    Plates and weight tie a shoe's channels to each other: each follows from the others by a linear
    law, whatever gains and offsets are. It is that of the samples (T,) in which the cell is taken
    to be right.
    """
    others = np.delete(signal_model.outputs, channel, axis=1)
    spread = np.maximum(others.std(axis=0), LEAST_SPREAD)
    matrix = np.column_stack((np.ones(len(others)), (others - others.mean(axis=0)) / spread))
    rows = matrix[right]
    normal = rows.T @ rows + RIDGE * max(len(rows), 1) * np.eye(matrix.shape[1])
    law = np.linalg.solve(normal, rows.T @ signal_model.outputs[right, channel])
    found: FloatArray = matrix @ law
    return found
