"""A recorded signal_model with exactly one thing changed: what the definition of an effect says."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pinocchio as pin
from scipy.ndimage import gaussian_filter1d

from shoecal_core.arrays import FloatArray
from shoecal_core.error_sources.signal_model import SignalModel
from shoecal_core.robot.kinematics import BodyStates
from shoecal_core.robot.robot import Robot
from shoecal_core.samples.samples import Samples, Track
from shoecal_core.shoe.wrench import at_cop

Work = Callable[[Track, FloatArray], FloatArray]
"""From a run and something of it (F, k) to what it is with the effect."""


def with_forces(signal_model: SignalModel, work: Work) -> SignalModel:
    """The readings that tell other forces by the same affine law."""
    law = signal_model.parameters

    def changed(track: Track) -> FloatArray:
        return np.asarray((work(track, law.outputs(track.readings)) - law.offset) / law.gain)

    return with_readings(signal_model, changed)


def with_readings(signal_model: SignalModel, work: Callable[[Track], FloatArray]) -> SignalModel:
    """Other raw readings, at the recorded rate and in the samples."""
    samples = signal_model.samples
    tracks = tuple(replace(track, readings=work(track)) for track in samples.tracks)
    readings = np.concatenate([track.mean(track.readings) for track in tracks])
    return replace(signal_model, samples=replace(samples, tracks=tracks, readings=readings))


def calm(signal_model: SignalModel) -> SignalModel:
    """Without noise and trembling: readings averaged over about a second."""
    width = 0.5 / float(np.median(np.diff(signal_model.samples.tracks[0].time)))
    return with_readings(
        signal_model, lambda track: gaussian_filter1d(track.readings, width, axis=0)
    )


def with_angles(signal_model: SignalModel, change: FloatArray) -> SignalModel:
    """Encoders that show (T, m) more, in all that is modelled from them."""
    angles = signal_model.samples.angles + change
    return _modelled(signal_model, replace(signal_model.samples, angles=angles))


def with_robot(signal_model: SignalModel, robot: Robot) -> SignalModel:
    """The same recording, told from another model of the robot."""
    return _modelled(signal_model, replace(signal_model.samples, robot=robot))


def _modelled(signal_model: SignalModel, samples: Samples) -> SignalModel:
    states = body_states(samples.robot, samples.angles)
    cop = states.com[np.arange(len(samples.frame)), samples.frame, :2]
    force = np.full(len(cop), samples.robot.weight)
    return replace(signal_model, samples=replace(samples, states=states, cop=cop, force=force))


def body_states(robot: Robot, angles: FloatArray) -> BodyStates:
    """Of angles (T, m), from Pinocchio's own forward kinematics."""
    model, data = robot.model, robot.model.createData()
    found = []
    for one in angles:
        q = np.concatenate((pin.neutral(model)[:7], one))
        com = pin.centerOfMass(model, data, q).copy()
        left, right = (data.oMi[foot.joint] * foot.placement for foot in robot.feet)
        found.append((left.actInv(com), right.actInv(com), left.actInv(right), left))
    return BodyStates(
        com=np.array([one[:2] for one in found]),
        rotation=np.array([one[2].rotation for one in found]),
        translation=np.array([one[2].translation for one in found]),
        left_rotation=np.array([one[3].rotation for one in found]),
        left_translation=np.array([one[3].translation for one in found]),
    )


def heavier(robot: Robot, link: str, mass: float) -> Robot:
    """With a mass [kg] more where a link has its CoM."""
    model, index = _inertia_of(robot, link)
    inertia = model.inertias[index]
    model.inertias[index] = pin.Inertia(inertia.mass + mass, inertia.lever, inertia.inertia)
    return replace(robot, model=model, mass=robot.mass + mass)


def shifted(robot: Robot, link: str, axis: int, far: float) -> Robot:
    """With a link's CoM further along an axis of the link's frame [m]."""
    model, index = _inertia_of(robot, link)
    inertia = model.inertias[index]
    own = model.frames[model.getFrameId(link)].placement.rotation
    lever = inertia.lever + far * own[:, axis]
    model.inertias[index] = pin.Inertia(inertia.mass, lever, inertia.inertia)
    return replace(robot, model=model)


def askew(robot: Robot, foot: int, dx: float, dy: float, dtheta: float) -> Robot:
    """With a sole elsewhere: at (dx, dy, dtheta) in the one that it has."""
    turn = pin.SE3(pin.rpy.rpyToMatrix(0.0, 0.0, dtheta), np.array([dx, dy, 0.0]))
    feet = list(robot.feet)
    feet[foot] = replace(feet[foot], placement=feet[foot].placement * turn)
    return replace(robot, feet=(feet[0], feet[1]))


def _inertia_of(robot: Robot, link: str) -> tuple[pin.Model, int]:
    model = pin.Model(robot.model)
    return model, model.frames[model.getFrameId(link)].parentJoint


def bearing(
    signal_model: SignalModel, cop: FloatArray, columns: FloatArray | None = None
) -> SignalModel:
    """With samples' forces shifted, as little as can be, until their CoP is (T, 2) [m].

    Args:
        columns: (T, n, 3) by which they truly make the wrench; default: the signal model's own.
    """
    columns = signal_model.per_sample if columns is None else columns
    fixed = signal_model.wrench - np.einsum(
        "tn,tnw->tw", signal_model.outputs, signal_model.per_sample
    )
    missing = at_cop(signal_model.samples.force, cop) - fixed
    missing -= np.einsum("tn,tnw->tw", signal_model.outputs, columns)
    outputs = signal_model.outputs + np.einsum("twn,tw->tn", np.linalg.pinv(columns), missing)
    law = signal_model.parameters
    readings = (outputs - law.offset) / law.gain
    return replace(signal_model, samples=replace(signal_model.samples, readings=readings))


def below(com: FloatArray, up: FloatArray) -> FloatArray:
    """(T, 2) where a plumb line from (T, 3) meets the plane z = 0, upwards being (T, 3)."""
    return np.asarray(com[:, :2] - com[:, 2:] * up[:, :2] / up[:, 2:])


def stance_com(samples: Samples) -> FloatArray:
    """(T, 3) the CoM in the stance's frame [m]."""
    return np.asarray(samples.states.com[np.arange(len(samples.frame)), samples.frame])


def turning(about: FloatArray) -> FloatArray:
    """(T, 3, 3) rotations by vectors (T, 3) [rad]."""
    return np.array([pin.exp3(one) for one in about])
