from __future__ import annotations

import json
import os
from pathlib import Path

import pytest
from rosbags.interfaces import QosDurability, QosHistory, QosReliability
from rosbags.rosbag2.metadata import parse_qos
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

from shoecal_core.recording import schemas

ALL_TYPES = sorted({*schemas.RUN_TOPICS.values(), *schemas.TRUTH_TOPICS.values()})
CHECKOUT = Path(__file__).parents[3]


def test_definition_is_that_of_the_message_package() -> None:
    path = CHECKOUT / "shoecal_msgs" / "msg" / "ShoeVoltages.msg"
    assert path.read_text() == schemas.SHOE_VOLTAGES_DEFINITION


def test_constants_are_those_of_the_definition() -> None:
    constants, _ = schemas.typestore().fielddefs[schemas.SHOE_VOLTAGES_TYPE]
    values = {name: value for name, _, value in constants}
    assert values["GOOD"] == schemas.GOOD
    assert values["NO_DATA"] == schemas.NO_DATA
    assert values["FAULT"] == schemas.FAULT


def test_hash_of_joint_state_is_the_published_one() -> None:
    expected = "RIHS01_a13ee3a330e346c9d87b5aa18d24e11690752bd33a0350f11c5882bc9179260e"
    assert schemas.type_hash("sensor_msgs/msg/JointState") == expected


@pytest.mark.parametrize("type_name", ALL_TYPES)
def test_schema_text_says_all_of_the_type(type_name: str) -> None:
    store = get_typestore(Stores.EMPTY)
    store.register(get_types_from_msg(schemas.schema_text(type_name).decode(), type_name))
    assert store.hash_rihs01(type_name) == schemas.type_hash(type_name)


@pytest.mark.parametrize("type_name", ALL_TYPES)
def test_hash_is_the_one_ros_generated(type_name: str) -> None:
    package, kind, name = type_name.split("/")
    for prefix in os.environ.get("AMENT_PREFIX_PATH", "").split(os.pathsep):
        generated = Path(prefix, "share", package, kind, f"{name}.json")
        if generated.is_file():
            hashes = json.loads(generated.read_text())["type_hashes"]
            assert {item["type_name"]: item["hash_string"] for item in hashes}[
                type_name
            ] == schemas.type_hash(type_name)
            return
    pytest.skip(f"no built {package} on AMENT_PREFIX_PATH")


def test_quality_of_service_is_read_by_others() -> None:
    metadata = schemas.channel_metadata("sensor_msgs/msg/Imu")
    (qos,) = parse_qos(metadata["offered_qos_profiles"])
    assert (qos.history, qos.depth) == (QosHistory.KEEP_LAST, 10)
    assert qos.reliability == QosReliability.RELIABLE
    assert qos.durability == QosDurability.VOLATILE
