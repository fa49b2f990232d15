"""One optimisation as data: what its states pursue and keep, and what a solver returns."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np
import shapely

from shoecal_core.arrays import BoolArray, FloatArray
from shoecal_core.planning.legs import BALANCE, FootPose
from shoecal_core.planning.settings import PlannerSettings
from shoecal_core.settings import SettingError

TASKS = 5
"""What is pursued: CoP forward and sideways, lean forward and sideways, height."""
FOOT_ROWS = 6
"""Of the foot transform: way and turn."""


@dataclass(frozen=True)
class Scene:
    """What n states in a row have to keep; n is 1 where all states keep the same.

    Attributes:
        foot_poses: (n, 12) T0, poses of the right sole in the left sole's frame, as
            FootPose.parameters.
        shares: (n, 2) least and greatest share of the weight on the left foot.
        normals: (n, h, 2) outward, of the edges of where the CoP may be.
        offsets: (n, h) a CoP c is inside where normals @ c <= offsets [m].
        loaded: (n, 2) whether left, right have to keep load and grip.
        others: (m,) all joint angles, of which those outside the legs count [rad].
    """

    foot_poses: FloatArray
    shares: FloatArray
    normals: FloatArray
    offsets: FloatArray
    loaded: BoolArray
    others: FloatArray

    @classmethod
    def of(
        cls,
        polygon: shapely.Polygon,
        margin: float,
        foot_pose: FootPose,
        others: FloatArray,
        share: tuple[float, float] = (0.0, 1.0),
        loaded: tuple[bool, bool] = (True, True),
    ) -> Scene:
        """One state, its convex polygon moved inwards by a margin [m]; others (m,) [rad]."""
        if polygon.buffer(-margin).is_empty:
            raise SettingError(
                "stability_margin", f"{margin:g} m leaves nothing of the sensing polygon; lower it"
            )
        corners = np.asarray(shapely.geometry.polygon.orient(polygon).exterior.coords)
        edges = np.diff(corners, axis=0)
        normals = np.column_stack([edges[:, 1], -edges[:, 0]])
        normals /= np.linalg.norm(normals, axis=1, keepdims=True)
        offsets = np.sum(normals * corners[:-1], axis=1) - margin
        return cls(
            foot_pose.parameters[None], np.array([share]), normals[None], offsets[None],
            np.array([loaded]), others,
        )  # fmt: skip

    @classmethod
    def row(cls, scenes: Sequence[Scene]) -> Scene:
        """Scenes of one state each, one after another; the first one's other joints."""
        if len(scenes) == 1:
            return scenes[0]
        edges = max(scene.offsets.shape[1] for scene in scenes)
        padded = [scene.padded(edges) for scene in scenes]
        return cls(
            np.concatenate([scene.foot_poses for scene in padded]),
            np.concatenate([scene.shares for scene in padded]),
            np.concatenate([scene.normals for scene in padded]),
            np.concatenate([scene.offsets for scene in padded]),
            np.concatenate([scene.loaded for scene in padded]),
            padded[0].others,
        )

    def padded(self, edges: int) -> Scene:
        """With as many edges, those that are missing as 0 * c <= infinity."""
        count, present = self.offsets.shape
        if present == edges:
            return self
        normals, offsets = np.zeros((count, edges, 2)), np.full((count, edges), np.inf)
        normals[:, :present], offsets[:, :present] = self.normals, self.offsets
        return dataclasses.replace(self, normals=normals, offsets=offsets)

    @property
    def first(self) -> Scene:
        """Of the first state."""
        return self.head(1)

    def head(self, count: int) -> Scene:
        """Of the first states; also where all keep the same."""
        return dataclasses.replace(
            self,
            foot_poses=self.foot_poses[:count],
            shares=self.shares[:count],
            normals=self.normals[:count],
            offsets=self.offsets[:count],
            loaded=self.loaded[:count],
        )

    def beyond(self, cop: FloatArray) -> FloatArray:
        """(n, h) how far CoPs (n, 2) are beyond lines through the origin along each edge [m]."""
        outside: FloatArray = (self.normals @ cop[..., None])[..., 0]
        return outside


@dataclass(frozen=True)
class Aim:
    """What the states of one optimisation pursue.

    Attributes:
        targets: (n, 5) CoP in the left sole's frame [m], lean, and height of the base above the
            left sole [m]; n is 1 where all states pursue the same.
        weights: (5,) of their squared distances; zero for what is not pursued.
    """

    targets: FloatArray
    weights: FloatArray

    @classmethod
    def at(cls, cop: FloatArray, settings: PlannerSettings) -> Aim:
        """A place (2,) for the CoP [m] (the paper's c_ref), and nothing else."""
        return cls(np.array([[*cop, 0.0, 0.0, 0.0]]), settings.cop_weights)


@dataclass(frozen=True)
class HorizonProblem:
    """One optimisation.

    Attributes:
        start: (k,) q[0], leg angles now [rad].
        previous: (k,) u[-1], the transition that led there [rad].
        aim: what q[1] to q[N] pursue.
        scene: what they have to keep.
    """

    start: FloatArray
    previous: FloatArray
    aim: Aim
    scene: Scene


@dataclass(frozen=True)
class Limits:
    """Bounds of every state of a horizon; a start outside of them is led back step by step.

    Attributes:
        lower, upper: (N, k) of the leg angles [rad].
        offsets: (N, h) of the half planes [m].
        clearances: (N, p) of the capsule pairs' distances [m].
        balance: (N, 13) least, of what LegExpressions.balance lists.
        transition: (k,) of |u| [rad].
        torque: (k,) of the motors [N m].
    """

    lower: FloatArray
    upper: FloatArray
    offsets: FloatArray
    clearances: FloatArray
    balance: FloatArray
    transition: FloatArray
    torque: FloatArray


@dataclass(frozen=True)
class StateValues:
    """What the constraints say of n states.

    Attributes:
        tasks: (n, 5) CoP [m], lean, height [m], as in Aim.
        foot_error: (n, 6) way [m] and turn [rad] from T0.
        distances: (n, p) of the capsule pairs [m].
        balance: (n, 13) as LegExpressions.balance.
        torques: (n, k) of the motors [N m].
    """

    tasks: FloatArray
    foot_error: FloatArray
    distances: FloatArray
    balance: FloatArray
    torques: FloatArray

    @classmethod
    def of_rows(cls, rows: FloatArray, motors: int) -> StateValues:
        """From (n, r) all of them side by side, torques of k motors last."""
        ends = np.cumsum([TASKS, FOOT_ROWS, rows.shape[1] - TASKS - FOOT_ROWS - BALANCE - motors])
        return cls(*np.split(rows, [*ends, rows.shape[1] - motors], axis=1))

    @property
    def cop(self) -> FloatArray:
        """(n, 2) left sole's frame [m]."""
        return self.tasks[:, :2]


@dataclass(frozen=True)
class HorizonSolution:
    """What a solver found, certified.

    Attributes:
        states: (N, k) leg angles q[1] to q[N] [rad].
        cost: of the states.
        violation: largest violation of any constraint by any state, or by those that are applied
            where the mode is not `converged` [m, rad or N m].
        converged: the solver's own word, and the violation within tolerance.
        status: of the solver, for people.
        iterations: that it took.
    """

    states: FloatArray
    cost: float
    violation: float
    converged: bool
    status: str
    iterations: int


class Solver(Protocol):
    """Solves one horizon's problem after another."""

    def solve(self, problem: HorizonProblem, guess: FloatArray) -> HorizonSolution:
        """Find states (N, k) from a guess of them (N, k) [rad]."""
        ...
