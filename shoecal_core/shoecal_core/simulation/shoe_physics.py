"""One shoe as physics: a top plate on the foot, a bottom plate below, cells between.

The bottom plate can move up and down and tilt against the top plate; sideways and in yaw it is
rigid. Each cell is a spring at its place, a fixed tendon over those three motions, so that any
number of cells shares the load as statics and their stiffness demand. Clamps that carry moment
are springs of the tilts alone. A foot with a six-axis sensor has a rigid bottom plate.

Floor that gives is a pad below the bottom plate, on springs of its tilts and its sinking: what
touches the rigid floor is then the pad.
"""

from __future__ import annotations

from dataclasses import dataclass

import mujoco
import numpy as np

from shoecal_core.arrays import FloatArray
from shoecal_core.errors import ShoecalError
from shoecal_core.robot.gravity import GRAVITY
from shoecal_core.shoe.shoe import AXES, FEET, Shoe
from shoecal_core.simulation.reality import PlantVariation
from shoecal_core.simulation.sampled_parts import SampledShoes

_OURS = "shoe/"
"""Starts the names of bodies and joints, so that none is a name of the URDF."""
_TIP_RADIUS = 0.004
"""m; the bottom plate touches the floor with a small ball at each corner of its outline."""
_THICKNESS = 0.005
"""m; of a plate, for its inertia."""
_PAD_DAMPING_TIME = 0.01
"""s; damping of soft floor over its stiffness."""
_NET_FORCE = 3
"""MuJoCo's reduction of a contact sensor to one wrench in the world's frame."""
_FLOOR_BIT, _SOLE_BIT = 2, 1
"""Contact types: soles touch the floor and nothing else."""


def add_floor(spec: mujoco.MjSpec, rules: PlantVariation, shoes: SampledShoes) -> None:
    """Lay the floor, and set how the physics is computed.

    The floor is the plane z = 0 whatever its slope: gravity is turned instead.
    """
    option = spec.option
    option.timestep = rules.step_s
    engine = rules.engine
    option.integrator = getattr(mujoco.mjtIntegrator, f"mjINT_{engine.integrator.upper()}")
    option.cone = getattr(mujoco.mjtCone, f"mjCONE_{engine.cone.upper()}")
    option.impratio = engine.sideways_ratio
    option.disableflags |= int(mujoco.mjtDisableBit.mjDSBL_ISLAND)
    option.gravity = floor_rotation(shoes).T @ [0.0, 0.0, -GRAVITY]
    spec.worldbody.add_geom(
        name="floor",
        type=mujoco.mjtGeom.mjGEOM_PLANE,
        size=[2.0, 2.0, 0.1],
        contype=_FLOOR_BIT,
        conaffinity=_SOLE_BIT,
        **_contact(rules),
    )


def floor_rotation(shoes: SampledShoes) -> FloatArray:
    """(3, 3) turns vectors of the floor's frame into a level one."""
    about_x, about_y = shoes.tilt
    c, s = np.cos(about_x), np.sin(about_x)
    turn_x = np.array([[1.0, 0.0, 0.0], [0.0, c, -s], [0.0, s, c]])
    c, s = np.cos(about_y), np.sin(about_y)
    turn_y = np.array([[c, 0.0, s], [0.0, 1.0, 0.0], [-s, 0.0, c]])
    rotation: FloatArray = turn_y @ turn_x
    return rotation


