"""A made-up session from a forward model of its own: what a robot with known errors would record.

Nothing of the estimator is asked: Pinocchio places the true body, statics share its weight between
the feet, true columns turn each foot's wrench into outputs, and encoders show the true angles plus
their errors. Samples then tell what files of robot and shoes make of that.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace

import numpy as np
import pinocchio as pin
from scipy.sparse import csr_matrix

from core.error_sources.altered import body_states
from core.robot import robots
from core.shoe import shoes
from shoecal_core.arrays import BoolArray, FloatArray, IntArray
from shoecal_core.robot.double_support import DoubleSupport
from shoecal_core.robot.kinematics import BodyStates
from shoecal_core.robot.robot import Robot
from shoecal_core.samples.samples import Samples, Track
from shoecal_core.shoe.shoe import Shoe
from shoecal_core.shoe.wrench import ChannelParameters, at_cop, to_left, weight_below

RATE_HZ = 4.0
STANDS = {"both": (True, True), "left": (True, False), "right": (False, True)}
LIFTED_M = 0.02


@dataclass(frozen=True)
class Motion:
    """How a robot truly moves, T samples of it.

    Attributes:
        robot, shoe: as their files say.
        run, segment: (T,). loaded: (T, 2). time: (T,) since the run's start [s].
        supports: true place of the right foot in each segment.
        angles: (T, m) true [rad].
        share: (T,) of the weight that the left foot bears while both stand.
        moments: (T, 2) of it about x and y, beyond those of its share [N m].
    """

    robot: Robot
    shoe: Shoe
    run: IntArray
    segment: IntArray
    loaded: BoolArray
    time: FloatArray
    supports: tuple[DoubleSupport, ...]
    angles: FloatArray
    share: FloatArray
    moments: FloatArray


@dataclass(frozen=True)
class Truth:
    """What truly differs from the files.

    Attributes:
        parameters: gains and offsets.
        robot: with the true masses; None: the file's.
        columns: (n, 3) of the channels; None: the file's.
        encoder: from torques (T, m) [N m] to what encoders show too much (T, m) [rad].
        support: by segment, how much further the right foot stands than the joints tell.
        zero: by run, (n,) added to the outputs [N].
        noise: of each sample of each channel [N].
    """

    parameters: ChannelParameters
    robot: Robot | None = None
    columns: FloatArray | None = None
    encoder: Callable[[FloatArray], FloatArray] = np.zeros_like
    support: Mapping[int, FloatArray] = field(default_factory=dict)
    zero: Mapping[int, FloatArray] = field(default_factory=dict)
    noise: float = 0.0


def motion(
    rng: np.random.Generator, supports: int = 4, unloading: int = 2, count: int = 12
) -> Motion:
    """Random postures that sway in random double supports; then each foot is lifted in turn."""
    robot, shoe = robots.load("nao"), shoes.shoe("nao_shoe")
    kinds = ["both"] * supports + ["left", "right"][:unloading]
    angles, places = [], []
    for kind in kinds:
        place = DoubleSupport(
            float(rng.uniform(-0.04, 0.06)),
            float(rng.uniform(-0.14, -0.10)),
            float(rng.uniform(-0.4, 0.4)),
        )
        lift = {"both": 0.0, "left": LIFTED_M, "right": -LIFTED_M}[kind]
        angles.append(_standing(robot, place, lift, count, rng))
        places.append(place)
    total = len(kinds) * count
    sway = np.arange(total)[:, None] * rng.uniform(0.2, 0.9, 3) + rng.uniform(0.0, 6.0, 3)
    segment = np.repeat(np.arange(len(kinds)), count)
    return Motion(
        robot=robot,
        shoe=shoe,
        run=segment + 1,
        segment=segment,
        loaded=np.array([STANDS[kind] for kind in kinds])[segment],
        time=np.tile(np.arange(count) / RATE_HZ, len(kinds)),
        supports=tuple(places),
        angles=np.concatenate(angles),
        share=0.5 + 0.2 * np.sin(sway[:, 0]),
        moments=0.4 * np.sin(sway[:, 1:]),
    )


def _standing(
    robot: Robot, place: DoubleSupport, lift: float, count: int, rng: np.random.Generator
) -> FloatArray:
    """(count, m) angles that sway with the right sole level and in one place of the left's."""
    legs = np.array(robot.moved)
    phase = np.arange(count)[:, None] / count * 2.0 * np.pi * rng.uniform(0.5, 1.5, len(legs))
    angles = np.tile(robot.posture, (count, 1))
    angles[:, legs] += 0.12 * np.sin(phase + rng.uniform(0.0, 6.0, len(legs)))
    wanted = np.array([place.dx, place.dy, lift, 0.0, 0.0, place.dtheta])
    driven = _driven(robot)
    for _ in range(30):
        missing = wanted - _pose(body_states(robot, angles))
        if np.abs(missing).max() < 1e-12:
            break
        slopes = np.zeros((count, 6, driven.shape[0]))
        for index, one in enumerate(driven):
            ends = [_pose(body_states(robot, angles + sign * 1e-6 * one)) for sign in (1, -1)]
            slopes[:, :, index] = (ends[0] - ends[1]) / 2e-6
        angles = angles + np.einsum("tmi,ti,mj->tj", np.linalg.pinv(slopes), missing, driven)
    np.testing.assert_allclose(_pose(body_states(robot, angles)), np.tile(wanted, (count, 1)),
                               atol=1e-9)  # fmt: skip
    return angles


