"""Columns of the cells' effects are what readings show that have the effect by its definition."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from core.error_sources.altered import Work, with_forces
from core.error_sources.shows import assert_shows, shape, told
from shoecal_core.arrays import FloatArray
from shoecal_core.error_sources.effects import load_cell
from shoecal_core.error_sources.effects.places import channels_at
from shoecal_core.error_sources.signal_model import SignalModel
from shoecal_core.samples.samples import Track
from shoecal_core.shoe.wrench import ChannelParameters

CELLS = ("left/front_left", "right/rear_right")


def at(signal_model: SignalModel, place: str, work: Work) -> SignalModel:
    """With what only some channels show changed."""
    channels = channels_at(signal_model, (place,))

    def changed(track: Track, force: FloatArray) -> FloatArray:
        whole = force.copy()
        whole[:, channels] = work(track, force[:, channels])
        return whole

    return with_forces(signal_model, changed)


@pytest.mark.parametrize("cell", CELLS)
def test_nonlinearity(signal_model: SignalModel, cell: str) -> None:
    quadratic, cubic = 1e-3, 3e-5
    zero = load_cell.unloaded(signal_model, int(channels_at(signal_model, (cell,))[0]))
    after = at(
        signal_model, cell, lambda _, f: f + quadratic * (f - zero) ** 2 + cubic * (f - zero) ** 3
    )
    found = shape(signal_model, load_cell.Nonlinearity(), cell)
    assert_shows(signal_model, after, told(found, quadratic, cubic))


def waves(values: FloatArray, ends: tuple[float, float], seed: int) -> FloatArray:
    """A drawn smooth curve with up to two bends that is zero at both ends, and beyond."""
    share = np.clip((values - ends[0]) / (ends[1] - ends[0]), 0.0, 1.0)
    sizes = np.random.default_rng(seed).normal(0.0, 0.05, 2)
    return np.asarray(sum(a * np.sin((k + 1) * np.pi * share) for k, a in enumerate(sizes)))


@pytest.mark.parametrize(("cell", "seed"), [(CELLS[0], 1), (CELLS[1], 2), (CELLS[1], 3)])
def test_a_cell_may_bend_along_any_curve(signal_model: SignalModel, cell: str, seed: int) -> None:
    channel = int(channels_at(signal_model, (cell,))[0])
    zero = load_cell.unloaded(signal_model, channel)
    low, high = np.percentile(signal_model.outputs[:, channel], (1.0, 99.0))
    after = at(signal_model, cell, lambda _, f: f + waves(f, (low, high), seed))
    found = shape(signal_model, load_cell.Nonlinearity(), cell, form=1)
    loads = [float(name.split()[2]) for name in found.free]
    assert np.ptp(loads) == pytest.approx((high - low) * 5.0 / 7.0, abs=0.1)
    sizes = waves(np.array(loads) + zero, (low, high), seed)
    assert_shows(signal_model, after, told(found, *sizes), within=0.15)


@pytest.mark.parametrize("place", [CELLS[0], "left", "all"])
def test_zeros_may_drift_along_any_course(signal_model: SignalModel, place: str) -> None:
    low, high = np.percentile(signal_model.samples.clock, (1.0, 99.0))

    def drifted(track: Track, force: FloatArray) -> FloatArray:
        return force + waves(np.asarray(track.start + track.time), (low, high), 4)[:, None]

    found = list(load_cell.ZeroDrift().shapes(signal_model, (place,)))[-1]
    times = np.linspace(low, high, load_cell.KNOTS)[1:-1]
    assert found.free == tuple(f"zero at {time:.0f} s" for time in times)
    after = at(signal_model, place, drifted)
    assert_shows(signal_model, after, told(found, *waves(times, (low, high), 4)), within=0.15)


@pytest.mark.parametrize("effect", [load_cell.Hysteresis(), load_cell.Creep()])
def test_a_cell_may_remember_in_all_its_ways_at_once(
    signal_model: SignalModel, effect: load_cell.Hysteresis | load_cell.Creep
) -> None:
    *single, together = effect.shapes(signal_model, ("right",))
    assert len(set(together.free)) == len(single) == len(together.columns)
    for one, column in zip(single, together.columns, strict=True):
        np.testing.assert_array_equal(one.columns[0], column)


@pytest.mark.parametrize("cell", CELLS)
def test_a_saturated_cell_misses_what_the_others_tell(signal_model: SignalModel, cell: str) -> None:
    (channel,) = channels_at(signal_model, (cell,))
    force = signal_model.outputs[:, channel]
    level = float(force.max() - 0.3 * np.ptp(force))
    after = at(signal_model, cell, lambda _, f: np.minimum(f, level))
    shapes = list(load_cell.Saturation().shapes(after, (cell,)))
    zero = load_cell.unloaded(after, int(channel))
    best = min(shapes, key=lambda one: abs(one.fixed["level"] + zero - level))
    assert best.fixed["level"] + zero == pytest.approx(level, abs=0.02 * np.ptp(force))
    assert best.free == ("share",)
    assert_shows(signal_model, after, told(best, 1.0), within=0.15)


@pytest.mark.parametrize("cell", CELLS)
def test_a_cell_may_saturate_softly(signal_model: SignalModel, cell: str) -> None:
    """What bends over a range that begins half way is a sum of what is missing above some loads."""
    force = signal_model.outputs[:, channels_at(signal_model, (cell,))[0]]
    low, top = np.percentile(force, 5.0), force.max()
    knee, width = top - 0.5 * (top - low), 0.5 * (top - low)

    def bent(_: Track, force: FloatArray) -> FloatArray:
        over = np.clip((force - knee) / width, 0.0, 1.0)
        return np.asarray(np.minimum(force, knee) + width * (over - 0.5 * over**2))

    after = at(signal_model, cell, bent)
    found = list(load_cell.Saturation().shapes(after, (cell,)))[-1]
    assert len(found.free) == len(load_cell.SOFT)
    change = (after.residuals - signal_model.residuals).ravel()
    columns = found.columns.reshape(len(found.free), -1).T
    left = change - columns @ np.linalg.lstsq(columns, change, rcond=None)[0]
    assert np.linalg.norm(left) < 0.25 * np.linalg.norm(change)


def test_saturation_is_seen_whatever_gains_were_fitted(signal_model: SignalModel) -> None:
    """A cell that ends early bends all gains; how cells follow from each other it does not."""
    cell = CELLS[0]
    (channel,) = channels_at(signal_model, (cell,))
    force = signal_model.outputs[:, channel]
    after = at(signal_model, cell, lambda _, f: np.minimum(f, force.max() - 0.3 * np.ptp(force)))
    gain = after.parameters.gain * np.array([0.6, 1.4, 1.2, 0.7, 1.0, 1.3, 0.8, 1.1])
    bent = after.with_parameters(ChannelParameters(gain, after.parameters.offset))
    assert list(load_cell.Saturation().shapes(bent, (cell,)))
    assert not list(load_cell.Saturation().shapes(bent, (CELLS[1],)))
    at_top = load_cell.expected(after, int(channel), force <= np.median(force))
    np.testing.assert_allclose(at_top, force, atol=0.05 * np.ptp(force))


def test_a_cell_that_moves_freely_is_not_saturated(signal_model: SignalModel) -> None:
    for (cell,) in load_cell.Saturation().places(signal_model):
        assert not list(load_cell.Saturation().shapes(signal_model, (cell,)))


def play(force: FloatArray, width: FloatArray) -> FloatArray:
    """A pin in a slot of this width (k,), dragged along by a force (F, k)."""
    pin, found = force[0], []
    for one in force:
        pin = np.clip(pin, one - width / 2.0, one + width / 2.0)
        found.append(pin)
    return np.array(found)


@pytest.mark.parametrize("place", ["left/front_left", "right"])
def test_hysteresis(signal_model: SignalModel, place: str) -> None:
    fraction = 0.1
    span = signal_model.usual_range[channels_at(signal_model, (place,))]
    after = at(signal_model, place, lambda _, f: play(f, fraction * span))
    found = shape(signal_model, load_cell.Hysteresis(), place)
    assert_shows(signal_model, after, told(found, fraction), within=0.06)


def test_what_a_cell_shows_in_the_air_is_its_zero(signal_model: SignalModel) -> None:
    """However the offsets of a foot's cells are shifted against each other."""
    parameters = signal_model.parameters
    shift = np.array([1.0, -1.0, 1.0, -1.0, 2.0, -2.0, 2.0, -2.0])
    other = signal_model.with_parameters(
        ChannelParameters(parameters.gain, parameters.offset + shift)
    )
    for channel in range(8):
        moved = load_cell.unloaded(other, channel) - load_cell.unloaded(signal_model, channel)
        hanging = ~signal_model.samples.loaded[:, signal_model.samples.shoe.foot[channel]]
        known = np.count_nonzero(hanging) >= load_cell.LEAST_HANGING
        assert moved == pytest.approx(shift[channel] if known else 0.0)


