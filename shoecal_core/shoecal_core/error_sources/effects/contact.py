"""Effects below the ankles: feet elsewhere, floors that lean or give."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from shoecal_core.arrays import FloatArray
from shoecal_core.error_sources.base import ALL, Component, Place, Shape
from shoecal_core.error_sources.effects import places
from shoecal_core.error_sources.signal_model import SignalModel
from shoecal_core.error_sources.signals import CLOSURE, COP, ROLL_PITCH
from shoecal_core.error_sources.steps import step_times
from shoecal_core.shoe.shoe import FEET

MOVES = (Component("dx", "m", 0.004), Component("dy", "m", 0.004), Component("dtheta", "rad", 0.03))
TURNED = "turn_180"
"""Motion's name of a run for which the robot was turned by half a turn on the same floor."""


class FootPlacement:
    """A shoe sits askew below its ankle."""

    identifier, group = "foot_placement", "contact"
    components = (
        Component("dx", "m", 0.004, as_built="foot_placement_m"),
        Component("dy", "m", 0.004, as_built="foot_placement_m"),
        Component("dtheta", "rad", 0.03, as_built="foot_placement_rad"),
    )

    def places(self, signal_model: SignalModel) -> Iterator[Place]:
        """Each foot."""
        return places.each_foot(signal_model)

    def shapes(self, signal_model: SignalModel, place: Place) -> Iterator[Shape]:
        """All that is measured in this sole's frame is measured in a frame that is off."""
        foot = FEET.index(place[0])
        columns = [
            moved_sole(signal_model, foot, axis, np.ones(len(signal_model.samples.run)))
            for axis in range(3)
        ]
        yield Shape(("dx", "dy", "dtheta"), np.array(columns))


class Slip:
    """A foot moves on the floor at a moment, and stays there."""

    identifier, group = "slip", "contact"
    components = (*MOVES, Component("time", "s", 30.0))

    def places(self, signal_model: SignalModel) -> Iterator[Place]:
        """Each foot."""
        return places.each_foot(signal_model)

    def shapes(self, signal_model: SignalModel, place: Place) -> Iterator[Shape]:
        """A step at each of many moments of each run."""
        foot = FEET.index(place[0])
        samples = signal_model.samples
        whole = [slipped(signal_model, foot, axis) for axis in range(3)]
        both = samples.both
        for track in samples.tracks:
            here = (samples.run == track.run) & both
            signals = np.hstack(
                (signal_model.residuals[here][:, CLOSURE], signal_model.residuals[here][:, COP])
            )
            for onset in step_times(samples.time[here], signals):
                later = (here & (samples.time > onset)).astype(np.float64)
                # The right foot's place is the segment's median: where it mostly stands.
                course = later - (samples.segment_means(later) > 0.5)
                columns = np.array([signal_model.settled(one * course[:, None]) for one in whole])
                yield Shape(("dx", "dy", "dtheta"), columns, {"time": onset}, track.run, onset)


def slipped(signal_model: SignalModel, foot: int, axis: int) -> FloatArray:
    """(T, s) after a foot moved along one axis of its own frame, by the joint angles.

    The place by which the CoP is measured is as before. Not yet settled.
    """
    samples = signal_model.samples
    yaw = np.array([support.dtheta for support in signal_model.supports])[samples.segment]
    place = samples.states.translation[:, :2]
    found = np.zeros_like(signal_model.residuals)
    change = np.zeros((len(yaw), 3))
    if foot == 1:
        if axis < 2:
            turned = (np.cos(yaw), np.sin(yaw)) if axis == 0 else (-np.sin(yaw), np.cos(yaw))
            change[:, :2] = np.stack(turned, axis=1)
        else:
            change[:, 2] = 1.0
    elif axis < 2:
        change[:, axis] = -1.0
    else:
        change[:] = np.stack((place[:, 1], -place[:, 0], np.full(len(yaw), -1.0)), axis=1)
    # The shoe truly moved: the measured CoP takes the right foot where it no longer stands.
    found += signal_model.by_support(-change)
    found[:, CLOSURE] = change[:, [0, 1, 2, 2, 2, 2]] * np.array([1.0, 1.0, 0.0, 0.0, 0.0, 1.0])
    return found