def _driven(robot: Robot) -> FloatArray:
    """(motors, m) how each motor of the legs moves the joints."""
    following = {one.joint for one in robot.shared}
    rows = []
    for joint in sorted(robot.moved.tolist()):
        if joint in following:
            continue
        row = np.zeros(len(robot.joint_names))
        row[joint] = 1.0
        for one in robot.shared:
            if one.leader == joint:
                row[one.joint] = one.ratio
        rows.append(row)
    return np.array(rows)


def _pose(states: BodyStates) -> FloatArray:
    """(T, 6) of the right sole in the left's, by Pinocchio's own roll, pitch, yaw."""
    turned = np.array([pin.rpy.matrixToRpy(one) for one in states.rotation])
    return np.hstack((states.translation, turned))


def recorded(moves: Motion, truth: Truth, seed: int = 0) -> Samples:
    """What that robot records, as its files tell it."""
    robot, shoe = moves.robot, moves.shoe
    frame = np.where(moves.loaded[:, 0], 0, 1)
    rows = np.arange(len(frame))
    true = body_states(truth.robot or robot, moves.angles)
    wrenches = _foot_wrenches(moves, truth, true, frame)
    outputs = _outputs(moves, truth, wrenches)
    for run, added in truth.zero.items():
        outputs[moves.run == run] += added
    outputs += truth.noise * np.random.default_rng(seed).standard_normal(outputs.shape)
    law = truth.parameters
    readings = (outputs - law.offset) / law.gain
    torque = _torques(truth.robot or robot, moves, true, wrenches, frame)
    angles = moves.angles + truth.encoder(torque)
    told = body_states(robot, angles)
    up = true.left_rotation[:, :, 2].copy()
    hangs = frame == 1
    up[hangs] = np.einsum("tij,tj->ti", true.left_rotation, true.rotation[:, :, 2])[hangs]
    tracks = []
    for run in np.unique(moves.run):
        here = np.flatnonzero(moves.run == run)
        tracks.append(
            Track(
                run=int(run), motion="sway", walks=False, start=10.0 * float(run),
                time=moves.time[here], readings=readings[here], angles=angles[here], efforts=None,
                up=up[here], temperature=None, com=told.com[here],
                samples=slice(int(here[0]), int(here[-1]) + 1),
                weights=csr_matrix(np.eye(len(here))),
            )
        )  # fmt: skip
    return Samples(
        robot=robot, shoe=shoe, tracks=tuple(tracks), run=moves.run, time=moves.time,
        clock=10.0 * moves.run + moves.time, segment=moves.segment, loaded=moves.loaded,
        readings=readings, angles=angles, states=told, up=up,
        force=np.full(len(rows), robot.weight), cop=told.com[rows, frame, :2],
        walks=np.zeros(len(rows), dtype=bool), acceleration=np.zeros((len(rows), 3)),
        spin=np.zeros((len(rows), 2)), notes=(),
    )  # fmt: skip