def test_the_loop_s_whole_width_is_the_fraction_of_the_range(signal_model: SignalModel) -> None:
    for loop in signal_model.loops[:2]:
        height = np.ptp(loop, axis=0) / signal_model.usual_range
        np.testing.assert_allclose(height, 1.0, atol=0.1)
    # What lags shows too little where the force comes up, and too much where it goes down.
    rate = np.gradient(signal_model.outputs, axis=0)
    assert (np.sum(rate * signal_model.loops[0], axis=0) < 0.0).all()


@pytest.mark.parametrize(("place", "form"), [("left/front_left", 1), ("right", 3)])
def test_creep(signal_model: SignalModel, place: str, form: int) -> None:
    found = shape(signal_model, load_cell.Creep(), place, form=form)
    fraction, constant = 0.05, found.fixed["time"]

    def work(track: Track, force: FloatArray) -> FloatArray:
        crept = [force[0]]
        for step, one in zip(np.diff(track.time), force[1:], strict=True):
            crept.append(crept[-1] + (1.0 - np.exp(-step / constant)) * (one - crept[-1]))
        return force + fraction * np.array(crept)

    assert_shows(signal_model, at(signal_model, place, work), told(found, fraction))


@pytest.mark.parametrize("place", [*CELLS, "left", "all"])
@pytest.mark.parametrize("run", [2, 8])
def test_zeros_of_one_run(signal_model: SignalModel, place: str, run: int) -> None:
    offset = 0.02
    after = at(signal_model, place, lambda track, f: f + offset * (track.run == run))
    forms = {one.run: one for one in load_cell.ZeroOffset().shapes(signal_model, (place,))}
    assert_shows(signal_model, after, told(forms[run], offset))
    assert not forms[run].columns[:, signal_model.samples.run != run].any()


