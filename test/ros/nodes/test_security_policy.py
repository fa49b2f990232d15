"""The policy's rights are what the real nodes make, and no more."""

from __future__ import annotations

import re
from dataclasses import fields
from pathlib import Path
from xml.etree import ElementTree as ET

import shoecal_ros
from core.shoe.shoes import ROOT
from ros.policy import POLICY, Rights, allowed, policy, used
from ros.viewers.layouts import shown_by
from ros.world import World
from shoecal_core.recording import schemas
from shoecal_ros.planner.settings import MovingSettings

NODES = ("shoe_driver", "model", "planner", "calibrator", "simulator", "voltage_stream")
SOURCES = Path(shoecal_ros.__file__).parent
PAGE = " ".join((ROOT / "docs/reference/security.md").read_text().split())
NOT_ALWAYS = {
    "shoe_driver": {"/shoe/voltages"},  # heard while somebody else sends them, too
    "calibrator": set(schemas.RUN_TOPICS),  # heard while it records; it stops the robot
    # where tf2_msgs is installed; and while somebody looks at the markers
    "model": {
        "/tf",
        "/shoe/cop",
        "/shoe/left/cop",
        "/shoe/left/grf",
        "/shoe/right/cop",
        "/shoe/right/grf",
        "/shoe/state",
    },
}
ELEMENTS = {
    "policy": {"enclaves"},
    "enclaves": {"enclave"},
    "enclave": {"profiles"},
    "profiles": {"profile"},
    "profile": {"topics", "services", "actions"},
    "topics": {"topic"},
    "services": {"service"},
    "actions": {"action"},
}
ATTRIBUTES = {
    "policy": {"version"},
    "enclave": {"path"},
    "profile": {"ns", "node"},
    "topics": {"publish", "subscribe"},
    "services": {"reply", "request"},
    "actions": {"call", "execute"},
}


def test_nothing_but_elements_stands_where_sros2_goes_through_all() -> None:
    """sros2 0.13 takes a comment between enclaves for an enclave, and gives up."""
    builder = ET.TreeBuilder(insert_comments=True)
    root = ET.parse(POLICY, ET.XMLParser(target=builder)).getroot()
    for name in ("enclaves", "profiles", "profile", "topics", "services", "actions"):
        for element in root.iter(name):
            assert {child.tag for child in element} <= ELEMENTS[name]


def test_it_has_the_form_of_a_policy() -> None:
    root = policy()
    assert (root.tag, root.attrib) == ("policy", {"version": "0.2.0"})
    for element in root.iter():
        inside = ELEMENTS.get(element.tag, set())
        assert {child.tag for child in element} <= inside, element.tag
        assert bool(len(element)) == bool(inside), f"<{element.tag}> is empty, or holds too much"
        assert set(element.attrib) <= ATTRIBUTES.get(element.tag, set())
        if element.tag in ("topics", "services", "actions"):
            assert set(element.attrib.values()) == {"ALLOW"}
    for enclave in root.iter("enclave"):
        (profile,) = enclave.iter("profile")
        assert enclave.attrib["path"] == f"/shoecal/{profile.attrib['node']}"


def test_no_right_is_a_pattern() -> None:
    for rights in allowed().values():
        for rule in fields(Rights):
            for name in rights.allow(rule.name):
                assert name.replace("/", "").replace("_", "").isalnum(), name


def test_every_node_has_an_enclave() -> None:
    nodes = {file.stem for file in SOURCES.glob("nodes/*.py")} - {"__init__"}
    assert nodes | {"voltage_stream"} | {"robot", "controller", "operator"} == set(allowed())


def test_the_page_tells_of_this_policy() -> None:
    enclaves = [enclave.attrib["path"] for enclave in policy().iter("enclave")]
    # Another number: validate it anew, as the page says that it was.
    assert re.findall(r"from this file \((\d+) enclaves\)", PAGE) == [str(len(enclaves))]
    table = re.findall(r"`(/shoecal/\w+)`", PAGE[PAGE.index("| enclave |") :])
    assert set(table) == set(enclaves)


