"""A URDF as a draft looks at it: its model in the zero pose."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pinocchio as pin

from shoecal_core.arrays import FloatArray
from shoecal_core.robot.joint_centres import axis_of, centres_of, own_joints
from shoecal_core.robot.link_shapes import Description
from shoecal_core.robot.urdf import Mimic, UrdfError, read_urdf


@dataclass(frozen=True)
class Body(Description):
    """A robot in its zero pose, or the one that it is drafted in instead; base at the origin.

    Attributes:
        mimics: joints that another one's motor turns.
        locked: joints that the file fixes by equal limits.
        start: angles of the joints of the model that it is in [rad].
        placements: of every joint of the model, in the base.
        centres: (3,) of every joint on its axis, wherever along it the file puts the joint's
            frame, in the base [m].
    """

    mimics: Mapping[str, Mimic]
    locked: tuple[str, ...]
    start: FloatArray
    placements: tuple[pin.SE3, ...]
    centres: tuple[FloatArray, ...]

    def axis(self, joint: int) -> FloatArray:
        """(3,) unit axis about which it turns, in the base."""
        return axis_of(self.model, self.placements, joint)

    def link(self, joint: int) -> tuple[str, pin.SE3]:
        """The link that a joint turns, and its frame in the joint's frame.

        Raises:
            UrdfError: for a joint without a link.
        """
        for frame in self.model.frames:
            if frame.type == pin.FrameType.BODY and frame.parentJoint == joint:
                return str(frame.name), pin.SE3(frame.placement)
        raise UrdfError(self.urdf, "carries no link", field=f"joint {self.model.names[joint]}")

    def range(self, joint: int) -> tuple[float, float]:
        """Lower and upper limit of a joint [rad]."""
        place = self.model.joints[joint].idx_q
        return float(self.model.lowerPositionLimit[place]), float(
            self.model.upperPositionLimit[place]
        )


def read_body(
    urdf: Path, meshes: Path | None = None, start: Mapping[str, float] | None = None
) -> Body:
    """Read a URDF.

    Args:
        urdf: the file.
        meshes: folder in which its meshes are; None: where the file says, or near it.
        start: angles by joint [rad] of a posture in which it stands; None: zero.

    Raises:
        FileError: for one that is not understood whole: no masses, no limits, broken joints.
    """
    description = read_urdf(urdf)
    model, angles = description.model, np.zeros(description.model.njoints)
    q = pin.neutral(model)
    for joint in own_joints(model):
        angles[joint] = (start or {}).get(str(model.names[joint]), 0.0)
        q[model.joints[joint].idx_q] = angles[joint]
    data = model.createData()
    pin.forwardKinematics(model, data, q)
    # read_urdf has refused document types, so no entity can unfold here.
    root = ElementTree.parse(urdf).getroot()  # noqa: S314
    placements = tuple(pin.SE3(placement) for placement in data.oMi)
    return Body(
        urdf, root, model, meshes, description.mimics, description.locked, angles, placements,
        centres_of(model, placements),
    )  # fmt: skip
