"""Runs that have not happened, laid out beside those that were recorded.

A planned motion tells the joint angles, and which feet carry when. The rest is as it would be were
nothing wrong: the floor level, the CoP below the CoM, and cells that share the weight as equal
springs below a stiff plate do. Effects then have columns there as in any recorded run.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_matrix

from shoecal_core.error_sources import body
from shoecal_core.error_sources.scene import Scene
from shoecal_core.model.double_support import DoubleSupport
from shoecal_core.model.kinematics import BodyStates, Kinematics
from shoecal_core.model.robot import GRAVITY
from shoecal_core.planning.motion import Motion
from shoecal_core.samples.known_weight import with_mass
from shoecal_core.samples.samples import Track
from shoecal_core.samples.sampling import MIN_SEGMENT_S, TRANSIT_S
from shoecal_core.sensing.wrench import at_cop, combined, weight_below

FloatArray = NDArray[np.float64]
BoolArray = NDArray[np.bool_]
IntArray = NDArray[np.int64]

LEAST_GAIN = 1e-6
"""Of the largest gain: with a smaller one a channel tells nothing of its force."""


@dataclass(frozen=True)
class PossibleRun:
    """A run that could be recorded.

    Attributes:
        name: as a recording would name its motion.
        motion: what the robot does.
        later: how long after the last recorded run it begins [s].
        mass: known, at the base's origin [kg].
        warmer: temperature above the last recorded one [K].
    """

    name: str
    motion: Motion
    later: float = 1.0
    mass: float = 0.0
    warmer: float = 0.0


@dataclass(frozen=True)
class _Part:
    """Samples of one run: those fields of Samples that have T rows."""

    track: Track
    rows: dict[str, NDArray[np.generic]]
    states: BodyStates


def extended(scene: Scene, possible: Sequence[PossibleRun]) -> Scene:
    """The scene as if possible runs had been recorded too, each after all that were.

    They are numbered on from the last recorded run, in order.
    """
    recorded = scene.samples
    kinematics = Kinematics(recorded.robot)
    parts: list[_Part] = []
    at, segments = len(recorded.run), int(recorded.segment.max()) + 1
    for index, run in enumerate(possible, 1):
        part = _part(scene, kinematics, run, max(recorded.runs) + index, at, segments)
        parts.append(part)
        at, segments = part.track.samples.stop, int(part.rows["segment"].max()) + 1
    states = [recorded.states, *(part.states for part in parts)]
    joined: dict[str, Any] = {
        name: np.concatenate([getattr(recorded, name), *(part.rows[name] for part in parts)])
        for name in (parts[0].rows if parts else ())
    }
    joined["states"] = BodyStates(
        *(
            np.concatenate([getattr(one, field.name) for one in states])
            for field in fields(BodyStates)
        )
    )
    tracks = (*recorded.tracks, *(part.track for part in parts))
    samples = replace(recorded, tracks=tracks, **joined)
    outliers = np.zeros((len(samples.run), scene.outliers.shape[1]), dtype=np.bool_)
    outliers[: len(scene.outliers)] = scene.outliers
    return replace(scene, samples=samples, answers=body.answers(samples), outliers=outliers)


def _part(
    scene: Scene, kinematics: Kinematics, run: PossibleRun, number: int, at: int, segments: int
) -> _Part:
    samples = scene.samples
    time, angles = run.motion.time, run.motion.positions
    states = with_mass(kinematics.states(angles), samples.robot, run.mass)
    weight = samples.robot.weight + run.mass * GRAVITY
    loaded, stance = _stances(run.motion)
    last = max(samples.tracks, key=lambda track: track.start)
    start = last.start + float(last.time[-1]) + run.later
    weights, owner = _bins(time, stance, 1.0 / float(np.median(np.diff(samples.time))))
    track = Track(
        run=number,
        motion=run.name,
        walks=False,
        start=start,
        time=time,
        readings=_readings(scene, states, loaded, weight),
        angles=angles,
        efforts=None,
        # Both soles stand level: what is upwards in the left one's frame is so in the world.
        up=None if last.up is None else states.left_rotation[:, :, 2],
        temperature=None
        if last.temperature is None
        else np.full(len(time), last.temperature[-1] + run.warmer),
        com=states.com,
        samples=slice(at, at + weights.shape[0]),
        weights=weights,
    )
    sampled = with_mass(kinematics.states(track.mean(angles)), samples.robot, run.mass)
    standing = loaded[np.searchsorted(time, track.mean(time))]
    rows, frame = np.arange(len(owner)), np.where(standing[:, 0], 0, 1)
    acceleration = np.gradient(np.gradient(states.com, time, axis=0), time, axis=0)
    up = np.full((len(owner), 3), np.nan) if track.up is None else track.mean(track.up)
    return _Part(
        track,
        {
            "run": np.full(len(owner), number),
            "time": track.mean(time),
            "clock": start + track.mean(time),
            "segment": segments + owner,
            "loaded": standing,
            "readings": track.mean(track.readings),
            "angles": track.mean(angles),
            "up": up,
            "force": np.full(len(owner), weight),
            "cop": sampled.com[rows, frame, :2],
            "walks": np.zeros(len(owner), dtype=bool),
            "acceleration": track.mean(acceleration)[rows, frame],
            "spin": np.zeros((len(owner), 2)),
        },
        sampled,
    )


def _stances(motion: Motion) -> tuple[BoolArray, IntArray]:
    """Which feet carry each point of a motion (F, 2); its stance (F,), -1 in between."""
    kinds = np.zeros(len(motion.time), dtype=np.int64)
    carried = {"both": 0, "left": 1, "right": 2}
    for phase in motion.phases:
        kinds[motion.time >= phase.begin] = carried[phase.support_phase.value]
    loaded = np.stack((kinds != carried["right"], kinds != carried["left"]), axis=1)
    stance = np.full(len(kinds), -1)
    change = np.flatnonzero(np.diff(kinds)) + 1
    number = 0
    for part in np.split(np.arange(len(kinds)), change):
        begin, end = motion.time[part[0]], motion.time[part[-1]]
        begin += TRANSIT_S if part[0] > 0 else 0.0
        end -= TRANSIT_S if part[-1] < len(kinds) - 1 else 0.0
        if end - begin < MIN_SEGMENT_S:
            continue
        stance[part[(motion.time[part] >= begin) & (motion.time[part] <= end)]] = number
        number += 1
    return loaded, stance


def _bins(time: FloatArray, stance: IntArray, rate: float) -> tuple[csr_matrix, IntArray]:
    """Averages over each sample's time (T, F), and the stance that each sample is of (T,)."""
    wanted = np.flatnonzero(stance >= 0)
    pairs = np.stack((stance, np.floor(time * rate + 1e-6).astype(np.int64)), axis=1)[wanted]
    names, inverse, count = np.unique(pairs, axis=0, return_inverse=True, return_counts=True)
    inverse = np.asarray(inverse).reshape(-1)
    weights = csr_matrix((1.0 / count[inverse], (inverse, wanted)), shape=(len(names), len(time)))
    return weights, names[:, 0]


