"""What was found, in a line for a person: the place, the size, the cure."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from shoecal_core.arrays import BoolArray, FloatArray
from shoecal_core.samples.stretches import list_stretches
from shoecal_core.screening.carrying import MovingFoot
from shoecal_core.screening.clocks import LARGEST_S
from shoecal_core.screening.closure import Slipped
from shoecal_core.screening.faults import Fault
from shoecal_core.screening.imu import WrongMount
from shoecal_core.screening.pulled import Pull, Wavering
from shoecal_core.screening.result import LeftOut
from shoecal_core.screening.saturated import Saturated
from shoecal_core.screening.sideways import SidewaysFault
from shoecal_core.screening.soles import Soles, pooled
from shoecal_core.screening.units import OtherUnit
from shoecal_core.screening.unresponsive import Stuck
from shoecal_core.screening.verdict import Finding
from shoecal_core.screening.wandering import Wandering
from shoecal_core.screening.weights import WrongWeight
from shoecal_core.screening.wiring import WiringFaults, mirrored, of_feet
from shoecal_core.screening.zeros import MovedZeros
from shoecal_core.shoe.shoe import FEET, Shoe

NOTABLE: Mapping[Fault, float] = {
    Fault.UNREADABLE: 0.2,
    Fault.TOO_FAST: 0.02,
    Fault.DISTURBED: 0.2,
    Fault.LIFTED: 0.0,
}
"""Share of a run's samples from which their loss is a warning; less is only counted."""
NOTABLE_SPIKES = 3
"""Samples with spikes in one channel and run from which its cable is suspected."""
USELESS_SHARE, USELESS_END_SHARE = 0.01, 0.2
"""A channel that is saturated for more of the time is no use: unknown to its device, and known."""
MAX_TIME_OFFSET_S = 0.05
"""Clocks of joints and readings that are further apart are named."""

_CURES: Mapping[Fault, tuple[str, str]] = {
    Fault.UNREADABLE: (
        "has no readings, bad or repeated ones, or no joint angles at the same time",
        "check the device's status and rate of sampling, and that both have stamps of one clock",
    ),
    Fault.TOO_FAST: ("moved too fast to be taken as standing still", "plan a slower motion"),
    Fault.DISTURBED: (
        "was disturbed",
        "see that nothing touches the robot, and that its gears and floor are firm",
    ),
    Fault.LIFTED: (
        "had one foot in the air or on its edge",
        "see that it is not lifted and that the motion keeps load on both feet",
    ),
}


def of_soles(found: Mapping[int, Soles]) -> list[Finding]:
    """Runs whose soles are not level by the joint angles, those of one cause together."""
    return [
        Finding("FAIL", f"{_runs(runs)}: {soles.text}", Fault.JOINT_ZERO)
        for runs, soles in pooled(found)
    ]


def of_moving_feet(found: Mapping[int, MovingFoot]) -> list[Finding]:
    """Walks in which the foot that carries does not stay; those of one cause together."""
    runs: dict[str, list[int]] = {}
    for number, one in sorted(found.items()):
        runs.setdefault(_why_it_moves(one), []).append(number)
    findings = []
    for why, numbers in runs.items():
        speed = max(found[number].speed for number in numbers)
        tilt = max(found[number].tilt for number in numbers)
        share = max(found[number].share for number in numbers)
        text = (
            f"{_runs(numbers)}: by base pose and joint angles the foot that carries the robot "
            f"alone moves for {share:.0%} of that time, by {speed:.2f} m/s, and leans by "
            f"{np.degrees(tilt):.0f} degrees (medians; it should stand still and flat): {why}"
        )
        fault = Fault.SWAPPED if found[numbers[0]].exchanged else Fault.BASE_POSE
        findings.append(Finding("FAIL", text, fault))
    return findings


def _why_it_moves(one: MovingFoot) -> str:
    """The cause of a foot that moves while it carries, and the cure."""
    if one.frozen:
        return (
            "the recorded base pose never changes; record the pose that the state estimator or "
            "motion capture gives while the robot walks"
        )
    if one.exchanged and one.upwards:
        return (
            "the other foot does instead, so left and right are exchanged; exchange their plugs, "
            "their topics, or feet.*.link in the robot file, and record again"
        )
    if one.exchanged:
        return (
            "the other foot does instead, and forces are negative, so both vertical forces are "
            "inverted; turn their 'polarity' in the shoe file round"
        )
    if one.shifted:
        return (
            f"it would with {one.shifted} {1e3 * abs(one.late_s):.0f} ms "
            f"{'earlier' if one.late_s > 0.0 else 'later'}; let base pose, joints and readings be "
            "stamped when they are sampled, by one clock"
        )
    return (
        "check the base pose (that it is the pose of the URDF's root link in a frame with z up, in "
        "m, its angles' order and unit), then signs and zeros of the leg joints"
    )


