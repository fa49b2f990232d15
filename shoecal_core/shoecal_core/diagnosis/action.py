"""What to do about what was found, in one line, and what it is expected to win."""

from __future__ import annotations

from collections.abc import Mapping

from shoecal_core.diagnosis.result import Action, Diagnosis

CURES: Mapping[str, str] = {
    "nonlinearity": "exchange the cell {place}, or keep it to loads at which it is straight",
    "saturation": "give the cell {place} a larger range, or its amplifier a smaller gain",
    "hysteresis": "check {place} for friction in its mounting, then exchange the cell",
    "creep": "wait under load before recording; if {place} creeps on, exchange the cell",
    "zero_offset": "correct the zeros of {place} from feet in the air: --rezero",
    "zero_drift": "warm up {place} before recording, then correct the zeros: --rezero",
    "span_drift": "warm up {place} before recording, and calibrate at that temperature",
    "stuck_cell": "check cable and amplifier of {place}, then exchange the cell",
    "swapped_cells": "exchange the cables of {place}, or their channels in the shoe file",
    "crosstalk": "check ground and supply of {place}, and where the second one is mounted",
    "cell_position": "measure where {place} is mounted, and correct its position in the shoe file",
    "off_axis_load": "decouple the cells of {place} from sideways forces",
    "latency": "correct the stamps of {place} by the delay found",
    "low_pass": "shorten the filter of {place}, in the amplifier or the driver",
    "total_mass": "weigh the robot, and pass its weight: --weight-kg",
    "payload": "take the mass off {place}, or enter it in the robot's URDF",
    "link_com": "correct the centre of mass of {place} in the robot's URDF",
    "joint_offset": "set the encoder zero of {place}",
    "joint_compliance": "check gears and mounting of {place}",
    "backlash": "check the play in the gears of {place}",
    "foot_placement": "check how the shoe of {place} sits, or correct its sole in the robot file",
    "slip": "repeat the run in which {place} slipped, on a floor with more grip",
    "floor_tilt": "level the floor, or record elsewhere",
    "soft_ground": "record on a hard floor",
    "inertia": "record slower motions",
}
"""By effect; of a user's own there is none."""


def action(diagnosis: Diagnosis) -> Action:
    """The first thing that a person should do.

    What is confused is separated first, where a motion can; then the most probable cause is
    corrected. The expected gain is the shrink of the gap on the test runs.
    """
    gap = diagnosis.gap
    before = gap.cop_mae_mm
    if diagnosis.verdict == "no_gap":
        return Action("nothing: CoP and GRF are those of a robot as built", (before, before))
    if not diagnosis.causes:
        return Action(f"look for what is off {_where(diagnosis)}", (before, gap.cop_floor_mm))
    shrink = diagnosis.shrink or diagnosis.causes[0].shrink
    following = diagnosis.next_motion
    if following is not None:
        parted = " from ".join(following.separates[:2])
        return Action(
            f"record the motion {following.motion} to separate {parted}", shrink.cop_mae_mm
        )
    first = diagnosis.causes[0]
    alike = [one for one in diagnosis.causes if one.effect == first.effect]
    places = dict.fromkeys(name for one in alike for name in one.location)
    where = " and ".join(places) or "the robot"
    cure = CURES.get(first.effect, f"look into {first.effect.replace('_', ' ')} at {{place}}")
    numbers = sorted({one.run for one in alike if one.run is not None})
    runs = f" (run{'s'[: len(numbers) > 1]} {', '.join(map(str, numbers))})" if numbers else ""
    return Action(f"{cure.format(place=where)}{runs}", shrink.cop_mae_mm)


def _where(diagnosis: Diagnosis) -> str:
    """The place that holds most of the gap."""
    if not diagnosis.where:
        return "in GRF and CoP"
    most = max(diagnosis.where, key=lambda place: place.share)
    foot = f" of the {most.foot} foot" if most.foot else ""
    run = f", mostly in run {most.run}" if most.run is not None else ""
    return f"in {most.signal}{foot}{run}"
