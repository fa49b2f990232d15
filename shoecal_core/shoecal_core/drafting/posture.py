"""A posture to start from: knees bent, soles level, the CoM above them."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pinocchio as pin
from scipy.optimize import brentq, least_squares

from shoecal_core.arrays import FloatArray
from shoecal_core.drafting.body import Body
from shoecal_core.drafting.legs import UP, LegChains
from shoecal_core.drafting.plausible import crossed_limits
from shoecal_core.drafting.soles import Sole
from shoecal_core.robot.joint_centres import own_joints
from shoecal_core.robot.urdf import UrdfError

BEND = 0.8
"""rad; of the knees."""
LEAST_BEND = 0.3
MARGIN = 0.05
"""rad; from the joints' limits."""
SIDEWAYS = 0.82
"""Cosine of the angle within which an axis lies across the robot; some hips' tilt by 30 degrees."""
LEVEL = 5e-3
"""rad and dm; soles that are off by less stand."""
STIFF = 0.01
"""By which joints keep their angles, against errors of the soles."""
SHARES = (0.1, 0.9)
"""Part of the knees' bend that the hips take, least and most."""


def find_posture(body: Body, legs: LegChains, soles: Sequence[Sole]) -> dict[str, float]:
    """Angles by joint [rad]; joints at zero and followers of other motors are left out.

    Of a robot that is drafted in another than its zero pose, with its knees bent, it is that one.

    Raises:
        UrdfError: for legs without hip, knee and ankle that swing, or knees that do not bend.
    """
    swings = [_swings(body, chain, legs.left) for chain in legs.chains]
    if body.start.any() and min(_knee_angle(body, swing) for swing in swings) >= LEAST_BEND:
        return _named(body, _resting(body))
    bend = min(_bend(body, swing[1], legs) for swing in swings)
    angles = _resting(body)

    def ahead(hip: float) -> float:
        """How far the CoM is before the middle of the soles [m]."""
        _bent(body, angles, swings, legs, soles, bend, hip * bend)
        return _com_ahead(body, angles, legs, soles)

    low, high = SHARES
    begin, end = ahead(low), ahead(high)
    if begin * end < 0.0:
        share = brentq(ahead, low, high, xtol=1e-3)
    else:
        share = low if abs(begin) < abs(end) else high
    ahead(float(share))
    _level_soles(body, angles, legs, soles)
    return _named(body, angles)


def _named(body: Body, angles: FloatArray) -> dict[str, float]:
    names = body.model.names
    return {
        str(names[joint]): _rounded(float(angles[joint]), *body.range(joint))
        for joint in own_joints(body.model)
        if abs(angles[joint]) > 5e-4 and names[joint] not in body.mimics
    }


def _rounded(angle: float, low: float, high: float) -> float:
    """To milliradians, within the limits."""
    near = round(angle, 3)
    near += 1e-3 * (near < low) - 1e-3 * (near > high)
    return near if low <= near <= high else angle


def _swings(body: Body, chain: Sequence[int], left: FloatArray) -> tuple[int, int, int]:
    """Hip, knee and ankle: the joints of a leg that turn about an axis across the robot."""
    found = [joint for joint in chain if abs(body.axis(joint) @ left) > SIDEWAYS]
    if len(found) < 3:
        named = ", ".join(str(body.model.names[joint]) for joint in chain)
        raise UrdfError(
            body.urdf,
            f"of the leg {named} only {len(found)} joints swing about an axis across the robot; "
            "hip, knee and ankle are needed, in a zero pose that looks straight ahead",
        )
    return found[0], found[1], found[-1]


def _sense(body: Body, joint: int, left: FloatArray) -> float:
    """+1 where a positive angle swings what is below to the back."""
    return float(np.sign(body.axis(joint) @ left))


def _bend(body: Body, knee: int, legs: LegChains) -> float:
    low, high = body.range(knee)
    start = float(body.start[knee])
    most = (high - start if _sense(body, knee, legs.left) > 0.0 else start - low) - MARGIN
    if most < LEAST_BEND:
        names = body.model.names
        cure = "correct its limits or its axis"
        for pair in crossed_limits(body, legs):
            if knee in pair:
                other = pair[0] if knee == pair[1] else pair[1]
                cure = (
                    f"they are those of {names[other]} with the wrong sign: correct its limits or "
                    "its axis"
                )
        raise UrdfError(
            body.urdf,
            f"does not bend {LEAST_BEND:g} rad backwards as a knee must (limits {low:g} to "
            f"{high:g} rad); {cure}",
            field=f"joint {names[knee]}",
        )
    return min(BEND, most)


def _knee_angle(body: Body, swing: tuple[int, int, int]) -> float:
    """Between thigh and shank [rad]."""
    hip, knee, ankle = (body.centres[joint] for joint in swing)
    thigh, shank = knee - hip, ankle - knee
    return float(np.arctan2(np.linalg.norm(np.cross(thigh, shank)), thigh @ shank))