@dataclass(frozen=True)
class ShoeBuilder:
    """Adds shoes to a world.

    Attributes:
        shoe: as its file says.
        rules, drawn: as it truly is.
    """

    shoe: Shoe
    rules: PlantVariation
    drawn: SampledShoes

    def add(
        self, spec: mujoco.MjSpec, ankle: mujoco.MjsBody, foot: int, sole: FloatArray,
        quaternion: FloatArray, outline: FloatArray,
    ) -> None:  # fmt: skip
        """Put one shoe on.

        Args:
            spec: the world.
            ankle: body that wears it.
            foot: 0 left, 1 right.
            sole: (3,) origin of the sole frame in the ankle's frame [m].
            quaternion: (4,) w, x, y, z of the sole frame in the ankle's.
            outline: (k, 2) corners of the bottom plate in the sole frame [m].
        """
        plates, side = self.shoe.plates[foot], FEET[foot]
        factor = self.drawn.mass_factor[foot]
        top = ankle.add_body(name=f"{_OURS}{side}_top_plate", pos=sole, quat=quaternion)
        _set_plate(top, plates.mass_above * factor, plates.com_above, outline)
        bottom = top.add_body(name=sole_name(foot))
        _set_plate(bottom, plates.mass_below * factor, plates.com_below, outline)
        ground = self._ground(bottom, foot, outline)
        for index, corner in enumerate(outline):
            ground.add_geom(
                name=f"{_tips(foot)}{index}",
                type=mujoco.mjtGeom.mjGEOM_SPHERE,
                size=[_TIP_RADIUS, 0.0, 0.0],
                pos=np.array([*corner, _TIP_RADIUS]) - ground.pos * (ground is not bottom),
                mass=0.0,
                contype=_SOLE_BIT,
                conaffinity=_FLOOR_BIT,
                **_contact(self.rules),
            )
        _add_contact_sensor(spec, foot, ground.name)
        if has_cells(self.shoe, foot):
            self._add_cells(spec, bottom, foot)
        else:
            self._add_sensor(spec, bottom, foot)

    def _ground(self, bottom: mujoco.MjsBody, foot: int, outline: FloatArray) -> mujoco.MjsBody:
        """What touches the floor: the bottom plate, or a pad that has half of its mass.

        The pad tilts about the middle of the outline, and sinks as a bed of springs would that
        gives as much.
        """
        compliance = self.drawn.ground_compliance[foot]
        if compliance <= 0.0:
            return bottom
        middle = (outline.min(axis=0) + outline.max(axis=0)) / 2.0
        place = np.array([*middle, 0.0])
        pad = bottom.add_body(name=f"{_OURS}{FEET[foot]}_ground", pos=place)
        # Contacts of bodies with hardly any mass would be soft; the foot gets no heavier by it.
        half, com = bottom.mass / 2.0, bottom.ipos.copy()
        _set_plate(bottom, half, com, outline)
        _set_plate(pad, half, com - place, outline)
        tilting = 1.0 / compliance
        sinking = tilting / ((outline - middle) ** 2).sum(axis=1).mean()
        hinge, slide = mujoco.mjtJoint.mjJNT_HINGE, mujoco.mjtJoint.mjJNT_SLIDE
        motions = (
            ("sink", slide, [0, 0, 1], 2.0 * sinking),
            ("tilt_x", hinge, [1, 0, 0], tilting),
            ("tilt_y", hinge, [0, 1, 0], tilting),
        )
        for name, kind, axis, stiffness in motions:
            pad.add_joint(
                name=f"{pad.name}_{name}",
                type=kind,
                axis=axis,
                stiffness=[stiffness, 0.0, 0.0],
                damping=[stiffness * _PAD_DAMPING_TIME, 0.0, 0.0],
            )
        return pad

    def _add_cells(self, spec: mujoco.MjSpec, bottom: mujoco.MjsBody, foot: int) -> None:
        cells, side = self.rules.cells, FEET[foot]
        stiffness = cells.stiffness_n_per_m
        channels = self.shoe.of_foot(foot)
        places = self.drawn.position[channels]
        share = self.drawn.clamp_share[foot]
        spread = ((places - places.mean(axis=0)) ** 2).sum(axis=0)
        about_y, about_x = stiffness * spread * share / (1.0 - share)
        anchor = [0.0, 0.0, cells.height_m]
        hinge, slide = mujoco.mjtJoint.mjJNT_HINGE, mujoco.mjtJoint.mjJNT_SLIDE
        motions = {
            f"{_OURS}{side}_lift": (slide, [0, 0, 1], 0.0),
            f"{_OURS}{side}_tilt_x": (hinge, [1, 0, 0], about_x),
            f"{_OURS}{side}_tilt_y": (hinge, [0, 1, 0], about_y),
        }
        for name, (kind, axis, clamp) in motions.items():
            bottom.add_joint(name=name, type=kind, axis=axis, pos=anchor, stiffness=[clamp, 0, 0])
        for channel, (x, y) in zip(channels, places, strict=True):
            # Its length: how far the bottom plate has come up at the cell's place.
            tendon = spec.add_tendon(
                name=self.shoe.names[channel],
                stiffness=[stiffness, 0.0, 0.0],
                damping=[stiffness * cells.damping_time_s, 0.0, 0.0],
                springlength=[0.0, 0.0],
            )
            for motion, lever in zip(motions, (1.0, y, -x), strict=True):
                tendon.wrap_joint(motion, lever)

    def _add_sensor(self, spec: mujoco.MjSpec, bottom: mujoco.MjsBody, foot: int) -> None:
        channels = self.shoe.of_foot(foot)
        place = self.drawn.position[channels].mean(axis=0)
        height = _sensor_height(self.shoe, foot, self.rules.cells.height_m)
        site = f"{FEET[foot]}_sensor"
        bottom.add_site(name=site, pos=[*place, height])
        for kind, name in (
            (mujoco.mjtSensor.mjSENS_FORCE, "force"),
            (mujoco.mjtSensor.mjSENS_TORQUE, "torque"),
        ):
            spec.add_sensor(
                name=f"{FEET[foot]}_{name}", type=kind, objtype=mujoco.mjtObj.mjOBJ_SITE,
                objname=site,
            )  # fmt: skip


