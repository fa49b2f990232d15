"""What the files of robot and shoes may be wrong by, and what that adds to the residuals.

Such an error is the same in all runs: no residual averages it out, and much of it hides in the
fitted gains and offsets. It is therefore carried through the fit as a stated tolerance (a consider
parameter: Bierman, Factorization Methods for Discrete Sequential Estimation, 1977, ch. VIII).
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from shoecal_core.model.double_support import DoubleSupport
from shoecal_core.model.robot import GRAVITY, Robot
from shoecal_core.model.sensitivity import SensitiveBody
from shoecal_core.samples.stance import Stance
from shoecal_core.sensing.shoe import FEET, Shoe
from shoecal_core.sensing.wrench import ChannelParameters, cop, foot_wrenches
from shoecal_core.settings import Settings, setting

FloatArray = NDArray[np.float64]
AXES = ("x", "y", "z")
WEIGHT = "weight"
SAG, PLATES = "sag", "plates"
ANY_FORCE = 1e-3
"""N; a foot that carries less shifts no CoP."""


@dataclass(frozen=True)
class Tolerances(Settings):
    """Standard deviations of what the files of robot and shoes say."""

    link_mass: float = setting(
        0.03, "", "each link's mass, as a share of it; the total is weighed", minimum=0.0
    )
    link_com_m: float = setting(0.005, "m", "each link's centre of mass, each axis", minimum=0.0)
    joint_zero_rad: float = setting(
        0.004, "rad", "zero of each leg joint's encoder, its play included", minimum=0.0
    )
    sag: float = setting(
        0.03,
        "",
        "share by which the CoM leans out further than the joints tell: their gears give",
        minimum=0.0,
    )
    cell_position_m: float = setting(0.0015, "m", "where each channel acts, each axis", minimum=0.0)
    plate_share: float = setting(
        0.05, "", "part of a foot's moment that its plates carry past the cells", minimum=0.0
    )


@dataclass(frozen=True)
class Effects:
    """What each of q causes, one standard deviation long, adds to measured minus modelled.

    Attributes:
        causes: for example `zero of LAnkleRoll` or `place of left/front_left along x`.
        one_sided: (q,) True where only one sign exists: gears and plates always yield to the load.
        force: (T, q) to the GRF [N].
        cop: (T, 2, q) to the CoP of what carries, in the stance's frame [m].
        foot_cop: (T, 2, 2, q) to the CoP of each foot in its own sole's frame: those of its
            shoe alone [m].
        placing: (3, q) by how much dx, dy, dtheta of the right sole are truly more than told, on
            average [m, m, rad].
    """

    causes: tuple[str, ...]
    one_sided: NDArray[np.bool_]
    force: FloatArray
    cop: FloatArray
    foot_cop: FloatArray
    placing: FloatArray


class ModelTolerances:
    """The tolerances of one robot in one pair of shoes, ready to be put to use."""

    def __init__(self, robot: Robot, shoe: Shoe, tolerances: Tolerances) -> None:
        self.robot, self.shoe, self.tolerances = robot, shoe, tolerances
        self._body = SensitiveBody(robot)
        nothing = np.zeros((1, len(shoe.names)))
        self._of_shoes = tuple(name for name, *_ in self._shoe_causes(nothing))

    @cached_property
    def causes(self) -> tuple[str, ...]:
        """Names of all causes: the weight, what is of the body, what is of the shoes."""
        return (WEIGHT, *self._body_names, *self._of_shoes)

    def effects(self, stance: Stance, parameters: ChannelParameters) -> Effects:
        """On measured minus modelled, at the samples of a stance, in its frame.

        Everything here changes slowly, so few samples will do.

        Args:
            stance: with its joint angles.
            parameters: gains and offsets; they tell how the feet share the weight.
        """
        outputs = parameters.outputs(stance.readings)
        shifts, placing = self._body_effects(stance)
        measured = self.measured_effects(outputs, stance.support, placing)
        first = 1 + len(self._body_names)
        # A single foot is all that carries: nothing is misplaced, and its own shoe alone errs.
        foot = None if stance.hanging is None else 1 - stance.hanging
        shown = measured.cop.copy() if foot is None else measured.foot_cop[:, foot].copy()
        shown[:, :, 1:first] += shifts
        return replace(measured, cop=shown)

    def measured_effects(
        self, outputs: FloatArray, support: DoubleSupport, placing: FloatArray
    ) -> Effects:
        """On measured minus true, in load cases.

        Args:
            outputs: (T, n) of all channels [N or N m].
            support: where the right foot stands.
            placing: (3, q) as in `Effects`.
        """
        causes, count, first = self.causes, len(outputs), 1 + len(self._body_names)
        force, feet = np.zeros((count, len(causes))), np.zeros((count, 2, 2, len(causes)))
        force[:, 0] = self.robot.mass_std * GRAVITY
        both = -self._misplaced(outputs, support, placing)
        for index, (_, foot, shift, share) in enumerate(self._shoe_causes(outputs), start=first):
            turned = shift if foot == 0 else shift @ support.rotation.T
            both[..., index] += share[:, None] * turned
            feet[:, foot, :, index] = shift
        one_sided = np.array([cause.startswith((SAG, PLATES)) for cause in causes])
        return Effects(causes, one_sided, force, both, feet, placing)

    def _misplaced(
        self, outputs: FloatArray, support: DoubleSupport, placing: FloatArray
    ) -> FloatArray:
        """(T, 2, q) by which the CoP of both feet truly moves with the right foot's place."""
        wrenches = foot_wrenches(self.shoe, outputs)
        share = wrenches[:, 1, 0] / np.maximum(wrenches[:, :, 0].sum(axis=1), ANY_FORCE)
        right = np.nan_to_num(cop(wrenches[:, 1], ANY_FORCE)) @ support.rotation.T
        turned = np.stack((-right[:, 1], right[:, 0]), axis=1)
        moved = placing[None, :2] + turned[:, :, None] * placing[None, 2:]
        shifted: FloatArray = share[:, None, None] * moved
        return shifted

    @cached_property
    def _body_names(self) -> tuple[str, ...]:
        links = [
            name
            for link in self._body.links
            for name in (f"mass of {link}", *(f"CoM of {link} along {axis}" for axis in AXES))
        ]
        return (
            *links,
            *(f"zero of {joint}" for joint in self.robot.leg_names),
            f"{SAG} along x",
            f"{SAG} along y",
        )

    def _body_effects(self, stance: Stance) -> tuple[FloatArray, FloatArray]:
        """(T, 2, b) of the body's b causes on the true CoP against the modelled one, and the
        placing (3, q) of all causes.
        """
        assert stance.angles is not None
        own, body = self.tolerances, self._body.at(stance.angles, stance.loaded.index(True))
        count, links = len(stance.time), len(body.links)
        by_mass = own.link_mass * body.cop_by_mass[..., None]
        by_com = own.link_com_m * body.cop_by_com
        by_link = np.concatenate((by_mass, by_com), axis=3).reshape(count, 2, 4 * links)
        by_zero = own.joint_zero_rad * self._by_motor(body.cop_by_joint)
        lean = stance.cop - self._middle(stance)
        by_sag = own.sag * lean[:, :, None] * np.eye(2)
        placed = own.joint_zero_rad * self._by_motor(body.support_by_joint).mean(axis=0)
        placed = np.hstack((placed, np.zeros((3, 2))))
        after = len(self._of_shoes)
        placing = np.hstack((np.zeros((3, 1 + 4 * links)), placed, np.zeros((3, after))))
        return np.concatenate((by_link, by_zero, by_sag), axis=2), placing

    def _middle(self, stance: Stance) -> FloatArray:
        """(2,) between the middles of the sensing polygons that carry, in the stance's frame."""
        left, right = (foot.sensing_polygon.mean(axis=0) for foot in self.robot.feet)
        if stance.hanging is not None:
            return np.asarray((right, left)[stance.hanging])
        middle: FloatArray = 0.5 * (left + stance.support.right_to_left(right))
        return middle

    def _by_motor(self, by_joint: FloatArray) -> FloatArray:
        """Derivatives (..., k) to the angles of the leg motors, of ones (..., m) to the joints'."""
        joints = by_joint.copy()
        for shared in self.robot.shared:
            joints[..., shared.leader] += shared.ratio * joints[..., shared.joint]
        motors: FloatArray = joints[..., self.robot.legs]
        return motors

    def _shoe_causes(
        self, outputs: FloatArray
    ) -> Iterator[tuple[str, int, FloatArray, FloatArray]]:
        """Name, foot, shift (T, 2) of its measured CoP in its frame, and its share (T,)."""
        own, shoe = self.tolerances, self.shoe
        wrenches = foot_wrenches(shoe, outputs)
        total = np.maximum(wrenches[:, :, 0].sum(axis=1), ANY_FORCE)
        for foot, side in enumerate(FEET):
            force = np.maximum(wrenches[:, foot, 0], ANY_FORCE)
            vertical = [i for i in shoe.of_foot(foot) if shoe.columns[i, 0] != 0.0]
            for index in vertical:
                carried = shoe.columns[index, 0] * outputs[:, index] / force
                for axis, name in enumerate(AXES[:2]):
                    shift = np.zeros((len(outputs), 2))
                    shift[:, axis] = -own.cell_position_m * carried
                    cause = f"place of {shoe.names[index]} along {name}"
                    yield cause, foot, shift, force / total
            if len(vertical) < 3:
                continue
            place = np.nan_to_num(cop(wrenches[:, foot], ANY_FORCE))
            lever = place - shoe.positions[vertical].mean(axis=0)
            for axis, name in enumerate(AXES[:2]):
                shift = np.zeros((len(outputs), 2))
                shift[:, axis] = -own.plate_share * lever[:, axis]
                yield f"{PLATES} of the {side} shoe along {name}", foot, shift, force / total
