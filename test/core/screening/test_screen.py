"""The whole screening: faults of every kind, in a few draws each; none in clean recordings."""

from __future__ import annotations

import json
import re
from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from core.screening.recordings import (
    SETTINGS,
    WEIGHT,
    Recording,
    read_coarsely,
    recording,
    turned,
)
from shoecal_core.arrays import FloatArray
from shoecal_core.recording.run import Run
from shoecal_core.recording.schemas import NO_DATA, SATURATED
from shoecal_core.screening.cells.wiring import WiringFaults, describe_wiring, mirrored, of_feet
from shoecal_core.screening.faults import Fault
from shoecal_core.screening.result import Screening
from shoecal_core.screening.screen import screen

Spoil = Callable[[Recording, np.random.Generator], Recording]


def screened(whole: Recording, runs: dict[int, Run] | None = None) -> Screening:
    return screen(runs or whole.runs, whole.aligned, whole.shoe, WEIGHT, SETTINGS)


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize("bits", [24, 12, 10])
def test_nothing_is_said_of_clean_recordings(seed: int, bits: int) -> None:
    whole = recording(seed, count=3 + seed)
    found = screened(whole if bits == 24 else read_coarsely(whole, bits, 0.008, seed))
    assert found.findings == ()
    assert found.runs_left_out == ()
    assert all(kept.mean() > 0.997 for kept in found.kept.values())


@pytest.mark.parametrize("noise", [0.5, 1.0])
@pytest.mark.parametrize("seed", range(3))
def test_noise_is_no_force_from_outside(seed: int, noise: float) -> None:
    found = screened(recording(seed, noise=noise))
    assert {one.fault for one in found.findings} <= {Fault.SPIKE}


# ---- a cell or a cable: the session is refused ------------------------------------------------


def dead(whole: Recording, rng: np.random.Generator) -> Recording:
    return whole.with_channel(2, lambda _, one: 0.3 + 0.001 * rng.standard_normal(len(one)))


def stuck(whole: Recording, rng: np.random.Generator) -> Recording:
    start = int(rng.integers(300, 1900))
    return whole.with_channel(
        2, lambda run, one: np.where((np.arange(len(one)) < start) | (run < 2), one, one[start])
    )


def saturated(whole: Recording, rng: np.random.Generator) -> Recording:
    side = float(np.sign(whole.parameters.gain[2]))
    everything = np.concatenate([one.readings[:, 2] for one in whole.aligned.values()])
    level = np.quantile(side * everything, rng.uniform(0.75, 0.95))
    return whole.with_channel(2, lambda _, one: side * np.minimum(side * one, level))


def preloaded(whole: Recording, rng: np.random.Generator) -> Recording:
    """For a seventh of the time, or for most of it."""
    side = float(np.sign(whole.parameters.gain[2]))
    everything = np.concatenate([one.readings[:, 2] for one in whole.aligned.values()])
    level = np.quantile(side * everything, rng.choice([0.15, 0.7]))

    def held(_: int, one: FloatArray) -> FloatArray:
        trembling = np.std(np.diff(one, n=2)) / np.sqrt(6.0) * rng.standard_normal(len(one))
        return np.asarray(np.where(side * one > level, one, side * level + trembling))

    return whole.with_channel(2, held)


def inverted(whole: Recording, rng: np.random.Generator) -> Recording:
    del rng
    return whole.with_channel(2, lambda _, one: -one)


def swapped(whole: Recording, rng: np.random.Generator) -> Recording:
    other = int(rng.choice([0, 1, 3, 4, 5, 6, 7]))
    order = np.arange(8)
    order[[2, other]] = other, 2
    return whole.with_readings(lambda _, values: values[:, order])


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize(
    ("spoil", "fault", "words"),
    [
        (dead, Fault.DEAD, "does not answer to load: check its cable"),
        (stuck, Fault.STUCK, "is stuck at"),
        (saturated, Fault.SATURATED, "is saturated: it goes no further than"),
        (preloaded, Fault.SATURATED, "does not answer to low load: it stays at"),
        (inverted, Fault.INVERTED, "is inverted: its sign is against the shoe file"),
        (swapped, Fault.SWAPPED, "are swapped"),
    ],
)
def test_a_bad_cell_is_named(seed: int, spoil: Spoil, fault: Fault, words: str) -> None:
    rng = np.random.default_rng(seed)
    found = screened(spoil(recording(seed, count=5), rng))
    assert found.fails
    assert {finding.fault for finding in found.findings} == {fault}
    (finding,) = found.findings
    assert "left/rear_left" in finding.reason
    assert words in finding.reason