class ChannelOutputs:
    """Reads what the channels of both feet feel."""

    def __init__(self, model: mujoco.MjModel, shoe: Shoe, feet: tuple[int, ...] = (0, 1)) -> None:
        self._outputs = np.zeros(len(shoe.channels))
        cells = [i for foot in feet if has_cells(shoe, foot) for i in shoe.of_foot(foot)]
        self._cells = np.array(cells, dtype=np.int64)
        self._tendons = np.array([model.tendon(shoe.names[i]).id for i in cells], dtype=np.int64)
        self._stiffness = model.tendon_stiffness[self._tendons]
        # An integrator that is implicit in stiffness balances springs as a step ends, with the
        # contacts of its start: read at the start, cells would be one step late.
        discrete = model.opt.integrator == mujoco.mjtIntegrator.mjINT_DISCRETE
        ahead = model.opt.timestep if discrete else 0.0
        self._damping = model.tendon_damping[self._tendons] + ahead * self._stiffness
        axes = [i for foot in feet if not has_cells(shoe, foot) for i in shoe.of_foot(foot)]
        self._axes = np.array(axes, dtype=np.int64)
        self._sensors = np.array(
            [_address(model, FEET[shoe.foot[i]], _axis(shoe, i)) for i in axes], dtype=np.int64
        )

    def __call__(self, data: mujoco.MjData) -> FloatArray:
        """(n,) outputs [N or N m], positive under load; zero for feet not looked at."""
        outputs = self._outputs.copy()
        outputs[self._cells] = (
            self._stiffness * data.ten_length[self._tendons]
            + self._damping * data.ten_velocity[self._tendons]
        )
        # MuJoCo gives the foot's force on the plate; channels count the plate's on the foot.
        outputs[self._axes] = -data.sensordata[self._sensors]
        return outputs


class SoleReader:
    """Reads the contacts below the soles, and where the soles are."""

    def __init__(self, model: mujoco.MjModel, feet: tuple[int, ...] = (0, 1)) -> None:
        self._bodies = np.array([model.body(sole_name(foot)).id for foot in feet])
        self._sensors = np.array([model.sensor(_contact_name(foot)).adr[0] for foot in feet])
        self._rows = self._sensors[:, None] + np.arange(9)

    def contact(self, data: mujoco.MjData) -> FloatArray:
        """(feet, 9) net force [N], torque [N m] and its place [m] over the floor."""
        wrench: FloatArray = data.sensordata[self._rows]
        return wrench

    def pose(self, data: mujoco.MjData) -> tuple[FloatArray, FloatArray]:
        """(feet, 3) positions [m] and (feet, 3, 3) rotations of the sole frames."""
        return data.xpos[self._bodies], data.xmat[self._bodies].reshape(-1, 3, 3)


