"""Effects outside the library, as physics of their own. None is an effect of the table.

A kind acts on the robot while it moves (`act`), or changes what its channels show (`forces`).
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field

import mujoco
import numpy as np

from shoecal_core.arrays import FloatArray
from shoecal_core.robot.gravity import GRAVITY
from shoecal_core.robot.robot import Robot
from shoecal_core.shoe.shoe import FEET
from shoecal_core.simulation.disturbances import Disturbance, MovingRobot
from shoecal_core.simulation.effects.effect import Effect
from shoecal_core.simulation.robot import SimulatedRobot
from shoecal_core.simulation.samples import SimulatedSamples
from shoecal_core.simulation.shoe_physics import sole_name


class Unknown(Effect):
    """Something that no library knows; without more it changes nothing."""

    def disturbances(self) -> Sequence[Disturbance]:
        """Itself acts while the robot moves."""
        return (self,)

    def act(self, sim: MovingRobot, time: float) -> None:
        """Act from the moment the recording begins, not while the robot is put down."""
        if time >= 0.0:
            self.push(sim, time)

    def push(self, sim: MovingRobot, time: float) -> None:
        """Add forces that are due at a time since the recording began [s]."""

    def forces(
        self, sim: SimulatedRobot, samples: SimulatedSamples, forces: FloatArray
    ) -> FloatArray:
        """(T, n) what the channels tell, of what they felt [N]."""
        return forces


@dataclass
class Cable(Unknown):
    """A cable from a link to a point of the room pulls like a soft spring.

    Attributes:
        size: stiffness [N/m].
        link: that it hangs on.
        reach: (3,) from the link, at rest, to the point of the room [m].
    """

    size: float
    link: str
    reach: FloatArray
    _point: FloatArray | None = field(default=None, init=False)

    @classmethod
    def drawn(cls, size: float, rng: np.random.Generator) -> Cable:
        """Which link, and where to."""
        way = rng.uniform(0.0, 2.0 * np.pi)
        reach = np.array([0.15 * np.cos(way), 0.15 * np.sin(way), rng.uniform(-0.05, 0.1)])
        return cls(size, str(rng.choice(["base_link", "l_wrist_link", "r_wrist_link"])), reach)

    def push(self, sim: MovingRobot, time: float) -> None:
        """Pull."""
        place = _place(sim, self.link)
        if self._point is None or time == 0.0:
            self._point = place + self.reach
        _push(sim, self.link, self.size * (self._point - place))


@dataclass
class Table(Unknown):
    """A thigh rubs against the edge of something that stands beside it, and springs back.

    Attributes:
        size: stiffness [N/m].
        side: 1: the left thigh, -1: the right one.
        gap: from it, at rest [m].
        rubbing: friction.
    """

    size: float
    side: int
    gap: float
    rubbing: float = 0.6
    _start: FloatArray | None = field(default=None, init=False)
    _before: FloatArray | None = field(default=None, init=False)

    @classmethod
    def drawn(cls, size: float, rng: np.random.Generator) -> Table:
        """Which side."""
        return cls(size, int(rng.choice([-1, 1])), float(rng.uniform(0.0, 0.008)))

    def push(self, sim: MovingRobot, time: float) -> None:
        """Push back what comes too near, and rub."""
        link = "LThigh_link" if self.side > 0 else "RThigh_link"
        place = _place(sim, link)
        if self._start is None or time == 0.0:
            self._start = self._before = place
        deep = self.side * (place - self._start)[1] - self.gap
        assert self._before is not None
        way, self._before = place - self._before, place
        if deep <= 0.0:
            return
        pressed = self.size * deep
        rubbed = way[[0, 2]] / max(float(np.hypot(way[0], way[2])), 2e-5)
        force = np.array([0.0, -self.side * pressed, 0.0])
        force[[0, 2]] = -self.rubbing * pressed * rubbed
        _push(sim, link, force)


@dataclass
class Swing(Unknown):
    """Something of the robot's own weight swings on a thread.

    Attributes:
        size: mass [kg] times swing [rad].
        period: [s].
        way: direction of the swing [rad].
        fading: time in which it dies down [s].
    """

    size: float
    period: float
    way: float
    fading: float

    @classmethod
    def drawn(cls, size: float, rng: np.random.Generator) -> Swing:
        """How it swings."""
        return cls(
            size, float(rng.uniform(0.6, 1.4)), float(rng.uniform(0.0, 2.0 * np.pi)),
            float(rng.uniform(30.0, 120.0)),
        )  # fmt: skip

    def push(self, sim: MovingRobot, time: float) -> None:
        """Pull sideways, as a pendulum does on its thread."""
        turned = self.size * np.exp(-time / self.fading) * np.sin(2 * np.pi * time / self.period)
        force = GRAVITY * turned * np.array([np.cos(self.way), np.sin(self.way), 0.0])
        _push(sim, "base_link", force)


@dataclass
class PickUp(Unknown):
    """The motors' currents are heard in the cells' cables.

    Attributes:
        size: reading for all torques together [N/(N m)].
        foot: which shoe's cables.
        ear: (4,) how well each of its cells hears.
    """

    size: float
    foot: int
    ear: FloatArray

    @classmethod
    def drawn(cls, size: float, rng: np.random.Generator) -> PickUp:
        """Which shoe, and how its cells hear."""
        return cls(size, int(rng.integers(2)), rng.uniform(0.4, 1.6, 4) * rng.choice([-1, 1], 4))

    def forces(
        self, sim: SimulatedRobot, samples: SimulatedSamples, forces: FloatArray
    ) -> FloatArray:
        """With what is heard."""
        heard = np.abs(samples.joints.efforts).sum(axis=1)
        channels = sim.shoe.of_foot(self.foot)
        changed = forces.copy()
        changed[:, channels] += self.size * heard[:, None] * self.ear[: len(channels)]
        return changed


@dataclass
class Edge(Unknown):
    """The rim of a shoe's top plate touches the bottom one: some load goes past the cells there.

    Attributes:
        size: stiffness of the touching rim over that of a cell.
        foot: which shoe.
        place: (2,) where it touches, in the sole frame [m].
        gap: load of a cell at which the rim would touch, were it there [N].
    """

    size: float
    foot: int
    place: FloatArray
    gap: float

    @classmethod
    def drawn(cls, size: float, rng: np.random.Generator) -> Edge:
        """Which shoe, and where along its rim."""
        side, along = int(rng.choice([-1, 1])), rng.uniform(-0.03, 0.08)
        return cls(
            size,
            int(rng.integers(2)),
            np.array([along, side * 0.045]),
            float(rng.uniform(3.0, 7.0)),
        )

    def forces(
        self, sim: SimulatedRobot, samples: SimulatedSamples, forces: FloatArray
    ) -> FloatArray:
        """What is left to the cells."""
        channels = sim.shoe.of_foot(self.foot)
        changed = forces.copy()
        changed[:, channels] = self.past(forces[:, channels], sim.drawn.shoes.position[channels])
        return changed

    def past(self, forces: FloatArray, places: FloatArray) -> FloatArray:
        """(T, k) forces left on cells at places (k, 2), of (T, k) without the rim.

        Statics of a rigid plate on its cells and, where it comes down far enough, on the rim.
        """
        share = shares(places, self.place)
        carried = np.maximum(forces @ share - self.gap, 0.0) / (1.0 / self.size + share @ share)
        return forces - carried[:, None] * share


@dataclass
class LoosePlate(Unknown):
    """A plate slides to and fro in its screws' clearance as the shoe is loaded and let go.

    Attributes:
        size: half the clearance [m].
        foot: which shoe.
        way: direction in which it slides [rad].
        grip: change of the foot's load that moves it from end to end [N].
    """

    size: float
    foot: int
    way: float
    grip: float

    @classmethod
    def drawn(cls, size: float, rng: np.random.Generator) -> LoosePlate:
        """Which shoe, and how it slides."""
        return cls(
            size, int(rng.integers(2)), float(rng.uniform(0, 2 * np.pi)), float(rng.uniform(4, 10))
        )

    def forces(
        self, sim: SimulatedRobot, samples: SimulatedSamples, forces: FloatArray
    ) -> FloatArray:
        """The foot's load, from where the plate lies to the cells."""
        channels = sim.shoe.of_foot(self.foot)
        changed = forces.copy()
        changed[:, channels] = self.slid(forces[:, channels], sim.drawn.shoes.position[channels])
        return changed

    def slid(self, forces: FloatArray, places: FloatArray) -> FloatArray:
        """(T, k) forces on cells at places (k, 2), of (T, k) on a plate that lies fast."""
        total = forces.sum(axis=1)
        lies = np.zeros(len(total))
        middle = total[0]
        for index, load in enumerate(total):
            middle = float(np.clip(middle, load - self.grip / 2.0, load + self.grip / 2.0))
            lies[index] = (load - middle) / (self.grip / 2.0)
        moved = self.size * lies[:, None] * [np.cos(self.way), np.sin(self.way)]
        here = shares(places, np.zeros(2))
        lever = np.stack([shares(places, axis) - here for axis in np.eye(2)], axis=1)
        return np.asarray(forces + total[:, None] * (moved @ lever.T))


