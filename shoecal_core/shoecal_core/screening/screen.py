"""The screening of a recording: every fault in turn, the gravest first.

What is wrong with a cell or a cable spoils the whole session: it is named, and nothing else is
looked for. What is wrong with a run or a moment of it costs that run or that moment.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from shoecal_core.recording.run import Run
from shoecal_core.samples.aligned import Aligned
from shoecal_core.samples.lifting import detect_lifted_foot
from shoecal_core.samples.stretches import JOIN_S, stretches
from shoecal_core.screening.blocks import Blocks, blocks
from shoecal_core.screening.cells.codes import (
    dead_bands,
    describe_dead_bands,
    describe_missing_codes,
    missing_codes,
)
from shoecal_core.screening.cells.exchanged_runs import describe_exchanged_runs, exchanged_runs
from shoecal_core.screening.cells.same_readings import describe_same_readings, same_readings
from shoecal_core.screening.cells.saturated import (
    at_ends_or_marked,
    describe_ends,
    describe_saturated,
    ended,
    within_range,
)
from shoecal_core.screening.cells.unresponsive import (
    dead,
    dead_feet,
    describe_dead,
    describe_dead_feet,
    describe_stuck,
    stuck,
    stuck_channels,
)
from shoecal_core.screening.cells.wrapped import describe_wrapped, wrapped
from shoecal_core.screening.cells.zero_jumps import describe_zero_jumps, zero_jumps
from shoecal_core.screening.clocks.jumps import describe_clock_jump
from shoecal_core.screening.clocks.smoothed import describe_smoothed
from shoecal_core.screening.clocks.time_offsets import describe_clock_rate, describe_time_offset
from shoecal_core.screening.clocks.timing import Timing
from shoecal_core.screening.faults import Fault
from shoecal_core.screening.joints.angle_steps import describe_steps, without_motion
from shoecal_core.screening.joints.dropouts import describe_dropouts
from shoecal_core.screening.joints.legs import Legs
from shoecal_core.screening.joints.loose_encoders import describe_loose_encoder
from shoecal_core.screening.loads.disturbed import FAST_MOTIONS
from shoecal_core.screening.pose.carrying import describe_moving_feet
from shoecal_core.screening.pose.imu import describe_imu, wrong_imu
from shoecal_core.screening.pose.soles import describe_soles
from shoecal_core.screening.result import LeftOut, Screening, describe_left_out
from shoecal_core.screening.rough_fit import Statics
from shoecal_core.screening.settings import CalibrationSettings
from shoecal_core.screening.six_axis.units import describe_units, other_units, units_of_walks
from shoecal_core.screening.standing import screen_standing
from shoecal_core.screening.twins import describe_twins, find_twins
from shoecal_core.screening.verdict import Finding
from shoecal_core.shoe.shoe import Shoe

CROSSED = (Fault.SWAPPED, Fault.INVERTED)
"""Faults that let the CoP move in other directions than the robot, as a delay does."""


def screen(
    runs: Mapping[int, Run],
    aligned: Mapping[int, Aligned],
    shoe: Shoe,
    weight: float,
    settings: CalibrationSettings,
    timing: Timing = Timing(),  # noqa: B008 - it cannot change
    legs: Legs = Legs(),  # noqa: B008 - nor can it
) -> Screening:
    """Look for every fault.

    Runs that name no double support are only searched for faults of single cells.

    Args:
        runs: by number.
        aligned: the same with the model's values.
        weight: of robot and shoes [N].
        timing: before the runs were aligned.
        legs: what is wrong with their angles.
    """
    runs, aligned = dict(sorted(runs.items())), dict(sorted(aligned.items()))
    double = {
        number: one for number, one in aligned.items() if runs[number].info.support is not None
    }
    jumps = zero_jumps(shoe, {number: runs[number] for number in double})
    numbers = describe_same_readings(shoe, same_readings(runs)) if runs else []
    numbers += describe_wrapped(shoe, wrapped(runs))
    # Else what the CoP says of the clocks is that fault's.
    known = timing.explained or numbers or jumps or legs.wrong
    found = Screening(
        findings=() if known else tuple(describe_time_offset(timing.late)),
        time_offset=timing.late,
        samples={number: len(run.readings.time) for number, run in runs.items()},
        left_out=_lost(runs, aligned, shoe),
    )
    if not runs:
        return found
    found = found.adding(describe_twins(find_twins(runs)))
    # Jumps and held values look like every fault of cells and clocks.
    # What wraps lacks the codes between its ends.
    found = found.adding(numbers or describe_missing_codes(shoe, missing_codes(runs)))
    found = found.adding(describe_dead_bands(shoe, dead_bands(runs)))
    # A held angle, off by more than anything else, looks like a zero that moves, and that like a
    # lifted foot.
    found = found.adding(describe_zero_jumps(jumps))
    held = describe_dropouts(legs.dropouts)
    found = found.adding(held or describe_loose_encoder(legs.loose))
    if found.fails:
        return found
    parts = {number: blocks(within_range(shoe, one), shoe) for number, one in aligned.items()}
    if not legs.soles:  # else what the legs say of the CoP is wrong
        # Exchanged feet look like stuck cells, other weights and other gains.
        standing = {number: parts[number] for number in double}
        exchanged = (
            exchanged_runs(Statics.of(shoe, standing, weight, settings)) if standing else None
        )
        found = found.adding(describe_exchanged_runs(exchanged))
        if found.fails:
            return found
        walks = {number: one for number, one in aligned.items() if number not in double}
        units = other_units(shoe, double, weight, settings) or units_of_walks(shoe, walks, weight)
        found = found.adding(describe_units(shoe, units))
    if found.fails:
        return found
    found = found.adding(describe_left_out(found.left_out) + _cells(runs, parts, shoe))
    found = found.adding(describe_steps(legs.step, settings) + describe_soles(legs.soles))
    if not found.fails:  # else a dead foot seems to carry never or always
        found = found.adding(describe_moving_feet(legs.moving))
    if not legs.soles:  # else the legs say nothing about the IMU
        found = found.adding(describe_imu(wrong_imu(runs, double)))
    if not found.fails:  # else what the CoP shows of filter and clocks is that fault's
        found = found.adding(describe_smoothed(timing.smoothed))
        found = found.adding(describe_clock_jump(timing.jump))
        found = found.adding(describe_clock_rate(timing.clock_rate))
    if found.fails or not double:
        return found
    lifting = {
        number: detect_lifted_foot(runs[number].info.motion, one) for number, one in double.items()
    }
    fast = {number for number in double if runs[number].info.motion in FAST_MOTIONS}
    starts = {number: runs[number].start_ns / 1e9 for number in double}
    whole = screen_standing(found, double, lifting, fast, starts, shoe, weight, settings)
    findings = without_motion(whole.findings) if legs.step else whole.findings
    return replace(whole, findings=_without_delay(findings))


def _without_delay(findings: Sequence[Finding]) -> tuple[Finding, ...]:
    """Without what a CoP of cells at wrong places says of the clocks."""
    crossed = any(one.verdict == "FAIL" and one.fault in CROSSED for one in findings)
    return tuple(one for one in findings if not (crossed and one.fault is Fault.LATE))


def _lost(
    runs: Mapping[int, Run], aligned: Mapping[int, Aligned], shoe: Shoe
) -> tuple[LeftOut, ...]:
    """Samples that were recorded and could not be aligned."""
    lost = []
    for number, run in runs.items():
        ends = at_ends_or_marked(shoe, run.readings)
        gone = ~np.isin(run.readings.time, aligned[number].time)
        for fault, marked in (
            (Fault.SATURATED, gone & ends.any(axis=1)),
            (Fault.UNREADABLE, gone & ~ends.any(axis=1)),
        ):
            count = int(marked.sum())
            if count:
                faulty = np.flatnonzero(np.any(ends[marked], axis=0))
                lost.append(
                    LeftOut(
                        number,
                        fault,
                        count,
                        count / len(marked),
                        stretches(marked, run.readings.time, JOIN_S),
                        tuple(shoe.names[index] for index in faulty),
                    )
                )
    return tuple(lost)


def _cells(runs: Mapping[int, Run], parts: Mapping[int, Blocks], shoe: Shoe) -> list[Finding]:
    """Faults of single cells, for which no model is needed."""
    ends = np.concatenate([at_ends_or_marked(shoe, run.readings) for run in runs.values()])
    silent = dead(shoe, parts)
    found = stuck_channels(shoe, parts, silent)
    at_end = ended(parts, found)
    ends_of = {end.channel for end in at_end}
    still = stuck(parts, [one for one in found if one.channel not in ends_of])
    return [
        *describe_dead(shoe, silent),
        *describe_dead_feet(dead_feet(shoe, parts)),
        *describe_ends(shoe, ends, np.concatenate([run.readings.value for run in runs.values()])),
        *describe_saturated(shoe, at_end),
        *describe_stuck(shoe, still),
    ]