def of_imu(found: WrongMount | None) -> list[Finding]:
    """An IMU that is mounted otherwise than its frame says."""
    return [] if found is None else [Finding("FAIL", found.text, Fault.IMU)]


def of_units(shoe: Shoe, found: Sequence[OtherUnit]) -> list[Finding]:
    """Six-axis sensors that read in other units than the shoe file says."""
    return [
        Finding(
            "FAIL",
            f"{one.kind} look like {one.name} "
            f"({', '.join(shoe.names[channel] for channel in one.channels)}): {one.shown_by}; "
            f"multiply the nominal_gain of all {one.kind} "
            f"by {one.size:.6g} in the shoe file (or set 'scale' in the mapping of a CSV import)",
            Fault.UNIT,
        )
        for one in found
    ]


def of_dead(shoe: Shoe, channels: Sequence[int]) -> list[Finding]:
    """Channels that never answer."""
    return [
        Finding(
            "FAIL",
            f"{shoe.names[channel]} does not answer to load: check its cable, then record again",
            Fault.DEAD,
        )
        for channel in channels
    ]


def of_dead_feet(feet: Mapping[int, int]) -> list[Finding]:
    """Feet of which nothing answers in single runs."""
    findings = []
    for foot, name in enumerate(FEET):
        runs = sorted(run for run, one in feet.items() if one == foot)
        if runs:
            text = (
                f"nothing of the {name} foot answers in {_runs(runs)}, though it does in others: "
                "check its plug and its driver, then record again, or leave these runs out"
            )
            findings.append(Finding("FAIL", text, Fault.DEAD))
    return findings


def of_stuck(shoe: Shoe, found: Sequence[Stuck]) -> list[Finding]:
    """Channels that stopped answering, each with all its stretches."""
    findings = []
    for channel in sorted({one.channel for one in found}):
        own = [one for one in found if one.channel == channel]
        places = ", ".join(f"run {one.run} from {one.start:.0f} to {one.end:.0f} s" for one in own)
        findings.append(
            Finding(
                "FAIL",
                f"{shoe.names[channel]} is stuck at {own[0].level:.4g} {shoe.unit} while its "
                f"neighbours move ({places}): check its cable, then record again, or leave these "
                "runs out",
                Fault.STUCK,
            )
        )
    return findings


def of_wiring(shoe: Shoe, wiring: WiringFaults) -> list[Finding]:
    """Cells upside down or at each other's place."""
    if wiring.swapped and set(wiring.swapped) == set(of_feet(shoe)):
        return [
            Finding(
                "FAIL",
                "left and right are exchanged: what comes as one foot's fits the other; exchange "
                "their plugs, their topics, or feet.*.link in the robot file, and record again",
                Fault.SWAPPED,
            )
        ]
    if wiring.swapped and set(wiring.swapped) == set(mirrored(shoe)):
        return [
            Finding(
                "FAIL",
                "left and right are exchanged as in a mirror: what comes as one cell fits that at "
                "the same place of the other foot, seen from the middle; exchange the plugs or "
                "names of both feet cell by cell, and record again",
                Fault.SWAPPED,
            )
        ]
    frames = _turned_frames(shoe, wiring)
    known = {channel for _, channels in frames for channel in channels}
    findings = [Finding("FAIL", text, Fault.INVERTED) for text, _ in frames]
    findings += [
        Finding(
            "FAIL",
            f"{shoe.names[one]} and {shoe.names[other]} are swapped: what comes as one fits the "
            "other's place; exchange their cables, or their names at the driver, and record again",
            Fault.SWAPPED,
        )
        for one, other in wiring.swapped
        if one not in known
    ]
    findings += [
        Finding(
            "FAIL",
            f"{shoe.names[one]} and {shoe.names[twin]} contradict each other: one of the two is "
            "inverted, which of them is not known; push the standing robot along that axis: both "
            "must show a force against the push; exchange the signal wires of the one that does "
            "not, or turn its 'polarity' round",
            Fault.INVERTED,
        )
        for one, twin in wiring.contradicting
    ]
    return findings + [
        Finding(
            "FAIL",
            f"{shoe.names[channel]} is inverted: its sign is against the shoe file; exchange its "
            "signal wires, or turn its 'polarity' round",
            Fault.INVERTED,
        )
        for channel in wiring.inverted
        if channel not in known
    ]