def sole_name(foot: int) -> str:
    """Body of a shoe's bottom plate; its frame is the sole frame."""
    return f"{_OURS}{FEET[foot]}_sole"


def has_cells(shoe: Shoe, foot: int) -> bool:
    """Whether a foot has one-axis cells, else one six-axis sensor.

    Raises:
        ShoecalError: for a foot that has both.
    """
    channels = shoe.of_foot(foot)
    if np.all(shoe.columns[channels, 0] == 1.0):
        return True
    if not all(_axis(shoe, index) in AXES for index in channels):
        raise ShoecalError(
            f"{shoe.path}: feet.{FEET[foot]}: has cells and a six-axis sensor; the simulated shoe "
            "has one or the other"
        )
    return False


def _axis(shoe: Shoe, index: int) -> str:
    """Axis of a six-axis sensor that a channel reads."""
    return shoe.names[index].split("/")[1]


def _address(model: mujoco.MjModel, side: str, axis: str) -> int:
    """Where in the sensor data an axis such as `fx` or `my` stands."""
    kind = {"f": "force", "m": "torque"}[axis[0]]
    return int(model.sensor(f"{side}_{kind}").adr[0]) + "xyz".index(axis[1])


def _sensor_height(shoe: Shoe, foot: int, otherwise: float) -> float:
    """Height of a six-axis sensor, by the columns of its sideways forces [m]."""
    for index in shoe.of_foot(foot):
        if _axis(shoe, index) == "fx":
            return float(shoe.columns[index, 2])
        if _axis(shoe, index) == "fy":
            return float(-shoe.columns[index, 1])
    return otherwise


def _set_plate(body: mujoco.MjsBody, mass: float, com: FloatArray, outline: FloatArray) -> None:
    """A plate's mass, spread over its outline."""
    x, y = np.ptp(outline, axis=0)
    z = _THICKNESS
    body.mass = mass
    body.ipos = com
    body.inertia = mass / 12.0 * np.array([y * y + z * z, x * x + z * z, x * x + y * y])
    body.explicitinertial = True


def _contact_name(foot: int) -> str:
    return f"{FEET[foot]}_contact"


def tip_geoms(model: mujoco.MjModel, foot: int) -> list[int]:
    """Ids of the geoms with which a sole touches the floor."""
    return [geom for geom in range(model.ngeom) if model.geom(geom).name.startswith(_tips(foot))]


def _tips(foot: int) -> str:
    """Begins the names of those geoms."""
    return f"{_OURS}{FEET[foot]}_tip_"


def _add_contact_sensor(spec: mujoco.MjSpec, foot: int, touching: str) -> None:
    """The sum of all contacts between the floor and the body of one shoe that touches it."""
    kinds = mujoco.mjtConDataField
    fields = (kinds.mjCONDATA_FORCE, kinds.mjCONDATA_TORQUE, kinds.mjCONDATA_POS)
    spec.add_sensor(
        name=_contact_name(foot),
        type=mujoco.mjtSensor.mjSENS_CONTACT,
        objtype=mujoco.mjtObj.mjOBJ_GEOM,
        objname="floor",
        reftype=mujoco.mjtObj.mjOBJ_BODY,
        refname=touching,
        intprm=[sum(1 << int(field) for field in fields), _NET_FORCE, 1],
    )


def _contact(rules: PlantVariation) -> dict[str, list[float]]:
    return {
        "friction": [rules.floor.friction, 0.0, 0.0],
        "solref": [rules.floor.contact_time_s, 1.0],
    }
