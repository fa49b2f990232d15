"""The true sizes of error sources, against the physics that a session was simulated with."""

from __future__ import annotations

from pathlib import Path

import mujoco
import numpy as np
import pinocchio as pin
import pytest

from core.simulation.worlds import DEFAULT, REALITIES, load_world
from shoecal_core.files import write_yaml
from shoecal_core.recording.session import Session
from shoecal_core.robot.gravity import GRAVITY
from shoecal_core.simulation import robot_physics
from shoecal_core.simulation.reality_file import load_reality
from shoecal_core.simulation.sampled_robot import SampledRobot, draw
from true_sources import Source, true_sources

NAO = load_world("nao")


@pytest.fixture(scope="module")
def drawn() -> SampledRobot:
    rules = load_reality(REALITIES / "default.yaml", REALITIES / "other_laws.yaml")
    return draw(rules, NAO.robot, NAO.shoe, 3)


@pytest.fixture(scope="module")
def sources(drawn: SampledRobot, tmp_path_factory: pytest.TempPathFactory) -> dict[Source, float]:
    robot, shoe = NAO.robot, NAO.shoe
    folder: Path = tmp_path_factory.mktemp("true") / "session"
    session = Session.create(folder, robot.path, robot.urdf, shoe.path, seed=3)
    truth = session.truth_path(1).parent
    truth.mkdir(exist_ok=True)
    write_yaml(truth / "reality.yaml", drawn.record())
    return true_sources(session)


def test_the_model_with_the_true_sizes_has_the_physics_mass_and_com(
    drawn: SampledRobot, sources: dict[Source, float]
) -> None:
    """Payloads at the links' CoM and shifts of it, put into Pinocchio's model."""
    robot = NAO.robot
    physics = robot_physics.build(robot, NAO.shoe, drawn).model
    data = mujoco.MjData(physics)
    mujoco.mj_kinematics(physics, data)
    mujoco.mj_comPos(physics, data)
    model, state = robot.model, robot.model.createData()
    base = physics.body(drawn.body.links[0]).id
    place = pin.SE3(data.xmat[base].reshape(3, 3), data.xpos[base])
    q = np.concatenate((pin.SE3ToXYZQUAT(place), np.zeros(len(robot.joint_names))))
    pin.framesForwardKinematics(model, state, q)
    moment = robot.mass * pin.centerOfMass(model, state, q)
    mass = robot.mass
    for link in drawn.body.links:
        frame = model.frames[model.getFrameId(link)]
        inertia = model.inertias[frame.parentJoint]
        joint = state.oMi[frame.parentJoint]
        payload = sources.get(("payload", (link,), "mass"), 0.0)
        shift = np.array([sources.get(("link_com", (link,), axis), 0.0) for axis in "xyz"])
        rotation = joint.rotation @ frame.placement.rotation
        # Shoes are lumped with the ankles: their plates do not move with the link's CoM.
        own = inertia.mass - (NAO.shoe.mass / 2.0 if link.endswith("ankle_link") else 0.0)
        moment += payload * joint.act(inertia.lever) + (own + payload) * rotation @ shift
        mass += payload
    assert mass == pytest.approx(physics.body_mass.sum(), abs=1e-5)
    # What shoes add to the ankles' CoM that payloads are put at is some 0.01 mm of the whole.
    assert moment / mass == pytest.approx(data.subtree_com[base], abs=5e-5)


def test_weight_is_what_the_scale_was_off_by(sources: dict[Source, float]) -> None:
    assert sources[("weight", (), "force")] == pytest.approx(DEFAULT.body.weight_error_n, abs=1e-9)
    payloads = sum(size for (effect, *_), size in sources.items() if effect == "payload")
    assert GRAVITY * payloads == pytest.approx(DEFAULT.body.weight_error_n, abs=1e-9)


def test_every_source_has_its_drawn_size(drawn: SampledRobot, sources: dict[Source, float]) -> None:
    body, shoes = drawn.body, drawn.shoes
    knee = NAO.robot.joint("LKneePitch")
    for effect, component, size in (
        ("joint_offset", "angle", body.encoder_error[knee]),
        ("joint_compliance", "compliance", body.compliance[knee]),
        ("backlash", "play", body.play[knee]),
        ("encoder_eccentricity", "amplitude", body.eccentricity[knee, 0]),
        ("encoder_eccentricity", "phase", body.eccentricity[knee, 1]),
        ("joint_friction", "static", body.friction[knee, 0]),
        ("joint_friction", "kinetic", body.friction[knee, 1]),
    ):
        assert sources[(effect, ("LKneePitch",), component)] == size != 0.0
    for index, name in enumerate(NAO.shoe.names):
        off = shoes.position[index] - NAO.shoe.positions[index]
        found = [sources[("cell_position", (name,), axis)] for axis in "xy"]
        assert found == pytest.approx(off.tolist())
        assert sources[("gain", (name,), "gain")] == shoes.parameters.gain[index]
        assert sources[("offset", (name,), "offset")] == shoes.parameters.offset[index]
    for foot in ("left", "right"):
        for axis in "xy":
            assert sources[("plates", (foot,), f"share_{axis}")] == 0.12
