"""What to do about what was found, in one line, and what it is expected to win."""

from __future__ import annotations

from shoecal_core.diagnosis.result import Action, Diagnosis
from shoecal_core.error_sources.effects.words import words_of


def action(diagnosis: Diagnosis) -> Action:
    """The first thing that a person should do.

    What is confused is separated first, where a motion can; then the most probable cause is
    corrected. The expected gain is the shrink of the gap on the test runs.
    """
    gap = diagnosis.gap
    before = gap.cop_mae_mm
    if diagnosis.verdict == "no_gap":
        return Action(
            "nothing: CoP and GRF agree with the model as well as on any robot that works",
            (before, before),
        )
    if not diagnosis.named:
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
    numbers = sorted({one.run for one in alike if one.run is not None})
    runs = f" (run{'s'[: len(numbers) > 1]} {', '.join(map(str, numbers))})" if numbers else ""
    return Action(f"{words_of(first.effect).cure.format(place=where)}{runs}", shrink.cop_mae_mm)


def _where(diagnosis: Diagnosis) -> str:
    """The place that holds most of the gap."""
    if not diagnosis.where:
        return "in GRF and CoP"
    most = max(diagnosis.where, key=lambda place: place.share)
    foot = f" of the {most.foot} foot" if most.foot else ""
    run = f", mostly in run {most.run}" if most.run is not None else ""
    return f"in {most.signal}{foot}{run}"