def _resting(body: Body) -> FloatArray:
    """(njoints,) as the robot is drafted, or what is nearest to it within the limits."""
    angles = np.zeros(body.model.njoints)
    for joint in own_joints(body.model):
        angles[joint] = np.clip(body.start[joint], *body.range(joint))
    return angles


def _bent(
    body: Body,
    angles: FloatArray,
    swings: Sequence[tuple[int, int, int]],
    legs: LegChains,
    soles: Sequence[Sole],
    bend: float,
    hip_bend: float,
) -> None:
    """Bend both legs; ankles make the soles level as far as their limits let them."""
    for (hip, knee, ankle), sole in zip(swings, soles, strict=True):
        tilt = float(np.arctan2(sole.in_base.rotation[:, 2] @ legs.forward, 1.0))
        for joint, backwards in ((hip, -hip_bend), (knee, bend), (ankle, hip_bend - bend - tilt)):
            low, high = body.range(joint)
            angle = body.start[joint] + _sense(body, joint, legs.left) * backwards
            angles[joint] = np.clip(angle, low + MARGIN, high - MARGIN)


def _level_soles(body: Body, angles: FloatArray, legs: LegChains, soles: Sequence[Sole]) -> None:
    """Turn all joints of the legs a little until both soles are level and next to each other as in
    the zero pose: where a hip's axis is tilted, bending it turns the foot sideways.
    """
    mimics, data = body.mimics, body.model.createData()
    joints = [one for chain in legs.chains for one in chain if body.model.names[one] not in mimics]
    start = angles[joints].copy()
    low, high = np.array([body.range(joint) for joint in joints]).T
    low, high = np.minimum(low + MARGIN, start), np.maximum(high - MARGIN, start)

    apart = soles[0].in_base.translation - soles[1].in_base.translation
    apart = apart - (apart @ UP) * UP

    def off(values: FloatArray) -> FloatArray:
        """Of both soles: their turns [rad], and their places against each other [dm]."""
        angles[joints] = values
        pin.forwardKinematics(body.model, data, configuration(body, angles))
        left, right = _placed(body, data, legs, soles)
        turns = [
            pin.log3(_straight(sole).T @ now.rotation)
            for sole, now in zip(soles, (left, right), strict=True)
        ]
        place = 10.0 * (left.translation - right.translation - apart)
        return np.concatenate((*turns, place))

    before = off(start)
    if np.abs(before).max() < LEVEL:
        return

    def cost(values: FloatArray) -> FloatArray:
        return np.concatenate((off(values), STIFF * (values - start)))

    found = least_squares(cost, start, bounds=(low - 1e-9, high + 1e-9))
    # What the limits do not allow stays as it was.
    better = np.linalg.norm(off(found.x)) < 0.5 * np.linalg.norm(before)
    angles[joints] = found.x if better else start


def _straight(sole: Sole) -> FloatArray:
    """(3, 3) of a level sole that points where this one does in the zero pose."""
    forward = np.array(sole.in_base.rotation[:, 0])
    forward -= (forward @ UP) * UP
    forward /= np.linalg.norm(forward)
    return np.column_stack((forward, np.cross(UP, forward), UP))


def _placed(
    body: Body, data: pin.Data, legs: LegChains, soles: Sequence[Sole]
) -> tuple[pin.SE3, pin.SE3]:
    """Both soles in the base, where the forward kinematics in `data` has the joints."""
    left, right = (
        data.oMi[chain[-1]] * body.placements[chain[-1]].actInv(sole.in_base)
        for chain, sole in zip(legs.chains, soles, strict=True)
    )
    return left, right


def _com_ahead(body: Body, angles: FloatArray, legs: LegChains, soles: Sequence[Sole]) -> float:
    data = body.model.createData()
    com = np.asarray(pin.centerOfMass(body.model, data, configuration(body, angles)))
    middles = []
    for sole, now in zip(soles, _placed(body, data, legs, soles), strict=True):
        middle = np.append(0.5 * (sole.outline.min(axis=0) + sole.outline.max(axis=0)), 0.0)
        middles.append(now.act(middle))
    return float((com - np.mean(middles, axis=0)) @ legs.forward)


def configuration(body: Body, angles: FloatArray) -> FloatArray:
    """Configuration (nq,) of Pinocchio's model, base at the origin, followers with their leaders.

    Args:
        body: of the robot.
        angles: (njoints,) by joint of the model [rad].
    """
    q = np.zeros(body.model.nq)
    q[6] = 1.0
    for joint in own_joints(body.model):
        q[body.model.joints[joint].idx_q] = angles[joint]
    for name, mimic in body.mimics.items():
        if body.model.existJointName(name) and body.model.existJointName(mimic.leader):
            follower, leader = (body.model.getJointId(each) for each in (name, mimic.leader))
            q[body.model.joints[follower].idx_q] = mimic.multiplier * angles[leader]
    return q


def level(placement: pin.SE3) -> float:
    """Angle between a sole's z axis and the base's [rad]."""
    return float(np.arccos(np.clip(placement.rotation[:, 2] @ UP, -1.0, 1.0)))
