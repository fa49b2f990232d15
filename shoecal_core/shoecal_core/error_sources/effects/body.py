"""Effects of the body: masses and joints that differ from the model's."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from shoecal_core.arrays import FloatArray
from shoecal_core.error_sources.base import ALL, Component, Place, Shape
from shoecal_core.error_sources.body import driven_together
from shoecal_core.error_sources.effects import places
from shoecal_core.error_sources.signal_model import SignalModel
from shoecal_core.samples.known_weight import carried
from shoecal_core.samples.samples import Samples


class Inertia:
    """The CoP is the zero-moment point, which accelerations move off the CoM's projection."""

    identifier, group = "inertia", "dynamics"
    components = (Component("factor", "", 1.0, 0.0),)

    def places(self, signal_model: SignalModel) -> Iterator[Place]:
        """The whole body."""
        yield ()

    def shapes(self, signal_model: SignalModel, place: Place) -> Iterator[Shape]:
        """Of the whole body: -h a / g of its CoM, and what its angular momentum adds."""
        # In slow motions it is taken for granted, whatever else is looked for.
        if signal_model.fast:
            yield Shape(("factor",), signal_model.dynamic[None])


GIVES = 2
"""Ways in which a joint gives: as soles on the floor let it, and freely."""
LEAST_MASS = 0.01
"""Links lighter than this share of the robot are not looked at."""
FRICTION = (0.05, 0.2)
"""N m; a torque smaller than this does not say on which side of its play a joint lies."""


def _heavy(signal_model: SignalModel) -> Iterator[Place]:
    links = signal_model.links
    for name, mass in zip(links.names, links.mass, strict=True):
        if mass >= LEAST_MASS * signal_model.samples.robot.mass:
            yield (name,)


class TotalMass:
    """The whole robot is heavier or lighter than its files say, in proportion in all links.

    A common gain of all cells that is off looks exactly alike, but where something ties gains.
    """

    identifier, group = "total_mass", "body"
    components = (Component("mass", "kg", 0.15),)

    def places(self, signal_model: SignalModel) -> Iterator[Place]:
        """The whole body."""
        yield (ALL,)

    def shapes(self, signal_model: SignalModel, place: Place) -> Iterator[Shape]:
        """More force at the same CoP.

        That a known weight then moves the CoP less is left out: 0.03 mm for 0.15 kg on a NAO.
        """
        samples = signal_model.samples
        if _gains_tied(samples):
            # Of a robot that walks, the force is that of its acceleration too.
            force = samples.force / (samples.robot.mass + _known_mass(samples))
            column = signal_model.by_model(force, np.zeros((len(force), 2))) * _shown(signal_model)
            yield Shape(("mass",), column[None])


def _known_mass(samples: Samples) -> FloatArray:
    """(T,) on the robot in addition to its own [kg]."""
    found = np.zeros(len(samples.run))
    for track in samples.tracks:
        found[track.samples] = carried(track.motion)
    return found


def _gains_tied(samples: Samples) -> bool:
    """Whether a data sheet, or runs with and without a known weight, separate gains from mass."""
    shoe = samples.shoe
    sheet = any(shoe.channels[i].nominal_gain is not None for i in places.vertical(shoe))
    return sheet or bool(np.ptp(_known_mass(samples)) > 0.0)


class Payload:
    """A mass on a link that the model does not know."""

    identifier, group = "payload", "body"
    components = (Component("mass", "kg", 0.15, 0.0),)

    def places(self, signal_model: SignalModel) -> Iterator[Place]:
        """Every link that weighs something."""
        return _heavy(signal_model)

    def shapes(self, signal_model: SignalModel, place: Place) -> Iterator[Shape]:
        """More force, and a CoM that leans towards it."""
        links, samples = signal_model.links, signal_model.samples
        at = links.com[:, links.names.index(place[0]), :2]
        com = samples.states.com[np.arange(len(at)), samples.frame, :2]
        cop = (at - com) / samples.robot.mass
        force = samples.force / samples.robot.mass
        yield Shape(("mass",), signal_model.by_model(force, cop)[None] * _shown(signal_model))