@dataclass
class Hand(Unknown):
    """Somebody steadies the robot with a hand now and then: it holds up a part of the weight.

    Attributes:
        size: largest force [N].
        starts, lengths: of each touch [s].
        lean: sideways part of it.
    """

    size: float
    starts: FloatArray
    lengths: FloatArray
    lean: FloatArray

    @classmethod
    def drawn(cls, size: float, rng: np.random.Generator) -> Hand:
        """When it touches."""
        starts = np.cumsum(rng.uniform(4.0, 10.0, 8))
        return cls(size, starts, rng.uniform(2.0, 6.0, 8), rng.uniform(-0.4, 0.4, 2))

    def push(self, sim: MovingRobot, time: float) -> None:
        """Hold up a part of the weight."""
        _push(sim, "base_link", self.size * self.much(time) * np.array([*self.lean, 1.0]))

    def much(self, time: float) -> float:
        """Share of the largest force at a time [s]: it touches gently, holds, lets go."""
        phase = (time - self.starts) / self.lengths
        return float(np.where((phase > 0) & (phase < 1), np.sin(np.pi * phase) ** 2, 0.0).max())


@dataclass
class Pebble(Unknown):
    """A pebble sticks under a shoe, which rocks on it and on two of its corners.

    Attributes:
        size: height [m].
        foot: which shoe.
        place: (2,) in the sole frame [m].
    """

    size: float
    foot: int
    place: FloatArray

    @classmethod
    def drawn(cls, size: float, rng: np.random.Generator) -> Pebble:
        """Under which shoe, and where."""
        place = np.array([rng.uniform(-0.03, 0.08), rng.uniform(-0.03, 0.03)])
        return cls(size, int(rng.integers(2)), place)

    def on_spec(self, spec: mujoco.MjSpec, robot: Robot) -> None:
        """One more ball at the sole, lower than those at its corners and as hard."""
        sole = spec.body(sole_name(self.foot))
        corner = sole.first_geom()
        radius = float(corner.size[0])
        sole.add_geom(
            name=f"{FEET[self.foot]}_pebble",
            type=mujoco.mjtGeom.mjGEOM_SPHERE,
            size=[radius, 0.0, 0.0],
            pos=[*self.place, radius - self.size],
            mass=0.0,
            contype=corner.contype,
            conaffinity=corner.conaffinity,
            friction=corner.friction,
            solref=corner.solref,
        )


KINDS: Mapping[str, Callable[[float, np.random.Generator], Unknown]] = {
    "cable": Cable.drawn,
    "rubbing thigh": Table.drawn,
    "swinging load": Swing.drawn,
    "motor pick-up": PickUp.drawn,
    "touching edge": Edge.drawn,
    "loose plate": LoosePlate.drawn,
    "steadying hand": Hand.drawn,
    "pebble": Pebble.drawn,
}
"""Kinds by name: from size and chance."""


def _place(sim: MovingRobot, link: str) -> FloatArray:
    place: FloatArray = sim.data.xpos[sim.physics.model.body(link).id].copy()
    return place


def _push(sim: MovingRobot, link: str, force: FloatArray) -> None:
    sim.data.xfrc_applied[sim.physics.model.body(link).id, :3] += force


def shares(places: FloatArray, point: FloatArray) -> FloatArray:
    """(k,) how a rigid plate on equal springs at places (k, 2) shares a unit load at a point."""
    rows = np.column_stack([np.ones(len(places)), places])
    return np.asarray(rows @ np.linalg.solve(rows.T @ rows, [1.0, *point]))