def _foot_wrenches(moves: Motion, truth: Truth, true: BodyStates, frame: IntArray) -> FloatArray:
    """(T, 2, 3) that the floor truly puts on each sole [N, N m]."""
    count = len(frame)
    weight = np.full(count, moves.robot.weight)
    whole = at_cop(weight, true.com[np.arange(count), frame, :2])
    found = np.zeros((count, 2, 3))
    for index in range(count):
        if not moves.loaded[index].all():
            found[index, frame[index]] = whole[index]
            continue
        segment = int(moves.segment[index])
        place = moves.supports[segment]
        off = truth.support.get(segment, np.zeros(3))
        stands = DoubleSupport(place.dx + off[0], place.dy + off[1], place.dtheta + off[2])
        left = np.array([moves.share[index] * weight[index], *moves.moments[index]])
        found[index, 0] = left
        found[index, 1] = np.linalg.solve(to_left(stands), whole[index] - left)
    return found


def _outputs(moves: Motion, truth: Truth, wrenches: FloatArray) -> FloatArray:
    """(T, n) below stiff plates: a foot's outputs lie on one plane, wherever its cells are."""
    shoe = moves.shoe
    columns = shoe.columns if truth.columns is None else truth.columns
    below = weight_below(shoe)
    outputs = np.zeros((len(wrenches), len(shoe.names)))
    for foot in (0, 1):
        own = shoe.of_foot(foot)
        plane = shoe.columns[own]
        plates = np.linalg.solve(columns[own].T @ plane, (wrenches[:, foot] - below[foot]).T)
        outputs[:, own] = (plane @ plates).T
    return outputs


def _torques(
    robot: Robot, moves: Motion, true: BodyStates, wrenches: FloatArray, frame: IntArray
) -> FloatArray:
    """(T, m) that motors hold with, by inverse dynamics under the floor's forces [N m]."""
    model, data = robot.model, robot.model.createData()
    still = np.zeros(model.nv)
    torque = np.zeros_like(moves.angles)
    for index, angles in enumerate(moves.angles):
        sole = pin.SE3(true.left_rotation[index], true.left_translation[index])
        if frame[index] == 1:
            sole = sole * pin.SE3(true.rotation[index], true.translation[index])
        q = np.concatenate((pin.SE3ToXYZQUAT(sole.inverse()), angles))
        outer = [pin.Force.Zero() for _ in range(model.njoints)]
        for foot, (force, about_x, about_y) in zip(robot.feet, wrenches[index], strict=True):
            wrench = pin.Force(np.array([0.0, 0.0, force, about_x, about_y, 0.0]))
            outer[foot.joint] = foot.placement.act(wrench)
        torque[index] = pin.rnea(model, data, q, still, still, outer)[6:]
    return torque


def with_heavier_link(robot: Robot, link: str, share: float) -> Robot:
    """With a link heavier by a share of itself, all masses then scaled to the weighed total."""
    model = pin.Model(robot.model)
    chosen = model.frames[model.getFrameId(link)].parentJoint
    factors = [1.0 + share * (joint == chosen) for joint in range(model.njoints)]
    masses = [factor * one.mass for factor, one in zip(factors, model.inertias, strict=True)]
    scale = sum(one.mass for one in model.inertias) / sum(masses)
    for joint, mass in enumerate(masses):
        own = model.inertias[joint]
        model.inertias[joint] = pin.Inertia(scale * mass, own.lever, own.inertia)
    return replace(robot, model=model)
