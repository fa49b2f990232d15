"""Chains of links that a description closes, and which joints hold them.

A URDF is a tree. A `<loop_joint>` between two links closes a chain in it, as `<connect>` and
`<weld>` of an MJCF become.
"""

from __future__ import annotations

from dataclasses import dataclass
from xml.etree import ElementTree

import pinocchio as pin

from shoecal_core.drafting.body import Body
from shoecal_core.drafting.legs import LegChains
from shoecal_core.robot.joint_centres import own_joints
from shoecal_core.robot.urdf import UrdfError

LOOP = "loop_joint"
"""Element of a URDF that closes a chain."""


@dataclass(frozen=True)
class ClosedChain:
    """A chain of links that is closed.

    Attributes:
        name: of what closes it.
        joints: of the model, that turn within it.
    """

    name: str
    joints: frozenset[int]


def find_closed_chains(body: Body) -> list[ClosedChain]:
    """Chains with joints in them, in the order of the file.

    Raises:
        UrdfError: for one that is closed at a link that is not there.
    """
    found = []
    for loop in body.root.iter(LOOP):
        name = loop.get("name", "")
        one, other = (_joints_to(body, name, _link(loop, tag)) for tag in ("link1", "link2"))
        if one ^ other:
            found.append(ClosedChain(name, one ^ other))
    return found


def held_joints(body: Body, legs: LegChains) -> tuple[str, ...]:
    """Names of joints that closed chains hold, each of which a driver need not report.

    Raises:
        UrdfError: for chains that go through a leg, whose joints planning turns one by one.
    """
    names, in_legs = body.model.names, {joint for chain in legs.chains for joint in chain}
    chains = find_closed_chains(body)
    across = [one for one in chains if one.joints & in_legs]
    held = frozenset[int]().union(*(one.joints for one in across or chains))
    if across:
        turned = ", ".join(str(names[joint]) for joint in sorted(held & in_legs))
        loops = ", ".join(one.name for one in across)
        raise UrdfError(
            body.urdf,
            f"closed chains ({loops}) go through them, whose passive joints are not measured; "
            "take the linkage out and put the motor where it drives the leg",
            field=f"legs: joints {turned}",
        )
    return tuple(str(names[joint]) for joint in sorted(held))


def _link(loop: ElementTree.Element, tag: str) -> str:
    end = loop.find(tag)
    return "" if end is None else str(end.get("link", ""))


def _joints_to(body: Body, loop: str, link: str) -> frozenset[int]:
    """Joints from the base to a link."""
    model = body.model
    if not model.existFrame(link, pin.FrameType.BODY):
        raise UrdfError(
            body.urdf, f"no link has the name '{link}'; correct it", field=f"{LOOP} {loop}"
        )
    joint = model.frames[model.getFrameId(link, pin.FrameType.BODY)].parentJoint
    return frozenset(set(model.supports[joint]) & set(own_joints(model)))