class LinkCom:
    """A link's centre of mass lies elsewhere."""

    identifier, group = "link_com", "body"
    components = tuple(Component(name, "m", 0.008, as_built="link_com_m") for name in "xyz")

    def places(self, signal_model: SignalModel) -> Iterator[Place]:
        """Every link that weighs something."""
        return _heavy(signal_model)

    def shapes(self, signal_model: SignalModel, place: Place) -> Iterator[Shape]:
        """The CoM moves by the link's share of the mass."""
        links = signal_model.links
        index = links.names.index(place[0])
        share = links.mass[index] / signal_model.samples.robot.mass
        columns = np.array(
            [
                signal_model.by_model(0.0, share * links.rotation[:, index, :2, axis])
                * _shown(signal_model)
                for axis in range(3)
            ]
        )
        yield Shape(("x", "y", "z"), columns)


def _shown(signal_model: SignalModel) -> FloatArray:
    return signal_model.mask.astype(np.float64)


class JointOffset:
    """An encoder's zero is off."""

    identifier, group = "joint_offset", "body"
    components = (Component("angle", "rad", 0.015, as_built="joint_zero_rad"),)

    def places(self, signal_model: SignalModel) -> Iterator[Place]:
        """Every encoder of the legs."""
        robot = signal_model.samples.robot
        following = {one.joint for one in robot.shared}
        for place in places.each_joint(signal_model):
            if robot.joint(place[0]) not in following:
                yield place

    def shapes(self, signal_model: SignalModel, place: Place) -> Iterator[Shape]:
        """The same everywhere, in all joints of one motor."""
        change = np.zeros_like(signal_model.samples.angles)
        for joint, ratio in driven_together(
            signal_model.samples.robot, places.joints_at(signal_model, place)[0]
        ):
            change[:, joint] = ratio
        yield Shape(("angle",), signal_model.by_angles(change)[None])


class _Give:
    """What lies between an encoder and its link, and gives with the torque."""

    components: tuple[Component, ...]

    def angles(self, signal_model: SignalModel, place: Place) -> Iterator[FloatArray]:
        """(T, m) that encoders show more than the links' angles a unit [rad], in each form."""
        raise NotImplementedError

    def shapes(self, signal_model: SignalModel, place: Place) -> Iterator[Shape]:
        """Its forms, the ones that are likelier first."""
        for change in self.angles(signal_model, place):
            yield Shape((self.components[0].name,), signal_model.by_angles(change)[None])

    def places(self, signal_model: SignalModel) -> Iterator[Place]:
        """Every joint of the legs, and all alike."""
        return places.joints_and_all(signal_model)

    def _at(self, signal_model: SignalModel, place: Place, given: FloatArray) -> FloatArray:
        change = np.zeros_like(signal_model.samples.angles)
        joints = places.joints_at(signal_model, place)
        change[:, joints] = given[:, joints]
        return change


class JointCompliance(_Give):
    """A joint gives under its torque, behind the encoder."""

    identifier, group = "joint_compliance", "body"
    components = (
        Component(
            "compliance", "rad/(N m)", 0.008, 0.0, form=3.0, as_built="gear_compliance_rad_per_nm"
        ),
    )

    def angles(self, signal_model: SignalModel, place: Place) -> Iterator[FloatArray]:
        """(T, m) in proportion to the torque that it holds: with the soles held, or alone."""
        given = self._at(signal_model, place, signal_model.torque)
        yield signal_model.held(given)
        yield given


class Backlash(_Give):
    """A joint has play behind the encoder: it lies on the side to which it is pushed."""

    identifier, group = "backlash", "body"
    components = (Component("play", "rad", 0.015, 0.0, form=7.0, as_built="gear_play_rad"),)

    def angles(self, signal_model: SignalModel, place: Place) -> Iterator[FloatArray]:
        """(T, m) by the side to which the torque pushes, at once or over a while, with the soles
        held or alone; or by the one to which friction drags.
        """
        torque = signal_model.torque
        pushed = [
            self._at(signal_model, place, 0.5 * np.tanh(torque / friction)) for friction in FRICTION
        ]
        for side in pushed:
            yield signal_model.held(side)
        yield from pushed
        yield signal_model.held(self._at(signal_model, place, signal_model.samples.dragged))


class JointFriction(_Give):
    """A joint's friction, on the links' side of what gives, lets the link lag behind its encoder.

    By how much follows from torques that two feet on the floor leave open; the sign from the way
    that the joint came, standing still too. No cause: what has play or friction beyond tolerance
    is a `Backlash`.
    """

    identifier, group = "joint_friction", "body"
    components = (Component("lag", "rad", 0.015, 0.0, as_built="gear_friction_rad"),)

    def angles(self, signal_model: SignalModel, place: Place) -> Iterator[FloatArray]:
        """(T, m) from one side to the other by the way that it came."""
        yield signal_model.held(self._at(signal_model, place, signal_model.samples.dragged))
