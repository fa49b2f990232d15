"""Which signals there are, and how they answer to what effects do."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from shoecal_core.arrays import BoolArray, FloatArray
from shoecal_core.error_sources import body
from shoecal_core.error_sources.loads import Loads
from shoecal_core.error_sources.signals import (
    AIR,
    CLOSURE,
    COP,
    FAMILIES,
    FLAT_OF_CLOSURE,
    PARITY,
    SIGNALS,
    TILT,
)
from shoecal_core.robot.gravity import GRAVITY

QUASI_STATIC_M = 6e-4
"""Root mean square of the zero-moment point's way off the CoM along an axis, up to which a motion
is slow: half of what the CoP of a robot within tolerance is off. Standard motions have 5e-4 m."""


@dataclass(frozen=True)
class Responses(Loads):
    """What a change of outputs, wrenches, angles or the model makes of the signals.

    Attributes:
        jacobians: of the body to its joints.
        planes: (2, n) combination of outputs that is constant on each foot; zero where its
            cells are not known to lie on one plane.
        without: families of signals left out.
        outliers: (T, s) values that count for nothing.
    """

    jacobians: body.JointJacobians
    planes: FloatArray
    without: frozenset[str]
    outliers: BoolArray

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

    def by_outputs(self, change: FloatArray, *, settled: bool = True) -> FloatArray:
        """(T, s) when channels show `change` (T, n) [N or N m] more than the load they feel."""
        added = np.einsum("tn,tnw->tw", change, self.per_sample)
        found = self.by_wrench(added, settled=False)
        feet = np.stack([change @ self.wiring.of_foot(foot) for foot in (0, 1)], axis=1)
        found[:, AIR] = self.hanging(feet)
        found[:, PARITY] = change @ self.planes.T
        return self.settled(found) if settled else found

    def by_wrench(self, change: FloatArray, *, settled: bool = True) -> FloatArray:
        """(T, s) when the wrench measured on what stands has `change` (T, 3) [N, N m] more."""
        force = np.maximum(self.wrench[:, 0], 0.2 * self.samples.force)
        found = np.zeros((len(change), len(SIGNALS)))
        found[:, 0] = change[:, 0]
        found[:, 1] = (-change[:, 2] - self.cop[:, 0] * change[:, 0]) / force
        found[:, 2] = (change[:, 1] - self.cop[:, 1] * change[:, 0]) / force
        return self.settled(found) if settled else found

    def by_angles(self, change: FloatArray) -> FloatArray:
        """(T, s) when encoders show `change` (T, m) [rad] more than the true angles."""
        found = np.zeros((len(change), len(SIGNALS)))
        found[:, COP] = -np.einsum("tim,tm->ti", self.jacobians.cop, change)
        found[:, CLOSURE] = np.einsum("tim,tm->ti", self.jacobians.closure, change)
        found[:, TILT] = np.einsum("tim,tm->ti", self.jacobians.tilt, change)
        # As `Samples.supports` takes the right foot's place: the median of a segment.
        support = self.samples.segment_medians(found[:, CLOSURE][:, (0, 1, 5)])
        found[:, COP] += self.by_support(support)[:, COP]
        return self.settled(found)

    def held(self, given: FloatArray) -> FloatArray:
        """(T, m) what joints (T, m) give by [rad] where both feet stand, without what the floor
        forbids: soles on it move neither along it nor off it.

        By whatever law a gear gives, the others give way, all alike as far as is known, until the
        soles lie where they are held. Walking, soles may tip: then they are held along the floor.
        """
        legs = self.samples.robot.moved
        found = given.copy()
        moved = np.einsum("tkm,tm->tk", self.jacobians.closure[..., legs], given[:, legs])
        found[:, legs] -= np.einsum("tkm,tk->tm", self._holding, moved)
        return np.where(self.samples.both[:, None], found, given)

    @cached_property
    def _holding(self) -> FloatArray:
        """(T, 6, legs) of what moves the right sole in the left's, how joints undo it."""
        across = self.jacobians.closure[..., self.samples.robot.moved].copy()
        across[self.samples.walks, FLAT_OF_CLOSURE] = 0.0
        inverse = np.linalg.pinv(np.einsum("tkm,tlm->tkl", across, across), hermitian=True)
        found: FloatArray = np.einsum("tkl,tlm->tkm", inverse, across)
        return found

    def by_support(self, change: FloatArray) -> FloatArray:
        """(T, s) when the right foot is taken to stand (T, 3) dx, dy [m], dtheta [rad] further."""
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
        """(T, s) when force and CoP truly are (T,) [N] and (T, 2) [m] more than expected."""
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

    # What every robot does

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

    @property
    def fast(self) -> bool:
        """Whether the zero-moment point is so far off the CoM that it counts as an effect."""
        return bool(np.sqrt(np.mean(self.zero_moment**2)) > QUASI_STATIC_M)

    # What of it counts

    def settled(self, values: FloatArray) -> FloatArray:
        """(T, s) signals as they count: where a foot stands is only known not to change.

        That soles stand flat is known as well, but for a robot that walks.
        """
        values = values.copy()
        means = self.samples.segment_means(values[:, CLOSURE])
        means[~self.samples.walks, FLAT_OF_CLOSURE] = 0.0
        values[:, CLOSURE] -= means
        return np.where(self.mask, values, 0.0)

    def hanging(self, feet: FloatArray) -> FloatArray:
        """(T, 3) wrench of the foot in the air, of both feet's (T, 2, 3) [N, N m]."""
        return np.where(self.samples.loaded[:, :1], feet[:, 1], feet[:, 0])
