"""All signals of a session under one set of channel parameters, and what changes them."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from shoecal_core.diagnosis import body
from shoecal_core.diagnosis.filters import play
from shoecal_core.diagnosis.planes import cell_planes
from shoecal_core.diagnosis.samples import Samples, Track
from shoecal_core.diagnosis.settings import DiagnosisSettings
from shoecal_core.diagnosis.signals import (
    AIR,
    CLOSURE,
    COP,
    FAMILIES,
    FLAT,
    FLAT_OF_CLOSURE,
    GRF,
    OWN_ERRORS,
    PARITY,
    SIGNALS,
    TILT,
)
from shoecal_core.model.double_support import DoubleSupport
from shoecal_core.model.robot import GRAVITY
from shoecal_core.sensing.wrench import (
    ChannelParameters,
    combined,
    to_left,
    weight_below,
)

FloatArray = NDArray[np.float64]
BoolArray = NDArray[np.bool_]

FREE = 1e6
"""Prior of what may have any size."""
LOOP_WIDTHS = (0.1, 0.2, 0.3)
"""Widths of plays, over the range of a channel's output in a motion."""
QUASI_STATIC_M = 4.2e-4
"""Root mean square of the zero-moment point's way off the CoM in a motion meant to be slow."""
LEAST_STANDING_M, LEAST_STANDING_RAD, BRACED_SHARE = 1e-4, 4e-4, 5e-4
"""Least scatter from stance to stance of CoP and tilt, and that of the vertical force over it."""
LEAST_FLAT = (1e-4, 1e-3, 1e-3)
"""The same of how flat the soles stand: height [m], roll and pitch [rad]."""


@dataclass(frozen=True)
class Wiring:
    """How channels add to the wrench: the shoe file's word, unless a cable says otherwise.

    Attributes:
        columns: (n, 3) of each channel in its own foot's sole frame.
        foot: (n,) that each channel acts on.
    """

    columns: FloatArray
    foot: NDArray[np.int64]