def moved_sole(signal_model: SignalModel, foot: int, axis: int, how_far: FloatArray) -> FloatArray:
    """(T, s) when a sole is truly further along one axis of its frame (x, y, turn) a unit.

    The stance's frame is the true sole, into which the model's CoM is transformed.
    """
    samples = signal_model.samples
    states = samples.states
    frame = samples.frame
    step = 1e-6
    turn = np.eye(3)
    shift = np.zeros(3)
    if axis < 2:
        shift[axis] = step
    else:
        turn = np.array([[1.0, -step, 0.0], [step, 1.0, 0.0], [0.0, 0.0, 1.0]])
    com = states.com.copy()
    com[:, foot] = (com[:, foot] - shift) @ turn
    if foot == 0:
        rotation = turn.T @ states.rotation
        translation = (states.translation - shift) @ turn
    else:
        rotation = states.rotation @ turn
        translation = states.translation + states.rotation @ shift
    rows = np.arange(len(frame))
    cop = (com - states.com)[rows, frame, :2] / step
    yaw = np.arctan2(rotation[:, 1, 0], rotation[:, 0, 0])
    # What the model says falls behind the truth by this.
    support = np.column_stack(((translation - states.translation)[:, :2], yaw - states.yaw)) / step
    found = signal_model.by_support(-support)
    found[:, COP] += cop
    return signal_model.settled(found * how_far[:, None])


class FloorTilt:
    """The floor is not level."""

    identifier, group = "floor_tilt", "contact"
    components = (
        Component("about_x", "rad", 0.02, as_built="floor_tilt_rad"),
        Component("about_y", "rad", 0.02, as_built="floor_tilt_rad"),
    )

    def places(self, signal_model: SignalModel) -> Iterator[Place]:
        """Below both feet."""
        yield ()

    def shapes(self, signal_model: SignalModel, place: Place) -> Iterator[Shape]:
        """Upwards leans in the sole frames; the left sole stands along the floor's x axis.

        In runs for which the robot was turned it stands against it.
        """
        samples = signal_model.samples
        yaw = np.array([support.dtheta for support in signal_model.supports])[samples.segment]
        turn = np.where(samples.frame == 0, 0.0, yaw)
        turned = [track.run for track in samples.tracks if track.motion == TURNED]
        turn = turn + np.where(np.isin(samples.run, turned), np.pi, 0.0)
        c, s = np.cos(turn), np.sin(turn)
        columns = []
        for x, y in ((0.0, 1.0), (-1.0, 0.0)):
            slope = np.stack((c * x + s * y, -s * x + c * y), axis=1)
            columns.append(signal_model.settled(signal_model.tilted(slope)))
        yield Shape(("about_x", "about_y"), np.array(columns))


class SoftGround:
    """A shoe leans into the floor below its load."""

    identifier, group = "soft_ground", "contact"
    components = (
        Component(
            "compliance", "rad/(N m)", 0.008, 0.0, form=3.0, as_built="sole_compliance_rad_per_nm"
        ),
    )

    def places(self, signal_model: SignalModel) -> Iterator[Place]:
        """Each foot, or both alike."""
        return places.feet_and_all(signal_model)

    def shapes(self, signal_model: SignalModel, place: Place) -> Iterator[Shape]:
        """Each sole turns with the moment about its middle."""
        feet = (0, 1) if place[0] == ALL else (FEET.index(place[0]),)
        yield Shape(("compliance",), self._column(signal_model, feet)[None])

    def _column(self, signal_model: SignalModel, feet: tuple[int, ...]) -> FloatArray:
        samples = signal_model.samples
        lean = np.zeros((len(samples.run), 2, 2))
        for foot in feet:
            force, about_x, about_y = signal_model.foot_wrenches[:, foot].T
            x, y = samples.robot.feet[foot].outline.mean(axis=0)
            lean[:, foot] = np.stack((about_x - y * force, about_y + x * force), axis=1)
        lean[~samples.loaded] = 0.0
        # The floor's moment turns a sole the other way; turned by (a, b) about x and y it sees
        # upwards at (-b, a).
        turn = -lean
        own = np.where((samples.frame == 0)[:, None], turn[:, 0], turn[:, 1])
        found = signal_model.tilted(np.stack((-own[:, 1], own[:, 0]), axis=1))
        left_in_right = np.einsum("tji,tj->ti", samples.states.rotation[:, :2, :2], turn[:, 0])
        found[:, ROLL_PITCH] = turn[:, 1] - left_in_right
        return signal_model.settled(found)
