"""The policy for nodes in a namespace."""

from __future__ import annotations

from xml.etree import ElementTree as ET

import pytest

from ros.policy import POLICY
from shoecal_ros.security_policy import main, policy


def test_every_profile_is_of_the_namespace_and_nothing_else_changes() -> None:
    own, moved = POLICY.read_text(), policy("lab/one/")
    profiles = list(ET.fromstring(moved).iter("profile"))
    assert {profile.attrib["ns"] for profile in profiles} == {"/lab/one"}
    assert moved.replace('ns="/lab/one"', 'ns="/"') == own
    assert policy("/") == own


def test_it_is_written_to_standard_output(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["/lab"]) == 0
    assert capsys.readouterr().out == policy("lab")


def test_what_is_no_namespace_is_one_line_of_error(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["my lab"]) == 1
    said = capsys.readouterr()
    assert said.out == ""
    assert said.err.startswith("security_policy: namespace my lab: ")
    assert said.err.count("\n") == 1
