"""How recorded runs become samples: aligned, cut into stances, averaged."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.ndimage import uniform_filter1d
from scipy.sparse import csr_matrix

from shoecal_core.arrays import BoolArray, FloatArray, IntArray
from shoecal_core.errors import ShoecalError
from shoecal_core.recording.run import Run
from shoecal_core.robot.gravity import GRAVITY
from shoecal_core.robot.kinematics import Kinematics
from shoecal_core.robot.robot import Robot
from shoecal_core.samples.aligned import Aligned
from shoecal_core.samples.filters import evenly, typical_period
from shoecal_core.samples.known_weight import carried, with_mass
from shoecal_core.samples.lifting import (
    BOTH_STAND,
    NEITHER,
    TRANSIT_S,
    hanging_foot,
    height_change,
)
from shoecal_core.samples.momentum import standing_spin
from shoecal_core.samples.samples import Samples, Track
from shoecal_core.samples.settings import SampleSettings
from shoecal_core.samples.side_channels import efforts, temperature, upwards
from shoecal_core.samples.stretches import unchanged
from shoecal_core.samples.walking_samples import Walk, find_walk, pieces
from shoecal_core.shoe.shoe import Shoe
from shoecal_core.shoe.vertical import at_least_load

MIN_SEGMENT_S = 0.8
LEAST_FILLED = 0.5
"""Part of a sample's time in which there must be readings."""
SMOOTHING_S = 0.1
"""Encoder steps in so long a time are averaged before motion is derived from them."""


def make_samples(
    read: Sequence[tuple[Run, Aligned]],
    shoe: Shoe,
    kinematics: Kinematics,
    settings: SampleSettings,
    kept: Mapping[int, BoolArray] | None = None,
    air: Mapping[int, BoolArray] | None = None,
    load: Mapping[int, FloatArray] | None = None,
    notes: list[str] | None = None,
) -> Samples | None:
    """Samples of runs that were read and aligned; None where no run gives any.

    Args:
        read: runs with the joint angles at the times of their readings.
        shoe, kinematics: of what was recorded.
        settings: rates.
        kept: by run, (T,) which of the aligned readings count; all of runs that are not listed.
        air: by run, (T,) at which of them one foot hangs free, none in runs that are not listed;
            None: where heights say so.
        load: by run, (T, 2) what each foot carries as a share of the weight; a foot that carries
            is not in the air. Runs that are not listed: not known.
        notes: takes why runs are left out.
    """
    notes = [] if notes is None else notes
    parts = _parts(read, kinematics, shoe, settings, kept or {}, air, load or {}, notes)
    return _joined(parts, shoe, kinematics) if parts else None


def _parts(
    read: Sequence[tuple[Run, Aligned]],
    kinematics: Kinematics,
    shoe: Shoe,
    settings: SampleSettings,
    kept: Mapping[int, BoolArray],
    air: Mapping[int, BoolArray] | None,
    load: Mapping[int, FloatArray],
    notes: list[str],
) -> list[_Part]:
    """Samples of each run that has any; of the others it is noted why not."""
    first_ns = min((run.start_ns for run, _ in read), default=0)
    duration = sum(float(aligned.time[-1] - aligned.time[0]) for _, aligned in read)
    walks = any(run.info.support is None for run, _ in read)
    wanted = settings.walking_rate_hz if walks else settings.rate_hz
    rate = min(wanted, settings.samples_max / max(duration, 1.0))
    parts: list[_Part] = []
    at, segments = 0, 0
    for run, aligned in read:
        try:
            everything = np.ones(len(aligned.time), dtype=bool)
            counts = kept.get(run.info.run, everything)
            hangs = (
                height_change(aligned.states) > settings.lifted_m
                if air is None
                else air.get(run.info.run, ~everything)
            )
            part = _part(
                run, aligned, counts, hangs, load.get(run.info.run), kinematics, shoe, settings,
                rate, at, segments, first_ns,
            )  # fmt: skip
        except ShoecalError as error:
            notes.append(f"run {run.info.run} is left out: {error}")
            continue
        if part is None:
            notes.append(f"run {run.info.run} is left out: no stance in it is long enough")
            continue
        parts.append(part)
        at, segments = part.track.samples.stop, int(part.segment.max()) + 1
    return parts


