"""From a recorded run to the stances that a fit uses.

A run in double support is one stance; one that lifts a foot is cut where it does (`lifting`).
Where the feet move (walking, stepping) `walking` finds the stances.
"""

from __future__ import annotations

import numpy as np

from shoecal_core.arrays import BoolArray
from shoecal_core.recording.errors import RecordingError
from shoecal_core.recording.run import Run
from shoecal_core.robot.kinematics import Kinematics
from shoecal_core.samples.aligned import Aligned
from shoecal_core.samples.contact import find_contact
from shoecal_core.samples.lifting import LiftedFoot, detect_lifted_foot
from shoecal_core.samples.stance import Stance, make_stance
from shoecal_core.samples.walking import World, in_world, walking_stances
from shoecal_core.samples.zeros import Zero, zeros_of_run
from shoecal_core.screening.result import Screening
from shoecal_core.shoe.shoe import Shoe

MAX_FOOT_DRIFT_M = 0.01
"""In a double support the feet's distance, by the joint angles, stays within this."""
LEAST_SAMPLES = 20
"""Of a stance in a run in which a foot was lifted."""


def stances_of(
    run: Run,
    aligned: Aligned,
    shoe: Shoe,
    kinematics: Kinematics,
    screening: Screening | None = None,
) -> list[Stance]:
    """Every stance of a run: one where it names its double support, else those found.

    Args:
        run: recorded.
        aligned: the same with the model's values.
        screening: leaves out what it found faulty; a run of which nothing is left has no stance.
    """
    if run.info.hanging:
        return []
    if run.info.support is not None:
        everything = np.ones(len(aligned.time), dtype=bool)
        kept = standing = everything
        if screening is not None:
            kept = screening.kept.get(run.info.run, everything)
            standing = screening.standing.get(run.info.run, everything)
        if not kept.any():
            return []
        lifting = detect_lifted_foot(run.info.motion, aligned)
        if lifting is not None and lifting.air.any():
            return _around_the_air(run, aligned, lifting, kept, standing, shoe, kinematics)
        return [double_support_stance(run, aligned, standing, shoe, kinematics).part(kept)]
    world = _world(run, aligned, kinematics)
    return walking_stances(run.info.run, aligned, world, shoe, kinematics.robot)


def zeros_of(
    run: Run,
    aligned: Aligned,
    shoe: Shoe,
    kinematics: Kinematics,
    screening: Screening | None = None,
) -> list[Zero]:
    """Zeros of the feet that the run lifts; none where feet in the air cannot be found.

    Args:
        screening: knows when the whole robot was lifted.
    """
    if run.info.hanging:
        air = np.ones((len(aligned.time), 2), dtype=bool)
    elif run.info.support is not None:
        lifting = detect_lifted_foot(run.info.motion, aligned)
        air = np.zeros((len(aligned.time), 2), dtype=bool)
        if lifting is not None:
            air[:, lifting.foot] = lifting.air
        hanging = None if screening is None else screening.hanging.get(run.info.run)
        if hanging is not None:
            air[hanging] = True
    else:
        world = _world(run, aligned, kinematics)
        weight = kinematics.robot.weight
        air = find_contact(shoe, aligned.readings, world.clearance, weight).air
    return zeros_of_run(run.info.run, aligned.time, aligned.readings, air)


def _world(run: Run, aligned: Aligned, kinematics: Kinematics) -> World:
    if run.base_pose is None or len(run.base_pose.time) < 2:
        raise RecordingError(
            run.path,
            "names no double support and has no /base_pose to find the stances with; "
            "record one of the two",
        )
    return in_world(aligned, run.base_pose, kinematics.robot)


def _around_the_air(
    run: Run,
    aligned: Aligned,
    lifting: LiftedFoot,
    kept: BoolArray,
    standing: BoolArray,
    shoe: Shoe,
    kinematics: Kinematics,
) -> list[Stance]:
    """Both feet on the floor, one in the air, and both on the floor again: a stance each."""
    stances = []
    for part in lifting.stretches():
        if (part & kept).sum() < LEAST_SAMPLES:
            continue
        if lifting.air[part].any():
            stance = hanging_stance(run, aligned, lifting.foot, shoe, kinematics)
        else:
            stance = double_support_stance(run, aligned, part & standing, shoe, kinematics)
        stances.append(stance.part(part & kept))
    return stances


def hanging_stance(
    run: Run, aligned: Aligned, foot: int, shoe: Shoe, kinematics: Kinematics
) -> Stance:
    """A whole run as if one foot hung in the air all the time, in the other one's frame.

    Args:
        foot: index of the one that hangs.
    """
    return make_stance(
        run.info.run,
        shoe,
        aligned.states.support(),
        (foot != 0, foot != 1),
        aligned.time,
        aligned.readings,
        np.full(len(aligned.time), kinematics.robot.weight),
        aligned.states.cop[:, 1 - foot],
        aligned.joint_angles,
    )


def double_support_stance(
    run: Run,
    aligned: Aligned,
    standing: BoolArray,
    shoe: Shoe,
    kinematics: Kinematics,
) -> Stance:
    """The one stance of a quasi-static run in double support.

    Args:
        standing: (T,) samples from which the places of the feet are taken.

    Raises:
        RecordingError: when the feet moved against each other.
    """
    states = aligned.part(standing).states
    places = states.translation[:, :2]
    drift = np.linalg.norm(places - np.median(places, axis=0), axis=1).max()
    if drift > MAX_FOOT_DRIFT_M:
        raise RecordingError(
            run.path,
            f"the feet moved {drift * 1e3:.1f} mm against each other within the run; "
            "record it again, or leave this run out",
        )
    count = len(aligned.time)
    return make_stance(
        run.info.run,
        shoe,
        states.support(),
        (True, True),
        aligned.time,
        aligned.readings,
        np.full(count, kinematics.robot.weight),
        aligned.states.cop[:, 0],
        aligned.joint_angles,
    )