def test_the_end_of_the_converter_is_a_warning_while_it_is_told_and_seldom() -> None:
    whole = recording()
    run = whole.runs[2]
    status = run.readings.status.copy()
    at_end = run.readings.value[:, 1] > np.quantile(run.readings.value[:, 1], 0.9)
    status[at_end, 1] = SATURATED
    flagged = replace(run, readings=replace(run.readings, status=status))
    cut = whole.with_run(2, **vars(whole.aligned[2].part(~at_end)))
    found = screened(cut, {**whole.runs, 2: flagged})
    (finding,) = found.findings
    assert finding.verdict == "WARN"
    assert finding.reason.startswith("left/front_right is at the end of its range in 3.3%")
    (lost,) = found.left_out
    assert (lost.run, lost.fault, lost.channels) == (2, Fault.SATURATED, ("left/front_right",))
    assert lost.samples == at_end.sum()


def test_a_converter_at_its_ceiling_is_no_force_from_outside() -> None:
    """Of fewer bits than the shoe file says, for 0.4 s, four times a run."""

    def at_ceiling(run: int, readings: FloatArray) -> FloatArray:
        for start in (300, 900, 1500, 2400):
            readings[start : start + 40] = 2047.0
        return readings

    (finding,) = screened(recording(count=4).with_channel(2, at_ceiling)).findings
    assert (finding.verdict, finding.fault) == ("WARN", Fault.SATURATED)
    assert "is at the end of its range in 5.3% of the samples" in finding.reason
    assert "at 2047 V" in finding.reason


def test_counts_in_place_of_volts_are_at_no_end() -> None:
    counts = recording().with_readings(lambda _, values: np.rint(2e5 * values) + 3e5)
    (finding,) = screened(counts).findings
    assert (finding.verdict, finding.fault) == ("FAIL", Fault.UNIT)
    assert "are they counts, or in another unit? Give 'scale' in the mapping" in finding.reason


# ---- a run: it is left out --------------------------------------------------------------------


def carrying(whole: Recording, run: int, newtons: float) -> Recording:
    share = newtons / len(whole.shoe.names) / whole.parameters.gain
    return whole.with_readings(lambda number, values: values + (share if number == run else 0.0))


@pytest.mark.parametrize("newtons", [-5.0, 2.0])
def test_a_run_under_another_weight_is_left_out(newtons: float) -> None:
    found = screened(carrying(recording(count=5), 4, newtons))
    (finding,) = found.findings
    assert (finding.verdict, finding.fault) == ("WARN", Fault.WRONG_WEIGHT)
    more = "more" if newtons > 0 else "less"
    assert finding.reason.startswith(f"run 4 was recorded with {abs(newtons):.1f} N {more}")
    assert found.runs_left_out == (4,)
    (lost,) = found.left_out
    assert (lost.run, lost.fault, lost.share) == (4, Fault.WRONG_WEIGHT, 1.0)


def test_a_load_on_one_cell_is_the_only_fault_of_its_run() -> None:
    whole = recording(3, count=4)
    gain = whole.parameters.gain[0]
    found = screened(whole.with_channel(0, lambda run, one: one + (5.0 / gain) * (run == 2)))
    (finding,) = found.findings
    assert finding.fault == Fault.WRONG_WEIGHT
    assert found.runs_left_out == (2,)


def test_two_runs_that_do_not_agree_are_refused() -> None:
    found = screened(carrying(recording(count=2), 1, 6.0))
    (finding,) = found.findings
    assert finding.verdict == "FAIL"
    assert "runs 1 and 2 were recorded under weights 5.9 N apart" in finding.reason


def pulling(whole: Recording, run: int, share: float, start: float, end: float) -> Recording:
    """A rope that holds up to a share of the weight, most halfway, by the left foot's cells."""
    own = whole.shoe.of_foot(0)
    time = whole.aligned[run].time
    pull = np.interp(time, [start, (start + end) / 2.0, end], [0.0, -share * WEIGHT, 0.0])

    def pulled(number: int, values: FloatArray) -> FloatArray:
        if number == run:
            values[:, own] += pull[:, None] / len(own) / whole.parameters.gain[own]
        return values

    return whole.with_readings(pulled)