def _joined(
    parts: Sequence[_Part],
    shoe: Shoe,
    kinematics: Kinematics,
) -> Samples:
    """One after the other."""
    robot = kinematics.robot
    angles = np.concatenate([part.track.mean(part.track.angles) for part in parts])
    mass = np.concatenate(
        [np.full(len(part.segment), carried(part.track.motion)) for part in parts]
    )
    states = with_mass(kinematics.states(angles), robot, mass)
    loaded = np.concatenate([part.loaded for part in parts])
    frame = np.where(loaded[:, 0], 0, 1)
    rows = np.arange(len(frame))
    up = np.concatenate(
        [
            np.full((len(part.segment), 3), np.nan)
            if part.track.up is None
            else part.track.mean(part.track.up)
            for part in parts
        ]
    )
    acceleration = np.concatenate([part.acceleration for part in parts])
    force, cop = robot.weight + GRAVITY * mass, states.com[rows, frame, :2]
    walking = np.zeros(len(frame), dtype=bool)
    for part in parts:
        if part.walk is not None:
            here, mean = part.track.samples, part.track.mean
            force[here], cop[here] = mean(part.walk.force), mean(part.walk.cop)
            walking[here] = True
    return Samples(
        robot=robot,
        shoe=shoe,
        tracks=tuple(part.track for part in parts),
        run=np.concatenate([np.full(len(part.segment), part.track.run) for part in parts]),
        time=np.concatenate([part.track.mean(part.track.time) for part in parts]),
        clock=np.concatenate(
            [part.track.start + part.track.mean(part.track.time) for part in parts]
        ),
        segment=np.concatenate([part.segment for part in parts]),
        loaded=loaded,
        readings=np.concatenate([part.track.mean(part.track.readings) for part in parts]),
        angles=angles,
        states=states,
        up=up,
        force=force,
        cop=cop,
        walks=walking,
        acceleration=np.where(walking[:, None], 0.0, acceleration[rows, frame]),
        spin=np.concatenate([part.spin for part in parts]),
        notes=(),
    )


@dataclass(frozen=True)
class _Part:
    track: Track
    segment: IntArray
    loaded: BoolArray
    acceleration: FloatArray
    spin: FloatArray
    walk: Walk | None


def _part(
    run: Run,
    aligned: Aligned,
    counts: BoolArray,
    hangs: BoolArray,
    load: FloatArray | None,
    kinematics: Kinematics,
    shoe: Shoe,
    settings: SampleSettings,
    rate: float,
    at: int,
    segments: int,
    first_ns: int,
) -> _Part | None:
    robot = kinematics.robot
    step = max(1, round(_rate(aligned.time) / settings.filter_rate_hz))
    thin = np.zeros(len(aligned.time), dtype=bool)
    thin[::step] = True
    aligned, counts, hangs = aligned.part(thin), counts[thin], hangs[thin]
    time = aligned.time
    walk = find_walk(run, aligned, shoe, robot) if run.info.support is None else None
    if walk is None:
        load = None if load is None else load[thin]
        stance, loaded = _stances(aligned, hangs, load, robot, shoe, settings)
    else:
        stance, loaded = walk.stance, walk.loaded
    key = np.floor(time * rate) if walk is None else pieces(time, stance, rate)
    chosen = _bins(time, np.where(counts, stance, -1), key, rate)
    if chosen is None:
        return None
    weights, owner = chosen
    # Stances too short for one sample are gone: those left are numbered without gaps.
    kept, owner = np.unique(owner, return_inverse=True)
    carried, loaded, owner = loaded, loaded[kept], owner.reshape(-1)
    com = aligned.states.com
    acceleration = np.gradient(np.gradient(_smooth(com, time), time, axis=0), time, axis=0)
    track = Track(
        run=run.info.run,
        motion=run.info.motion,
        walks=walk is not None,
        start=1e-9 * (run.start_ns - first_ns),
        time=time,
        readings=aligned.readings,
        angles=aligned.joint_angles,
        # Efforts and IMU have the robot's stamps, as the angles have.
        efforts=efforts(run, robot, time + aligned.late_s),
        up=upwards(run, time + aligned.late_s),
        temperature=temperature(run, time),
        com=com,
        samples=slice(at, at + weights.shape[0]),
        weights=weights,
    )
    if walk is None:
        frame = np.where((stance >= 0) & ~carried[stance, 0], 1, 0)
        spin = standing_spin(_smooth(aligned.joint_angles, time), time, frame, kinematics)
    else:
        spin = walk.spin
    means = track.mean(acceleration), track.mean(spin)
    return _Part(track, segments + owner, loaded[owner], *means, walk)