def _turned_frames(shoe: Shoe, wiring: WiringFaults) -> list[tuple[str, tuple[int, ...]]]:
    """Six-axis sensors of which several axes are wrong as in a frame that is turned as a whole.

    Each in words, with the channels that it explains. Sideways forces are not judged: of both feet
    turned alike they cancel, and who corrects only what was named leaves them wrong.
    """
    alike: dict[tuple[str, str], dict[str, tuple[int, ...]]] = {}
    for foot in FEET:
        axes = {axis: f"{foot}/{axis}" for axis in ("fz", "mx", "my")}
        if not set(axes.values()) <= set(shoe.names):
            continue
        at = {axis: shoe.index(name) for axis, name in axes.items()}
        swapped = (min(at["mx"], at["my"]), max(at["mx"], at["my"])) in wiring.swapped
        inverted = tuple(axis for axis, index in at.items() if index in wiring.inverted)
        how = _TURNED.get((swapped, inverted))
        if how is not None:
            wrong = sorted({*inverted, *(("mx", "my") if swapped else ())})
            channels = tuple(at[axis] for axis in wrong)
            alike.setdefault((", ".join(wrong), how), {})[foot] = channels
    found = list[tuple[str, tuple[int, ...]]]()
    for (listed, how), feet in alike.items():
        text = (
            f"several axes of the {' and '.join(feet)} foot's sensor are wrong ({listed}), as if "
            f"{how}; correct the sensor's frame at its driver, or names and 'polarity' of all its "
            "axes in the shoe file, and push the standing robot forward and to the left to see fx "
            "and fy"
        )
        found.append((text, tuple(one for channels in feet.values() for one in channels)))
    return found


_QUARTER = (
    "its frame were turned by 90 degrees about z, and then fx and fy are exchanged and one of them "
    "is reversed, too"
)
_TURNED: Mapping[tuple[bool, tuple[str, ...]], str] = {
    (True, ("mx",)): _QUARTER,
    (True, ("my",)): _QUARTER,
    (False, ("mx", "my")): (
        "its frame were turned by 180 degrees about z, and then fx and fy are reversed, too"
    ),
    (False, ("fz", "my")): "its z pointed down, turned about x, and then fy is reversed, too",
    (False, ("fz", "mx")): "its z pointed down, turned about y, and then fx is reversed, too",
    (False, ("fz", "mx", "my")): (
        "it gave what the foot presses on the floor instead of what the floor presses on the "
        "foot, and then fx and fy are reversed, too"
    ),
}
"""What is inverted, and whether the moments are swapped, where the whole frame is turned."""


def of_sideways(found: SidewaysFault | None) -> list[Finding]:
    """Sideways axes of six-axis sensors that do not cancel as they are."""
    if found is None:
        return []
    ways = ", or ".join(" and ".join(way) for way in found.ways)
    return [
        Finding(
            "FAIL",
            "the feet's sideways forces do not cancel while the robot stands on both; they would "
            f"with {ways}: push the standing robot forward and to the left to see, then correct "
            "the axes' polarity or names in the shoe file, or the sensor's frame at its driver",
            Fault.INVERTED,
        )
    ]


def of_saturated(shoe: Shoe, found: Sequence[Saturated]) -> list[Finding]:
    """Channels that reached an end."""
    return [
        Finding(
            "FAIL" if one.share > USELESS_SHARE else "WARN",
            f"{shoe.names[one.channel]} is saturated: it goes no further than {one.level:.4g} "
            f"{shoe.unit}, where it is for {one.share:.1%} of the time"
            f"{'' if np.isnan(one.missing) else f', with {one.missing:.1f} N missing'}: lower its "
            "amplification",
            Fault.SATURATED,
        )
        for one in found
    ]