@dataclass(frozen=True)
class Scene:
    """All signals at T samples under one set of channel parameters.

    Attributes:
        samples: of the session.
        parameters: gains and offsets.
        answers: of the body to its joints.
        planes: (2, n) combination of outputs that is constant on each foot; zero where its
            cells are not known to lie on one plane.
        without: families of signals left out.
        wiring: of the channels.
        zero_std: how well the joints' zeros are set [rad].
        outliers: (T, s) values that count for nothing.
    """

    samples: Samples
    parameters: ChannelParameters
    answers: body.Answers
    planes: FloatArray
    without: frozenset[str]
    wiring: Wiring
    zero_std: float
    outliers: BoolArray

    # What is measured

    @cached_property
    def outputs(self) -> FloatArray:
        """(T, n) [N or N m]."""
        return self.parameters.outputs(self.samples.readings)

    @property
    def supports(self) -> tuple[DoubleSupport, ...]:
        """Where the right foot stands in each segment, from the joints."""
        return self.samples.supports

    @cached_property
    def columns(self) -> FloatArray:
        """(segments, n, 3) of every channel in the stance's frame, those in the air zero."""
        stacked = []
        for segment, support in enumerate(self.supports):
            left, right = self.samples.standing[segment]
            if left and right:
                turned = _turned(self.wiring, support)
            else:
                turned = np.where(
                    (self.wiring.foot == (0 if left else 1))[:, None], self.wiring.columns, 0.0
                )
            stacked.append(turned)
        return np.array(stacked)

    @cached_property
    def per_sample(self) -> FloatArray:
        """(T, n, 3) the same, of each sample."""
        return self.columns[self.samples.segment]

    @cached_property
    def foot_wrenches(self) -> FloatArray:
        """(T, 2, 3) of each foot in its sole frame [N, N m]."""
        each = [
            self.outputs @ np.where((self.wiring.foot == foot)[:, None], self.wiring.columns, 0.0)
            for foot in (0, 1)
        ]
        return np.stack(each, axis=1) + weight_below(self.samples.shoe)

    @cached_property
    def wrench(self) -> FloatArray:
        """(T, 3) on all feet that stand, in the stance's frame [N, N m]."""
        base = weight_below(self.samples.shoe)
        fixed = []
        for segment, support in enumerate(self.supports):
            left, right = self.samples.standing[segment]
            fixed.append(combined(base, support) if left and right else base[0 if left else 1])
        found: FloatArray = (
            np.einsum("tn,tnw->tw", self.outputs, self.per_sample)
            + np.array(fixed)[self.samples.segment]
        )
        return found

    @cached_property
    def cop(self) -> FloatArray:
        """(T, 2) measured, in the stance's frame [m]."""
        force = np.maximum(self.wrench[:, 0], 0.2 * self.samples.force)
        place: FloatArray = np.stack((-self.wrench[:, 2], self.wrench[:, 1]), axis=1)
        return place / force[:, None]

    @cached_property
    def zero_moment(self) -> FloatArray:
        """(T, 2) zero-moment point less the modelled CoP [m].

        By the CoM's acceleration and the whole body's angular momentum; where the robot walks the
        model has the first already, and the second is left.
        """
        samples = self.samples
        height = samples.states.com[np.arange(len(samples.run)), samples.frame, 2]
        away: FloatArray = -(height / GRAVITY)[:, None] * samples.acceleration[:, :2] + samples.spin
        return away

    @property
    def dynamic(self) -> FloatArray:
        """(T, s) of a body that accelerates: more force, and the zero-moment point."""
        samples = self.samples
        mass = samples.force / GRAVITY
        return self.by_model(mass * samples.acceleration[:, 2], self.zero_moment)

    @cached_property
    def torque(self) -> FloatArray:
        """(T, m) that the joints hold with [N m].

        As the robot tells it, where it does; of joints on one motor it tells but the sum, so these
        and all others are what the vertical forces on the feet ask for.
        """
        samples = self.samples
        torque = self.links.torque.copy()
        if all(track.efforts is not None for track in samples.tracks):
            told = samples.decimated(lambda track: np.asarray(track.efforts))
            shared = {one for pair in samples.robot.shared for one in (pair.joint, pair.leader)}
            own = [joint for joint in samples.robot.moved.tolist() if joint not in shared]
            torque[:, own] = told[:, own]
        return torque

    @property
    def fast(self) -> bool:
        """Whether the zero-moment point is so far off the CoM that it counts as an effect."""
        return bool(np.sqrt(np.mean(self.zero_moment**2)) > QUASI_STATIC_M)

    @cached_property
    def loops(self) -> list[FloatArray]:
        """(T, n) what plays of several widths make of the outputs, a unit of width; each less them.

        A play of width w, turned round, makes a loop w high. Loops are as high as the ranges are
        wide that motions go through, so that widths are over these: a foot that was in the air
        once has seen a far larger range, but only once.
        """
        span = self.usual_range

        def loop(width: float) -> FloatArray:
            def work(track: Track) -> FloatArray:
                force = self.parameters.outputs(track.readings)
                return (play(force, width * span) - force) / width

            return self.samples.decimated(work)

        return [loop(width) for width in LOOP_WIDTHS]

    @property
    def usual_range(self) -> FloatArray:
        """(n,) of the outputs in the median run, while both feet stand."""
        samples = self.samples
        ranges = [
            np.ptp(self.outputs[here], axis=0)
            for run in samples.runs
            if np.any(here := samples.both & (samples.run == run))
        ]
        usual: FloatArray = np.median(ranges or [np.ptp(self.outputs, axis=0)], axis=0)
        return usual

    @cached_property
    def links(self) -> body.Links:
        """Places of the links, and torques."""
        return body.links(self.samples, self.foot_wrenches)

    # Signals

    @cached_property
    def mask(self) -> BoolArray:
        """(T, s) signals that are there."""
        samples = self.samples
        both = samples.both
        there = np.zeros((len(both), len(SIGNALS)), dtype=np.bool_)
        there[:, :3] = True
        there[:, AIR] = ~both[:, None]
        there[:, CLOSURE] = both[:, None]
        there[:, PARITY] = self.planes.any(axis=1) & samples.loaded
        there[:, TILT] = np.isfinite(samples.up).all(axis=1, keepdims=True)
        for family in self.without:
            there[:, FAMILIES[family]] = False
        return there & ~self.outliers

    @cached_property
    def residuals(self) -> FloatArray:
        """(T, s) measured minus modelled; zero where a signal is not there."""
        samples = self.samples
        found = np.zeros((len(samples.run), len(SIGNALS)))
        found[:, GRF] = (self.wrench[:, 0] - samples.force)[:, None]
        found[:, COP] = self.cop - samples.cop
        found[:, AIR] = self._hanging(self.foot_wrenches)
        found[:, CLOSURE] = body.closure(samples.states)
        found[:, PARITY] = self.outputs @ self.planes.T
        up = np.where(np.isfinite(samples.up), samples.up, 0.0)
        found[:, TILT] = body.up_in_sole(samples.states, samples.frame, up)[:, :2]
        return self.settled(found)

    @cached_property
    def baseline(self) -> FloatArray:
        """(p, T, s) derivatives by gains and offsets; then what `nuisances` may add."""
        count, channels = self.outputs.shape
        gains = [self._of_channel(i, one) for i, one in enumerate(self.samples.readings.T)]
        offsets = [self._of_channel(i, np.ones(count)) for i in range(channels)]
        others = [column for column, _ in self.nuisances]
        return np.array([self.settled(one) for one in (*gains, *offsets, *others)])

    def _of_channel(self, channel: int, values: FloatArray) -> FloatArray:
        change = np.zeros_like(self.outputs)
        change[:, channel] = values
        column = self.by_outputs(change, settled=False)
        # Which way a plane leans is found from the outputs; gains do not tell it.
        column[:, PARITY] = 0.0
        return column

    @cached_property
    def nuisances(self) -> list[tuple[FloatArray, float]]:
        """What may be there in any recording, each (T, s) with its prior standard deviation."""
        count = len(self.samples.run)
        found: list[tuple[FloatArray, float]] = []

        def add(signal: int, values: FloatArray, std: float) -> None:
            column = np.zeros((count, len(SIGNALS)))
            column[:, signal] = values
            found.append((column, std))

        for foot in (0, 1):
            own = np.flatnonzero(self.wiring.foot == foot)
            if self.planes[foot].any():
                others = np.linalg.svd(self.planes[foot, own][None])[2][1:]
                for values in (*(self.outputs[:, own] @ others.T).T, np.ones(count)):
                    add(PARITY.start + foot, values, FREE)
        # Accelerations move the zero-moment point; how much, a rigid body tells roughly.
        if not self.fast:
            found.append((self.dynamic, FREE))
        for axis in range(TILT.start, TILT.stop):
            add(axis, np.ones(count), FREE)
        for axis, std in enumerate(self.zero_errors, FLAT.start):
            add(axis, np.ones(count), std)
        # Encoders stand on one step or the next for a whole stance: an error of its own.
        steps = self.standing_errors
        for segment in self.slow_segments:
            here = (self.samples.segment == segment).astype(np.float64)
            for signal in OWN_ERRORS:
                add(signal, here, steps[signal])
        return found

    @cached_property
    def zero_errors(self) -> FloatArray:
        """(3,) of height, roll and pitch between the soles, by what joints' zeros are off."""
        answer = self.answers.closure[:, FLAT_OF_CLOSURE]
        spread: FloatArray = np.sqrt(np.mean(np.sum(answer**2, axis=2), axis=0))
        return self.zero_std * spread

    @cached_property
    def slow_segments(self) -> tuple[int, ...]:
        """Segments of slow runs; in a walk a stance's own error drowns in the dynamics."""
        samples = self.samples
        return tuple(np.unique(samples.segment[~samples.walks]).tolist())

    @cached_property
    def standing_errors(self) -> FloatArray:
        """(s,) standard deviation of what a stance adds to each signal by itself.

        From the encoders' steps, each joint by itself; the vertical force has the scatter of a
        robot that braces its legs against each other.
        """
        step = self.samples.encoder_step / np.sqrt(12.0)
        found = np.zeros(len(SIGNALS))
        found[0] = BRACED_SHARE * float(self.samples.force.mean())
        for part, answer, least in (
            (COP, self.answers.cop, LEAST_STANDING_M),
            (TILT, self.answers.tilt, LEAST_STANDING_RAD),
            (FLAT, self.answers.closure[:, FLAT_OF_CLOSURE], np.array(LEAST_FLAT)),
        ):
            spread = np.sqrt(np.mean(np.sum((answer * step) ** 2, axis=2), axis=0))
            found[part] = np.maximum(spread, least)
        return found

    # What effects do to them

    def by_outputs(self, change: FloatArray, *, settled: bool = True) -> FloatArray:
        """(T, s) when channels show `change` (T, n) more than the force they feel."""
        added = np.einsum("tn,tnw->tw", change, self.per_sample)
        found = self.by_wrench(added, settled=False)
        feet = np.stack(
            [
                change @ np.where((self.wiring.foot == foot)[:, None], self.wiring.columns, 0.0)
                for foot in (0, 1)
            ],
            axis=1,
        )
        found[:, AIR] = self._hanging(feet)
        found[:, PARITY] = change @ self.planes.T
        return self.settled(found) if settled else found

    def by_wrench(self, change: FloatArray, *, settled: bool = True) -> FloatArray:
        """(T, s) when the wrench measured on what stands has `change` (T, 3) more."""
        force = np.maximum(self.wrench[:, 0], 0.2 * self.samples.force)
        found = np.zeros((len(change), len(SIGNALS)))
        found[:, 0] = change[:, 0]
        found[:, 1] = (-change[:, 2] - self.cop[:, 0] * change[:, 0]) / force
        found[:, 2] = (change[:, 1] - self.cop[:, 1] * change[:, 0]) / force
        return self.settled(found) if settled else found

    def by_angles(self, change: FloatArray) -> FloatArray:
        """(T, s) when encoders show `change` (T, m) more than the true angles."""
        found = np.zeros((len(change), len(SIGNALS)))
        found[:, COP] = -np.einsum("tim,tm->ti", self.answers.cop, change)
        found[:, CLOSURE] = np.einsum("tim,tm->ti", self.answers.closure, change)
        found[:, TILT] = np.einsum("tim,tm->ti", self.answers.tilt, change)
        # As `Samples.supports` takes the right foot's place: the median of a segment.
        support = self.segment_medians(found[:, CLOSURE][:, (0, 1, 5)])
        found[:, COP] += self.by_support(support)[:, COP]
        return self.settled(found)

    def by_support(self, change: FloatArray) -> FloatArray:
        """(T, s) when the right foot is taken to stand (T, 3) dx, dy, dtheta further."""
        samples = self.samples
        both = samples.both
        force, about_x, about_y = self.foot_wrenches[:, 1].T
        yaw = np.array([support.dtheta for support in self.supports])[samples.segment]
        dx, dy, turn = change.T
        c, s = np.cos(yaw), np.sin(yaw)
        mx = dy * force + turn * (-s * about_x - c * about_y)
        my = -dx * force + turn * (c * about_x - s * about_y)
        wrench = np.stack((np.zeros_like(force), mx, my), axis=1)
        return self.by_wrench(np.where(both[:, None], wrench, 0.0))

    def by_model(self, force: FloatArray | float, cop: FloatArray) -> FloatArray:
        """(T, s) when truly the force (T,) is more than expected, and the CoP is off by (T, 2)."""
        found = np.zeros((len(cop), len(SIGNALS)))
        found[:, 0] = force
        found[:, COP] = cop
        return found

    def tilted(self, slope: FloatArray) -> FloatArray:
        """(T, s) when soles lean: upwards has (T, 2) x, y in the stance's sole frame."""
        samples = self.samples
        height = samples.states.com[np.arange(len(slope)), samples.frame, 2]
        found = np.zeros((len(slope), len(SIGNALS)))
        found[:, COP] = -height[:, None] * slope
        found[:, TILT] = slope
        return found

    def segment_means(self, values: FloatArray) -> FloatArray:
        """(T, ...) each sample's segment's mean."""
        segment = self.samples.segment
        count = np.maximum(np.bincount(segment), 1)
        flat = values.reshape(len(values), -1)
        sums = np.stack([np.bincount(segment, weights=column) for column in flat.T], axis=1)
        means: FloatArray = (sums / count[:, None])[segment].reshape(values.shape)
        return means

    def segment_medians(self, values: FloatArray) -> FloatArray:
        """(T, k) of values (T, k): each sample's segment's median."""
        segment = self.samples.segment
        found = np.zeros((int(segment.max()) + 1, values.shape[1]))
        for one in np.unique(segment):
            found[one] = np.median(values[segment == one], axis=0)
        return found[segment]

    def settled(self, values: FloatArray) -> FloatArray:
        """Signals as they count: where a foot stands is only known not to change.

        That soles stand flat is known as well, but for a robot that walks.
        """
        values = values.copy()
        means = self.segment_means(values[:, CLOSURE])
        means[~self.samples.walks, FLAT_OF_CLOSURE] = 0.0
        values[:, CLOSURE] -= means
        return np.where(self.mask, values, 0.0)

    def _hanging(self, feet: FloatArray) -> FloatArray:
        """(T, 3) wrench of the foot in the air, of both feet's (T, 2, 3)."""
        return np.where(self.samples.loaded[:, :1], feet[:, 1], feet[:, 0])

    # Variations

    def with_parameters(self, parameters: ChannelParameters) -> Scene:
        """Under other gains and offsets."""
        return replace(self, parameters=parameters)

    def leaving_out(self, outliers: BoolArray) -> Scene:
        """Without values (T, s) that nothing explains, and those left out before."""
        return replace(self, outliers=self.outliers | outliers)

    def with_planes(self, settings: DiagnosisSettings) -> Scene:
        """With the planes of the cells as the outputs now show them."""
        return replace(self, planes=cell_planes(self.samples, self.parameters, settings))


def make_scene(
    samples: Samples,
    parameters: ChannelParameters,
    settings: DiagnosisSettings,
    without: frozenset[str] = frozenset(),
) -> Scene:
    """The scene under first parameters; planes are found from the readings."""
    shoe = samples.shoe
    return Scene(
        samples=samples,
        parameters=parameters,
        answers=body.answers(samples),
        planes=cell_planes(samples, parameters, settings),
        without=without,
        wiring=Wiring(shoe.columns, shoe.foot),
        zero_std=settings.joint_zero_rad,
        outliers=np.zeros((len(samples.run), len(SIGNALS)), dtype=np.bool_),
    )


def _turned(wiring: Wiring, support: DoubleSupport) -> FloatArray:
    """(n, 3) in the left sole's frame."""
    columns = wiring.columns.copy()
    right = wiring.foot == 1
    columns[right] = columns[right] @ to_left(support).T
    return columns