@pytest.mark.parametrize("share", [-0.2, 0.05, 0.1, 0.2])
@pytest.mark.parametrize(("start", "end"), [(6.0, 14.0), (1.0, 29.0)])
def test_a_pull_for_a_while_is_named_with_times_and_newtons(
    share: float, start: float, end: float
) -> None:
    whole = pulling(recording(count=5), 4, share, start, end)
    found = screened(whole)
    finding = found.findings[0]
    assert (finding.verdict, finding.fault) == ("WARN", Fault.PULLED)
    words = re.fullmatch(
        r"run 4: a force from outside of up to (\S+) N (.*) \(at (\S+) to (\S+) s\), while.*",
        finding.reason,
    )
    assert words is not None
    assert float(words[1]) == pytest.approx(abs(share) * WEIGHT, rel=0.15)
    assert words[2] == ("held the robot up" if share > 0 else "pressed the robot down")
    middle = (start + end) / 2.0
    assert start < float(words[3]) < middle < float(words[4]) < end
    assert "take off the rope or cable" in finding.reason
    near = np.abs(whole.aligned[4].time - middle) < 0.2 * (end - start)
    assert not found.kept[4][near].any()
    assert {one.fault for one in found.findings} <= {Fault.PULLED, Fault.TOO_LITTLE}


def test_a_pull_on_one_of_two_runs_refuses_the_session() -> None:
    (finding,) = screened(pulling(recording(count=2), 2, 0.2, 6.0, 14.0)).findings
    assert (finding.verdict, finding.fault) == ("FAIL", Fault.PULLED)
    assert finding.reason.startswith("run 2: a force from outside of up to ")
    assert "--train" not in finding.reason


def test_what_comes_after_a_slip_is_left_out() -> None:
    whole = recording(count=4)
    one = whole.aligned[3]
    after = one.time >= 18.0
    states = replace(
        one.states,
        translation=one.states.translation + np.where(after[:, None], [0.002, -0.001, 0.0], 0.0),
        rotation=turned(one.states.yaw + np.where(after, 0.01, 0.0)),
    )
    pattern = np.array([1.0, -1.0, -0.5, 0.5, -1.0, 1.0, 0.5, -0.5]) / whole.parameters.gain
    readings = one.readings + np.where(after[:, None], pattern, 0.0)
    found = screened(whole.with_run(3, states=states, readings=readings))
    (finding,) = found.findings
    assert (finding.verdict, finding.fault) == ("WARN", Fault.SLIPPED)
    assert "a foot slipped in run 3 at 17.9 s" in finding.reason
    assert not found.kept[3][one.time > 17.6].any()
    assert found.kept[3][one.time < 17.0].mean() > 0.99
    assert not found.standing[3][one.time > 17.6].any()


def test_a_run_of_which_little_is_left_is_left_out() -> None:
    whole = recording(count=4)
    one = whole.aligned[2]
    up = one.time > 8.0
    high = np.where(up, 0.006, 0.0)[:, None] * [0.0, 0.0, 1.0]
    # It is where most samples are that a foot stands.
    states = replace(one.states, translation=one.states.translation + high)
    found = screened(whole.with_run(2, states=states))
    assert found.runs_left_out == ()
    both = np.where((one.time > 9.0) & (one.time < 29.9), 0.006 * (np.sin(one.time * 40) > 0), 0)
    states = replace(
        one.states, translation=one.states.translation + both[:, None] * [0.0, 0.0, 1.0]
    )
    found = screened(whole.with_run(2, states=states))
    assert found.runs_left_out == (2,)
    assert any(finding.fault is Fault.TOO_LITTLE for finding in found.findings)


# ---- moments: they are left out ---------------------------------------------------------------


def test_spikes_are_left_out_and_their_cable_is_named() -> None:
    rng = np.random.default_rng(9)
    at = rng.choice(2900, 20, replace=False)

    def jumping(run: int, one: FloatArray) -> FloatArray:
        if run == 2:
            one[at] += rng.choice([-1.0, 1.0], 20) * rng.uniform(0.2, 4.0, 20)
        return one

    found = screened(recording().with_channel(5, jumping))
    (finding,) = found.findings
    assert (finding.verdict, finding.fault) == ("WARN", Fault.SPIKE)
    assert "right/front_right gave spikes in run 2" in finding.reason
    assert not found.kept[2][at].any()
    (lost,) = found.left_out
    assert lost.samples == np.sum(~found.kept[2]) == 20
    assert lost.channels == ("right/front_right",)


def test_a_single_spike_is_only_counted() -> None:
    def jumping(run: int, one: FloatArray) -> FloatArray:
        if run == 1:
            one[700] += 1.0
        return one

    found = screened(recording().with_channel(0, jumping))
    assert found.findings == ()
    (lost,) = found.left_out
    assert (lost.run, lost.fault, lost.samples) == (1, Fault.SPIKE, 1)
    assert lost.stretches == ((7.0, 7.0),)