def test_zeros_may_be_off_in_every_run_and_at_every_vertical_force(
    signal_model: SignalModel,
) -> None:
    effect = load_cell.ZeroOffset()
    names = signal_model.samples.shoe.names
    assert {place for (place,) in effect.places(signal_model)} == {*names, "left", "right", "all"}
    runs = [one.run for one in effect.shapes(signal_model, ("all",))]
    assert runs == list(signal_model.samples.runs)


@pytest.mark.parametrize("place", [*CELLS, "left", "all"])
def test_drifts_in_time(signal_model: SignalModel, place: str) -> None:
    def age(track: Track) -> FloatArray:
        return np.asarray(track.start + track.time)[:, None]

    zero = at(signal_model, place, lambda track, f: f + 3e-4 * age(track))
    assert_shows(signal_model, zero, told(shape(signal_model, load_cell.ZeroDrift(), place), 3e-4))
    span = at(signal_model, place, lambda track, f: f * (1.0 + 2e-5 * age(track)))
    assert_shows(signal_model, span, told(shape(signal_model, load_cell.SpanDrift(), place), 2e-5))


def test_drifts_with_temperature(signal_model: SignalModel) -> None:
    samples = signal_model.samples
    tracks = tuple(
        replace(track, temperature=25.0 + 4.0 * (1.0 - np.exp(-(track.start + track.time) / 200.0)))
        for track in samples.tracks
    )
    warm = replace(signal_model, samples=replace(samples, tracks=tracks))
    first = warm.samples.decimated(lambda track: np.asarray(track.temperature)[:, None])[0, 0]

    def warmer(track: Track) -> FloatArray:
        return np.asarray(np.asarray(track.temperature)[:, None] - first)

    zero, span = load_cell.ZeroDrift(), load_cell.SpanDrift()
    assert shape(warm, zero, "left", form=4).free == ("per_kelvin",)
    after = at(warm, "left", lambda track, f: f + 0.1 * warmer(track))
    assert_shows(warm, after, told(shape(warm, zero, "left", form=4), 0.1))
    after = at(warm, "left", lambda track, f: f * (1.0 + 0.003 * warmer(track)))
    assert_shows(warm, after, told(shape(warm, span, "left", form=4), 0.003))
    assert len(list(zero.shapes(signal_model, ("left",)))) == 5