def of_ends(shoe: Shoe, ends: BoolArray, readings: FloatArray) -> list[Finding]:
    """Channels at the end of their converter's range: every such reading counts, in use too.

    Args:
        ends: (T, n) which of the readings (T, n) are at an end.
    """
    share = ends.mean(axis=0)
    useless = share > USELESS_END_SHARE
    findings = []
    for verdict, channels in (("FAIL", useless), ("WARN", (share > 0.0) & ~useless)):
        if not channels.any():
            continue
        names = [shoe.names[channel] for channel in np.flatnonzero(channels)]
        there = ends & channels
        count = int(there.any(axis=1).sum())
        levels = np.unique(readings[there & np.isfinite(readings)])
        level = f", at {levels[0]:.10g} {shoe.unit}" if len(levels) == 1 else ""
        one = len(names) == 1
        findings.append(
            Finding(
                verdict,
                f"{', '.join(names)} {'is' if one else 'are'} at the end of "
                f"{'its' if one else 'their'} range in {count / len(ends):.1%} of the samples "
                f"({count} of {len(ends)} messages{level}), where the converter goes no further: "
                f"lower {'its' if one else 'their'} amplification or check "
                f"{'its' if one else 'their'} wiring",
                Fault.SATURATED,
            )
        )
    return findings


def of_zeros(shoe: Shoe, found: MovedZeros, weight: float) -> list[Finding]:
    """Channels that were zeroed between the runs."""
    tare = (
        "the cells were zeroed (tare) under load between the runs; take the tare out of the "
        "firmware (HX711 libraries do it in setup()), or keep the boards powered from the first "
        "run to the last, and record again"
    )
    if found.tared:
        before = " and ".join(
            f"the {FEET[foot]} foot before {_runs(runs)}" for foot, runs in found.tared.items()
        )
        text = (
            f"all readings of a loaded foot start at zero ({before}), which hides what it carried: "
            f"{tare}"
        )
        return [Finding("FAIL", text, Fault.MOVED_ZEROS)]
    than = _runs(found.reference)
    if found.channels:
        names = [shoe.names[one] for one in found.channels]
        text = (
            f"the zeros of {_runs(found.less)} are not those of {than}: {', '.join(names)} "
            f"{'start' if names[1:] else 'starts'} at zero there, which hides what the foot "
            f"carried: {tare}"
        )
        return [Finding("FAIL", text, Fault.MOVED_ZEROS)]
    if found.less:
        less = (
            f"{_runs(found.less)} {'read' if found.less[1:] else 'reads'} "
            f"{found.part or weight:.1f} N less than {than}, "
        )
        text = (
            f"{less}each by as much: if the robot carried nothing and was not held, some of {tare}"
            if found.part
            else f"{less}all of the robot's weight: {tare}"
        )
        return [Finding("FAIL", text, Fault.MOVED_ZEROS)]
    moved = " and ".join(f"{1e3 * one:.0f}" for one in found.cop.values())
    text = (
        f"the zeros of {_runs(tuple(found.cop))} are not those of {than}: the CoP "
        f"moves by {moved} mm with them, at the same weight; {tare}"
    )
    return [Finding("FAIL", text, Fault.MOVED_ZEROS)]


def _runs(numbers: Sequence[int]) -> str:
    """Some runs, in words."""
    *others, last = map(str, sorted(numbers))
    return f"runs {', '.join(others)} and {last}" if others else f"run {last}"


def of_wandering(shoe: Shoe, found: Wandering) -> list[Finding]:
    """A cell whose zero does not stay."""
    return [
        Finding(
            "FAIL",
            f"the zero of {shoe.names[found.channel]} wanders by {found.force:.1f} N between and "
            "within the runs: look for water, a loose cable, or a cell that was overloaded; "
            "replace it and record again",
            Fault.MOVED_ZEROS,
        )
    ]


def of_weights(found: Sequence[WrongWeight]) -> list[Finding]:
    """Runs under another weight; the last two together when it is unknown which is right."""
    if len(found) > 1 and found[-1].undecided:
        one, other = found[-2:]
        apart = (abs(one.excess) + abs(other.excess)) / 2.0
        undecided = [
            Finding(
                "FAIL",
                f"runs {one.run} and {other.run} were recorded under weights {apart:.1f} N apart "
                "and no third run shows which is right: see that the robot carries nothing and is "
                "not held, then record again",
                Fault.WRONG_WEIGHT,
            )
        ]
        return of_weights(found[:-2]) + undecided
    return [
        Finding(
            "WARN",
            f"run {one.run} was recorded with {abs(one.excess):.1f} N "
            f"{'more' if one.excess > 0.0 else 'less'} on the feet than the others (limit "
            f"{one.limit:.1f} N) and is left out: see that the robot carries nothing and is not "
            "held, then record it again",
            Fault.WRONG_WEIGHT,
        )
        for one in found
    ]