def test_a_push_is_left_out_with_a_margin() -> None:
    whole = recording()

    def pushed(run: int, values: FloatArray) -> FloatArray:
        if run == 3:
            values[1200:1230] += np.array([4, 4, 0, 0, 0, 0, -4, -4]) / whole.parameters.gain
        return values

    found = screened(whole.with_readings(pushed))
    assert found.findings == ()
    (lost,) = found.left_out
    assert (lost.run, lost.fault) == (3, Fault.DISTURBED)
    ((start, end),) = lost.stretches
    assert 11.7 < start < 11.9
    assert 12.4 < end < 12.6


@pytest.mark.parametrize(("motion", "count"), [("landmarks", 1), ("faster", 0)])
def test_gears_that_strike_in_a_fast_motion_are_no_warning(motion: str, count: int) -> None:
    whole = recording()

    def struck(run: int, values: FloatArray) -> FloatArray:
        if run == 3:
            for start in range(100, len(values) - 100, 100):
                values[start : start + 10] += (
                    np.array([4, 4, 0, 0, 0, 0, -4, -4]) / whole.parameters.gain
                )
        return values

    whole = whole.with_readings(struck)
    info = replace(whole.runs[3].info, motion=motion)
    found = screened(whole, {**whole.runs, 3: replace(whole.runs[3], info=info)})
    assert [one.fault for one in found.findings] == count * [Fault.DISTURBED]
    assert (3, Fault.DISTURBED) in [(one.run, one.fault) for one in found.left_out]


def test_haste_is_left_out_and_told() -> None:
    whole = recording()
    one = whole.aligned[1]
    hasty = (one.time > 20.0) & (one.time < 23.0)
    sway = np.where(hasty, 0.02 * np.sin(6.0 * np.pi * (one.time - 20.0)) ** 1, 0.0)
    com = one.states.com + sway[:, None, None] * [1.0, 0.0, 0.0]
    found = screened(whole.with_run(1, states=replace(one.states, com=com)))
    told = [finding for finding in found.findings if finding.fault is Fault.TOO_FAST]
    assert len(told) == 1
    assert "run 1 moved too fast to be taken as standing still" in told[0].reason
    assert not found.kept[1][hasty].any()


# ---- what is not recorded ---------------------------------------------------------------------


def test_unreadable_samples_are_counted() -> None:
    whole = recording()
    run = whole.runs[1]
    value, status = run.readings.value.copy(), run.readings.status.copy()
    value[500:1300, 3], status[500:1300, 3] = np.nan, NO_DATA
    gap = replace(run, readings=replace(run.readings, value=value, status=status))
    good = np.ones(len(value), dtype=bool)
    good[500:1300] = False
    cut = whole.with_run(1, **vars(whole.aligned[1].part(good)))
    found = screened(cut, {**whole.runs, 1: gap})
    (finding,) = found.findings
    assert finding.fault is Fault.UNREADABLE
    assert "for 27% of its samples (at 5.0 to 13.0 s)" in finding.reason
    (lost,) = found.left_out
    assert (lost.samples, lost.channels) == (800, ())


def test_figures_for_machines() -> None:
    found = screened(carrying(recording(count=3), 2, 6.0)).to_json()
    assert found["samples"] == {"1": 3000, "2": 3000, "3": 3000}
    assert found["runs_left_out"] == [2]
    assert found["time_offset_s"] == 0.0
    assert '"fault": "wrong_weight", "samples": 3000, "share": 1.0' in json.dumps(found["left_out"])
    assert '"verdict": "WARN", "fault": "wrong_weight"' in json.dumps(found["findings"])


def test_no_runs_no_findings() -> None:
    shoe = recording().shoe
    assert screen({}, {}, shoe, WEIGHT, SETTINGS) == Screening()


def test_exchanged_feet_are_told_in_one_line() -> None:
    shoe = recording().shoe
    (finding,) = describe_wiring(shoe, WiringFaults((), tuple(of_feet(shoe))))
    assert finding.reason.startswith("left and right are exchanged")
    assert len(describe_wiring(shoe, WiringFaults((), ((0, 4), (1, 5))))) == 2


def test_feet_exchanged_as_in_a_mirror_are_told_in_one_line() -> None:
    whole = recording(count=4)
    pairs = mirrored(whole.shoe)
    assert {whole.shoe.names[one] for one, _ in pairs} == {
        name for name in whole.shoe.names if name.startswith("left/")
    }
    order = np.arange(len(whole.shoe.names))
    for one, other in pairs:
        order[[one, other]] = other, one
    (finding,) = screened(whole.with_readings(lambda _, values: values[:, order])).findings
    assert finding.fault is Fault.SWAPPED
    assert finding.reason.startswith("left and right are exchanged as in a mirror")