@pytest.mark.parametrize("place", ["right", "all"])
def test_channels_of_one_place_drift_each_at_a_rate_of_its_own(
    signal_model: SignalModel, place: str
) -> None:
    """Whatever their signs: what they share is the warmth."""
    channels = channels_at(signal_model, (place,))
    rates = 2e-5 * np.random.default_rng(4).choice([-1.0, 0.5, 1.5], len(channels))

    def drifted(track: Track, force: FloatArray) -> FloatArray:
        age = np.asarray(track.start + track.time)[:, None]
        return np.asarray(force * (1.0 + rates * age))

    found = shape(signal_model, load_cell.SpanDrift(), place, form=1)
    names = [signal_model.samples.shoe.names[at] for at in channels]
    assert found.free == tuple(f"rate {name}" for name in names)
    assert_shows(signal_model, at(signal_model, place, drifted), told(found, *rates))


def test_drifts_as_what_warms_up_does(signal_model: SignalModel) -> None:
    """Fast at first: as far by the session's end as an even drift of the same rate."""
    even, warming = (
        shape(signal_model, load_cell.ZeroDrift(), "left", form=form) for form in (0, 2)
    )
    clock = signal_model.samples.clock
    course = 1.0 - np.exp(-clock / (0.3 * clock.max()))
    size = 0.5 / course.max()

    def warmer(track: Track, force: FloatArray) -> FloatArray:
        grown = 1.0 - np.exp(-(track.start + track.time) / (0.3 * clock.max()))
        return np.asarray(force + size * grown[:, None])

    assert_shows(
        signal_model,
        at(signal_model, "left", warmer),
        told(warming, 0.5 / clock.max()),
        within=0.05,
    )
    last = int(np.argmax(clock))
    np.testing.assert_allclose(warming.columns[0, last], even.columns[0, last])


@pytest.mark.parametrize("cell", CELLS)
def test_a_stuck_cell(signal_model: SignalModel, cell: str) -> None:
    start = signal_model.samples.tracks[2].start
    (channel,) = channels_at(signal_model, (cell,))
    late = signal_model.samples.clock >= start
    level = float(signal_model.outputs[np.argmax(late), channel])
    after = at(
        signal_model, cell, lambda track, f: np.full_like(f, level) if track.start >= start else f
    )
    found = {one.fixed["time"]: one for one in load_cell.StuckCell().shapes(after, (cell,))}
    assert min(found) == start
    assert_shows(signal_model, after, told(found[start], 1.0), within=0.2)
    assert not list(load_cell.StuckCell().shapes(signal_model, (cell,)))