def of_wavering(found: Wavering) -> list[Finding]:
    """A vertical force that varies in most runs."""
    vary = "vary" if found.runs[1:] else "varies"
    return [
        Finding(
            "FAIL",
            f"the vertical forces of {_runs(found.runs)} {vary} by up to {found.force:.1f} N "
            "while the robot only leans, whatever the cells' gains and zeros are: take off the "
            "rope or cable, do not touch the robot, see that the cells' supply voltage is steady, "
            "and record again",
            Fault.PULLED,
        )
    ]


def of_pulls(found: Sequence[Pull]) -> list[Finding]:
    """Forces from outside; with one other run alone, nothing else can be checked."""
    return [
        Finding(
            "FAIL" if one.undecided else "WARN",
            f"run {one.run}: a force from outside of up to {abs(one.force):.1f} N "
            f"{'pressed the robot down' if one.force > 0.0 else 'held the robot up'} "
            f"({list_stretches(one.stretches)}), while it only leant"
            f"{'' if one.undecided else ', left out'}: take off the rope or cable, do not "
            "touch the robot, and record the run again"
            f"{'' if one.undecided else ', or leave it out (--train)'}",
            Fault.PULLED,
        )
        for one in found
    ]


def of_slips(slips: Mapping[int, Slipped]) -> list[Finding]:
    """Feet that slipped."""
    return [
        Finding(
            "WARN",
            f"a foot slipped in run {run} at {slip.time:.1f} s (by the joint angles, "
            f"{1e3 * np.linalg.norm(slip.shift[:2]):.1f} mm and {np.degrees(slip.shift[2]):.1f} "
            "deg): where it came to rest is not known, so what came after is left out; record the "
            "run again",
            Fault.SLIPPED,
        )
        for run, slip in slips.items()
    ]


def of_left_out(found: Sequence[LeftOut]) -> list[Finding]:
    """Samples left out, where they are more than a good recording has."""
    findings = []
    for one in found:
        times = list_stretches(one.stretches)
        if one.fault is Fault.SPIKE and one.samples >= NOTABLE_SPIKES:
            findings.append(
                Finding(
                    "WARN",
                    f"{', '.join(one.channels)} gave spikes in run {one.run} ({times}), left "
                    "out: check the cable and its shield",
                    one.fault,
                )
            )
        elif one.share > NOTABLE.get(one.fault, 1.0):
            happened, cure = _CURES[one.fault]
            findings.append(
                Finding(
                    "WARN",
                    f"run {one.run} {happened} for {one.share:.0%} of its samples"
                    f"{f' ({times})' if times else ''}, left out: {cure}",
                    one.fault,
                )
            )
        elif one.fault is Fault.TOO_LITTLE:
            findings.append(
                Finding(
                    "WARN",
                    f"run {one.run} is left out: too little of it can be used; record it again",
                    one.fault,
                )
            )
    return findings


def of_time_offset(time_offset: float) -> list[Finding]:
    """Joints and readings that are far apart in time; the fit is spared that."""
    if abs(time_offset) <= MAX_TIME_OFFSET_S:
        return []
    if abs(time_offset) >= 0.99 * LARGEST_S:
        return [
            Finding(
                "FAIL",
                f"joints and readings are {LARGEST_S:g} s apart or more, which is not corrected: "
                "let both be stamped when they are sampled, by one clock",
                Fault.LATE,
            )
        ]
    return [
        Finding(
            "WARN",
            f"joints are {'late' if time_offset > 0.0 else 'early'} by "
            f"{1e3 * abs(time_offset):.0f} ms against the readings, which is corrected in the fit: "
            "let both be stamped when they are sampled, by one clock",
            Fault.LATE,
        )
    ]


def of_clock_rate(rate: float) -> list[Finding]:
    """A clock that runs faster than the other one, which no constant offset puts right."""
    if rate == 0.0:
        return []
    return [
        Finding(
            "FAIL",
            f"the shoe's clock runs {100.0 * abs(rate):.2g}% {'fast' if rate > 0.0 else 'slow'} "
            "against the joints', so their stamps drift apart within each run: let both be stamped "
            "by one clock as they come in, or correct the clock of the board (its crystal or its "
            "timer's divider), and record again",
            Fault.LATE,
        )
    ]
