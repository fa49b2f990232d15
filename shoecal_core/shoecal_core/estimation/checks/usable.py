"""May this calibration be used? PASS, WARN or FAIL, with the reasons and the cures."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

import numpy as np

from shoecal_core.arrays import IntArray
from shoecal_core.estimation.freed_gears import FreedGears
from shoecal_core.estimation.joint_fit import FittedDeviation
from shoecal_core.estimation.known import Since
from shoecal_core.planning.supports.identifiability import Identifiability
from shoecal_core.recording.session import missing_text
from shoecal_core.robot.double_support import DoubleSupport
from shoecal_core.samples.zeros import Zero
from shoecal_core.screening.verdict import MOST_LISTED, Finding, list_reasons
from shoecal_core.shoe.shoe import FEET, Shoe
from shoecal_core.shoe.wrench import ChannelParameters

GAIN_RATIO = 5.0
"""Cells of one kind differ by less than this factor in gain."""
ZERO_WARN, ZERO_FAIL = 0.02, 0.05
"""What both feet show in the air, over the weight."""
SOLE_STDS = 5.0
"""Standard deviations as built, of one channel's place, from which a foot's forces act elsewhere:
all its channels are off alike."""
FAR_STDS = 4.0
"""Standard deviations as built from which the fit contradicts the robot's files. Of thirteen
healthy simulated robots, some as far off as tolerances say, the farthest is 1.6; a knee's zero that
is off by 50 mrad, or soles by 20 mm, come out as 7 and 8."""
REFUSED_STDS = 10.0
"""The same from which nothing holds that was expected of the errors: with the cells' places given
from the heel, 50 mm off, a CoM came out as 18, and the CoP was 38 mm off where 3 were expected."""
ROBOT_WORDS = {
    "joint_offset": ("the zero of {} is off by {:.0f} mrad", 1e3, "the zeros of the joints"),
    "link_com": (
        "the CoM of {} is off by {:.0f} mm", 1e3,
        "CoMs in the URDF (the soles' place, sole_xyz_m, or a sloping floor look the same)",
    ),
    "link_mass": ("the mass of {} is off by {:.0f} %", 1e2, "masses in the URDF"),
}  # fmt: skip
"""What the fit may find of the robot, in which unit a person reads it, and what to correct."""
MANY_ZEROS = 4
"""Joints whose zeros are far off at once, from which a length is the likelier cause: a lower leg
that is 20 mm longer moves the zeros of nine joints by 4 to 10 tolerances."""
STAYS = 0.75
"""Part of a far value from which it counts as the same where gears are free."""
FITS_BETTER = 0.8
"""Part of the misfit that free gears leave, below which they are likelier than what was far off.
Where gears that give by 10 mrad/(N m) were taken for zeros, they left 0.1 to 0.6, and the CoP of
a foot was 3 to 20 mm off where 3 to 4 were expected."""
SOLE_WORDS = {"x": ("behind", "in front"), "y": ("to the right", "to the left")}
"""What a shift against and along each axis of the sole is called."""
MOST_WIDTHS = 0.5
"""Expected CoP error, in half widths of the sensing polygon."""
STANDS_WIDTHS = 0.5
"""Half widths by which the CoP moves at least; planned motions take it from foot to foot, three
times as far and more."""
MOST_DIRECTIONS = 3
"""Directions without data in one reason; the report draws them all."""


def check_gains(shoe: Shoe, polarity: IntArray, parameters: ChannelParameters) -> list[Finding]:
    """Gains of the wrong sign or of a size unlike the others'.

    Args:
        shoe: of n channels.
        polarity: (n,) signs of their gains, 0 where unknown.
        parameters: of the calibration.
    """
    findings = []
    for torque in (False, True):
        kind = np.flatnonzero(shoe.torque == torque)
        if not len(kind):
            continue
        typical = float(np.median(np.abs(parameters.gain[kind])))
        for index in kind:
            gain, name = float(parameters.gain[index]), shoe.names[index]
            if np.sign(gain) * polarity[index] < 0:
                findings.append(
                    Finding(
                        "FAIL",
                        f"{name} came out with the wrong sign ({gain:g}): check its wiring and "
                        "its polarity in the shoe file",
                    )
                )
            elif not typical / GAIN_RATIO < abs(gain) < typical * GAIN_RATIO:
                findings.append(
                    Finding(
                        "FAIL",
                        f"{name} has gain {gain:g}, the others about {typical:g}: check that it "
                        "carries load",
                    )
                )
    return findings


def check_zeros(
    shoe: Shoe, zeros: Sequence[Zero], parameters: ChannelParameters, weight: float, *, own: bool
) -> list[Finding]:
    """Runs whose feet show a force in the air, by the calibration.

    Args:
        shoe: with the columns of the calibration.
        zeros: of the runs.
        parameters: of the calibration.
        weight: of robot and shoes [N].
        own: every run is judged with its own zeros.
    """
    shown: dict[int, dict[str, float]] = {}
    for zero in zeros:
        force, _ = zero.force(shoe, parameters)
        shown.setdefault(zero.run, {})[FEET[zero.foot]] = force
    off = {run: sum(map(abs, feet.values())) for run, feet in shown.items()}
    far = {run: feet for run, feet in shown.items() if off[run] > ZERO_WARN * weight}
    if not far:
        return []
    listed = "; ".join(
        f"run {run}: {', '.join(f'{foot} {force:+.0f} N' for foot, force in feet.items())}"
        for run, feet in list(far.items())[:MOST_LISTED]
    )
    worst = max(off[run] for run in far) / weight
    text = f"feet in the air do not read zero ({listed}; up to {worst:.0%} of the weight)"
    if own:
        return [
            Finding(
                "WARN",
                f"{text} unless each run's own zeros are used, as here: apply this calibration "
                "with them (evaluate --rezero, /shoe/rezero)",
            )
        ]
    return [
        Finding(
            "FAIL" if worst > ZERO_FAIL else "WARN",
            f"{text}: their zeros have changed between runs; use each run's own (--rezero, live "
            "/shoe/rezero)",
        )
    ]


def check_soles(shoe: Shoe, deviations: Sequence[FittedDeviation]) -> list[Finding]:
    """Feet of which all vertical forces act elsewhere by the data than by the files.

    Args:
        shoe: whose channels the deviations name.
        deviations: of the fit.
    """
    moved = []
    for foot, name in enumerate(FEET):
        own = {
            channel
            for channel, side, vertical in zip(shoe.names, shoe.foot, shoe.vertical, strict=True)
            if side == foot and vertical
        }
        for axis, words in SOLE_WORDS.items():
            found = [
                one
                for one in deviations
                if one.deviation.effect == "cell_position"
                and one.deviation.component == axis
                and own.issuperset(one.deviation.location)
            ]
            shift = float(np.mean([one.value for one in found])) if found else 0.0
            if found and abs(shift) > SOLE_STDS * found[0].deviation.std:
                moved.append(f"of the {name} foot {1e3 * abs(shift):.0f} mm {words[shift > 0.0]}")
    if not moved:
        return []
    return [
        Finding(
            "WARN",
            f"by the data the forces {' and '.join(moved)} of where the files say they act: check "
            "the soles' place in the robot file (feet.*.sole_xyz_m), then that of the sensors in "
            "the shoe file; soles may be off by more, as centres of mass take up a part",
        )
    ]


def check_robot(
    deviations: Sequence[FittedDeviation], free: Callable[[], FreedGears] | None = None
) -> list[Finding]:
    """What the fit takes the robot for, where that is far from what its files say.

    Args:
        deviations: of the fit.
        free: solves it once more with gears in every form, which is asked for where zeros are far
            off; None: it cannot be.
    """
    far = _far(deviations)
    if not far:
        return []
    verdict = "FAIL" if far[0][0] > REFUSED_STDS else "WARN"
    freed = free() if free and any(map(_of_zero, far)) else None
    stay, else_gears = (far, []) if freed is None else _split(far, freed)
    # Whichever it is, the fit that is used holds the far values.
    found = [Finding(verdict, _gears_or(else_gears, freed))] if freed and else_gears else []
    if not stay:
        return found
    zeros = sum(map(_of_zero, stay))
    many = (
        f" ({zeros} zeros at once: gears that give, or a link of the legs longer or shorter than "
        "in the URDF, look so)"
        if zeros >= MANY_ZEROS
        else ""
    )
    cures = dict.fromkeys(ROBOT_WORDS[one.deviation.effect][2] for _, one in stay[:MOST_LISTED])
    cure = f"correct {' and '.join(cures)}, then calibrate again"
    if stay[0][0] > REFUSED_STDS:
        return [
            Finding(
                "FAIL",
                f"by the fit {_off(stay)}{many}: robots are not so far off their files, so "
                "cells or soles may be placed wrongly instead (position_m of the shoe file, "
                f"sole_xyz_m of the robot file); else {cure}, or give a larger tolerance",
            ),
            *found,
        ]
    return [Finding("WARN", f"by the fit {_off(stay)}{many}: {cure}"), *found]


_Far = tuple[float, FittedDeviation]
"""Standard deviations as built by which the robot is off its files, and in what."""


def _far(deviations: Sequence[FittedDeviation]) -> list[_Far]:
    """The worst first."""
    far = [
        (abs(one.value) / one.deviation.std, one)
        for one in deviations
        if one.deviation.effect in ROBOT_WORDS
        and abs(one.value) > FAR_STDS * one.deviation.std > 0.0
    ]
    return sorted(far, key=lambda one: -one[0])


def _of_zero(far: _Far) -> bool:
    return far[1].deviation.effect == "joint_offset"


def _split(far: Sequence[_Far], freed: FreedGears) -> tuple[list[_Far], list[_Far]]:
    """What stays off where gears are free, as much as it is then, and what does not."""
    values = {one.deviation.key: one for one in freed.deviations}
    stay, gone = list[_Far](), list[_Far]()
    for times, one in far:
        now = values[one.deviation.key]
        left = abs(now.value) / now.deviation.std
        if left > min(FAR_STDS, STAYS * times):
            stay.append((left, now))
        else:
            gone.append((times, one))
    return sorted(stay, key=lambda one: -one[0]), gone


def _off(far: Sequence[_Far]) -> str:
    """By how much the robot is off its files, in words."""
    found = []
    for times, one in far[:MOST_LISTED]:
        text, scale, _ = ROBOT_WORDS[one.deviation.effect]
        axis = (one.deviation.component,) if one.deviation.effect == "link_com" else ()
        place = " ".join((*one.deviation.location, *axis))
        found.append(f"{text.format(place, scale * abs(one.value))} ({times:.0f} tolerances)")
    return "; ".join(found)


def _gears_or(far: Sequence[_Far], freed: FreedGears) -> str:
    """What is off, or else gears give: by how much, and how well that fits."""
    most = max(freed.given, key=lambda joint: freed.given[joint])
    mean = float(np.mean(list(freed.given.values())))
    fits = (
        f"that leaves {freed.cost_share:.0%} of the misfit, so it is likelier, and the CoP may be "
        "off by more than expected"
        if freed.cost_share < FITS_BETTER
        else "the data do not tell these apart"
    )
    return (
        f"by the fit {_off(far)}; or gears give and have play, which turns links by "
        f"{1e3 * mean:.0f} mrad in the mean, {most} by {1e3 * freed.given[most]:.0f}: {fits}; "
        "hold the motors and push the links: tighten or replace what gives; else correct "
        "the zeros that a jig shows to be off, then calibrate again"
    )


def check_missing(runs: Sequence[int]) -> list[Finding]:
    """Runs that were started and are gone."""
    return [Finding("WARN", missing_text(runs))] if runs else []


def check_since(
    since: Since | None, manual: ChannelParameters, now: ChannelParameters, shoe: Shoe
) -> list[Finding]:
    """What has become of the shoes since their manual calibration, where the data show it.

    Args:
        since: None: there was none.
        manual, now: gains and offsets then and now.
        shoe: whose channels these are.
    """
    if since in {None, Since.STEADY}:
        return []
    zeros = now.offset - manual.offset
    far = int(np.argmax(np.abs(zeros)))
    unit = "N m" if shoe.torque[far] else "N"
    reason = (
        "the data contradict the manual calibration, so it was followed only in part: zeros moved "
        f"since, most that of {shoe.names[far]} by {zeros[far]:+.2f} {unit}"
    )
    if since is Since.CHANGED:
        gains = now.gain / manual.gain - 1.0
        far = int(np.argmax(np.abs(gains)))
        reason += f", and gains, most that of {shoe.names[far]} by {100.0 * gains[far]:+.1f} %"
    return [Finding("WARN", f"{reason}; calibrate manually again if that is no drift")]


def check_changed(files: Sequence[str]) -> list[Finding]:
    """Robot or shoe files that are others than the runs were recorded with, which was forced."""
    return [
        Finding("WARN", f"{file} was changed since the runs were recorded, and reading them forced")
        for file in files
    ]


def check_directions(
    found: Identifiability, add: DoubleSupport | None, *, cure: bool = True
) -> list[Finding]:
    """Directions that only the prior has fixed though other supports could fix them.

    Args:
        found: what the data fix.
        add: double support that would help; None: none is known.
        cure: say so; False where another finding says it.
    """
    if not found.weak or found.rank >= found.possible:
        return []
    listed = list_reasons(list(found.weak_by_words), MOST_DIRECTIONS)
    reason = f"the data identify {found.rank} of {found.possible} directions, but not: {listed}"
    if cure:
        more = "record more double supports with other yaws between the feet"
        reason += f"; {_addition(add, more)}"
    return [Finding("WARN", reason)]


def _addition(add: DoubleSupport | None, otherwise: str) -> str:
    """The double support to add in words, or what else to do where none is known."""
    return otherwise if add is None else f"add a double support: right foot at {add} of the left"


def check_expected(
    half_width: float,
    both: float,
    feet: Mapping[str, float],
    add: DoubleSupport | None,
    moved: float = np.inf,
) -> list[Finding]:
    """A CoP that is expected to be so far off that its place in the foot is hardly known.

    Args:
        half_width: from the middle to the nearer edge of the narrower sensing polygon [m].
        both: expected CoP error of both feet together [m].
        feet: expected CoP error of each foot, by its name [m].
        add: double support that would help; None: none is known.
        moved: how far the CoP moves in the runs [m].
    """
    errors = {"both feet": both, **{f"the {name} foot": error for name, error in feet.items()}}
    large = {name: error for name, error in errors.items() if error > MOST_WIDTHS * half_width}
    if not large:
        return []
    listed = ", ".join(f"{1e3 * error:.0f} mm ({name})" for name, error in large.items())
    cure = _addition(add, "record more double supports")
    if moved < STANDS_WIDTHS * half_width:
        cure = (
            f"the CoP moves by no more than {1e3 * moved:.0f} mm in a run, as if the robot only "
            "stood; record motions that take it through the feet (`shoecal plan`)"
        )
    return [
        Finding(
            "FAIL",
            f"the CoP is expected to be off by {listed}, in a sensing polygon "
            f"{2e3 * half_width:.0f} mm wide: {cure}",
        )
    ]