def test_the_page_tells_when_arming_ends_by_itself() -> None:
    (reported,) = re.findall(r"\((\d+) s unless", PAGE)
    assert float(reported) == MovingSettings().arm_timeout_s
    # That page is made from the code and the files of config/.
    parameters = (ROOT / "docs/reference/parameters.md").read_text()
    assert f"| `arm_timeout_s` | `{reported}` | s |" in parameters


def holders(rule: str, name: str) -> set[str]:
    return {node for node, rights in allowed().items() if name in rights.allow(rule)}


def test_who_may_move_the_robot() -> None:
    assert holders("publish", "/joint_trajectory") == {"planner"}
    assert holders("publish", "/shoe/armed") == {"planner"}
    assert holders("request", "/shoe/arm") == {"operator"}
    assert holders("call", "/shoe/plan") == {"calibrator", "operator"}
    assert holders("call", "/robot/reach_support") == {"calibrator"}


def test_only_its_adapter_may_tell_a_driver() -> None:
    controller = "/joint_trajectory_controller"
    assert holders("publish", "/effectors/joint_positions") == {"nao_lola_adapter"}
    assert holders("publish", "/joint_angles") == {"naoqi_adapter"}
    assert holders("publish", f"{controller}/joint_trajectory") == {"controller_adapter"}
    assert holders("call", f"{controller}/follow_joint_trajectory") == {"controller_adapter"}


def test_the_operator_may_read_what_viewers_show() -> None:
    layouts = [file for name in ("foxglove", "plotjuggler", "rviz")
               for file in (ROOT / "shoecal_ros" / name).iterdir()]  # fmt: skip
    # The robot's description is published by its own nodes.
    shown = {one.topic for file in layouts for one in shown_by(file)} - {"/robot_description"}
    may = allowed()["operator"].subscribe
    # PlotJuggler writes fields behind a topic.
    assert {
        name for name in shown if not any(f"{name}/".startswith(f"{one}/") for one in may)
    } == set()
    assert "/shoe/voltages" in allowed()["operator"].subscribe


def test_who_may_make_forces() -> None:
    assert holders("publish", "/shoe/voltages") == {"shoe_driver"}
    assert holders("publish", "/shoe/cop") == {"calibrator"}
    assert holders("publish", "/shoe/calibration") == {"calibrator"}
    assert holders("request", "/shoe/set_calibration") == {"operator"}
    assert allowed()["controller"].publish == {"/rosout", "/parameter_events"}


def test_nobody_may_set_parameters() -> None:
    for rights in allowed().values():
        assert not any("set_parameters" in name for name in rights.request)


def test_rights_are_what_the_nodes_make(world: World) -> None:
    port = {"port": world.folder / "port"}
    folders = {"state_dir": world.folder / "state", "sessions_dir": world.folder / "sessions"}
    world.start("simulator", port)
    world.start("shoe_driver", {**port, "use_sim_time": True})
    world.start("model", {"use_sim_time": True})
    world.start("planner", {"use_sim_time": True, "steps": True})
    world.start("calibrator", {"use_sim_time": True, **folders})
    world.start("voltage_stream", {"use_sim_time": True}, script=SOURCES / "voltage_stream.py")
    expected, made = allowed(), dict.fromkeys(NODES, Rights())

    def missing() -> dict[str, dict[str, set[str]]]:
        """What is allowed, but not made yet, by node and rule."""
        found: dict[str, dict[str, set[str]]] = {}
        for node in NODES:
            made[node], sometimes = used(world.node, node), NOT_ALWAYS.get(node, set())
            for rule in fields(Rights):
                never = expected[node].allow(rule.name) - made[node].allow(rule.name) - sometimes
                if never:
                    found.setdefault(node, {})[rule.name] = never
        return found

    try:
        world.until(lambda: not missing())
    except AssertionError as error:
        raise AssertionError(f"allowed, but never made: {missing()}") from error
    for node in NODES:
        for rule in fields(Rights):
            beyond = made[node].allow(rule.name) - expected[node].allow(rule.name)
            assert not beyond, f"{node} needs the right to {rule.name} {beyond}"