def _rate(time: FloatArray) -> float:
    return 1.0 / typical_period(time)


def _smooth(values: FloatArray, time: FloatArray) -> FloatArray:
    """Averaged over about SMOOTHING_S: a derivative of steps of an encoder is no motion.

    What averages take off a curve is put back, else fast motions would seem slower than they are.
    """

    def smoothed(even: FloatArray, period: float) -> FloatArray:
        width = max(1, 2 * round(0.5 * SMOOTHING_S / period) + 1)
        once = _averaged(even, width)
        return once + _averaged(even - once, width)

    return evenly(smoothed, values, time)


def _averaged(values: FloatArray, width: int) -> FloatArray:
    """Values (F, ...) averaged over some neighbours, twice."""
    once = uniform_filter1d(values, width, axis=0, mode="nearest")
    return np.asarray(uniform_filter1d(once, width, axis=0, mode="nearest"))


def _stances(
    aligned: Aligned,
    air: BoolArray,
    load: FloatArray | None,
    robot: Robot,
    shoe: Shoe,
    settings: SampleSettings,
) -> tuple[IntArray, BoolArray]:
    """Number of the stance of each sample, -1 between two; and which feet carry each stance."""
    time = aligned.time
    hanging = hanging_foot(aligned, air, robot, shoe, load)
    air = hanging != BOTH_STAND
    near = np.zeros(len(air), dtype=bool)
    margin = max(1, round(TRANSIT_S * _rate(time)))
    off = height_change(aligned.states) > 0.3 * settings.lifted_m
    edges = np.flatnonzero(np.diff(off.astype(int)) != 0)
    if air.any():
        for edge in edges:
            near[max(0, edge - margin) : edge + margin + 1] = True
    standing = np.where(air, 2 - hanging, 0)
    standing[near | (hanging == NEITHER)] = -1
    gaps = np.concatenate(([0], np.cumsum(np.diff(time) > 1.0)))
    unloaded = at_least_load(shoe, aligned.readings)
    stance = np.full(len(time), -1)
    loaded: list[tuple[bool, bool]] = []
    for part in unchanged(standing, gaps):
        kind = int(standing[part[0]])
        if kind < 0 or time[part[-1]] - time[part[0]] < MIN_SEGMENT_S:
            continue
        if kind > 0 and np.median(unloaded[part, 2 - kind]) == 0.0:
            continue
        stance[part] = len(loaded)
        loaded.append(((True, True), (True, False), (False, True))[kind])
    return stance, np.array(loaded, dtype=bool).reshape(-1, 2)


def _bins(
    time: FloatArray, stance: IntArray, key: FloatArray, rate: float
) -> tuple[csr_matrix, IntArray] | None:
    """Averages over samples of one stance and key (T, F), and the stance that each is of."""
    pair = np.stack((stance, np.where(stance >= 0, key.astype(np.int64), -1)), axis=1)
    wanted = np.flatnonzero(stance >= 0)
    if not len(wanted):
        return None
    names, inverse, count = np.unique(pair[wanted], axis=0, return_inverse=True, return_counts=True)
    inverse = np.asarray(inverse).reshape(-1)
    full = count >= max(1.0, LEAST_FILLED * min(_rate(time) / rate, float(np.median(count))))
    order = np.cumsum(full) - 1
    keep = full[inverse]
    rows, columns = order[inverse[keep]], wanted[keep]
    weights = csr_matrix(
        (1.0 / count[inverse[keep]], (rows, columns)), shape=(int(full.sum()), len(time))
    )
    return weights, names[full, 0]