def _readings(scene: Scene, states: BodyStates, loaded: BoolArray, weight: float) -> FloatArray:
    """(F, n) that the channels would show; one whose gain says nothing stays where it was."""
    support = _support(states, np.asarray(loaded.all(axis=1)))
    cop = states.com[np.arange(len(loaded)), np.where(loaded[:, 0], 0, 1), :2]
    wrench = at_cop(np.full(len(loaded), weight), cop)
    outputs = np.zeros((len(loaded), len(scene.wiring.foot)))
    for kind in np.unique(loaded, axis=0):
        part = (loaded == kind).all(axis=1)
        outputs[part] = _shared(scene, kind, support, wrench[part])
    gain, offset = scene.parameters.gain, scene.parameters.offset
    telling = np.abs(gain) > LEAST_GAIN * np.abs(gain).max()
    usual = np.broadcast_to(np.median(scene.samples.readings, axis=0), outputs.shape)
    found: FloatArray = np.where(telling, (outputs - offset) / np.where(telling, gain, 1.0), usual)
    return found


def _support(states: BodyStates, both: BoolArray) -> DoubleSupport:
    dx, dy = np.median(states.translation[both, :2], axis=0)
    return DoubleSupport(float(dx), float(dy), float(np.median(states.yaw[both])))


def _shared(
    scene: Scene, loaded: BoolArray, support: DoubleSupport, wrench: FloatArray
) -> FloatArray:
    """(F, n) outputs [N or N m] under a wrench (F, 3) in the stance's frame.

    As near to equal springs as the planes allow on which the cells of each foot were seen to lie:
    else a run that was not recorded would show a parity that no recorded one has.
    """
    samples, wiring = scene.samples, scene.wiring
    below = weight_below(samples.shoe)
    rows, values = [], []
    if loaded.all():
        rows.append(wiring.in_left(support).T)
        values.append(wrench - combined(below, support))
    else:
        for foot in (0, 1):
            rows.append(wiring.of_foot(foot).T)
            values.append(loaded[foot] * wrench - below[foot])
    for foot in np.flatnonzero(loaded & scene.planes.any(axis=1)).tolist():
        rows.append(scene.planes[foot][None])
        usual = scene.outputs[samples.loaded[:, foot]] @ scene.planes[foot]
        values.append(np.full((len(wrench), 1), usual.mean()))
    found: FloatArray = np.hstack(values) @ np.linalg.pinv(np.vstack(rows)).T
    return found
