"""The oldest versions that the packages declare are those that `make test-floor` runs with."""

from __future__ import annotations

import ast
import re

import pytest
from packaging.requirements import Requirement
from packaging.utils import canonicalize_name
from packaging.version import Version

from docs.pages import ROOT

UBUNTU = {
    "jinja2": "3.1.2",
    "markupsafe": "2.1.5",
    "matplotlib": "3.6.3",
    "numpy": "1.26.4",
    "pyserial": "3.5",
    "pyyaml": "6.0.1",
    "rich": "13.7.1",
    "scipy": "1.11.4",
    "shapely": "2.0.3",
    "zstandard": "0.22.0",
}
"""What apt installs on Ubuntu 24.04; all others come from the index."""
SET_UPS = ("shoecal_core/setup.py", "shoecal_ros/setup.py")
PINNED = r"^([a-z0-9-]+)==([^\s;]+)"


def declared() -> dict[str, str]:
    """The floor of every requirement, by name."""
    found: dict[str, str] = {}
    for name in SET_UPS:
        for node in ast.walk(ast.parse((ROOT / name).read_text())):
            if isinstance(node, ast.keyword) and node.arg == "install_requires":
                for text in ast.literal_eval(node.value):
                    requirement = Requirement(text)
                    (bound,) = requirement.specifier
                    assert bound.operator in {">=", "=="}, text
                    found[canonicalize_name(requirement.name)] = bound.version
    return found


def pinned(name: str) -> dict[str, str]:
    return dict(re.findall(PINNED, (ROOT / name).read_text(), re.MULTILINE))


@pytest.mark.parametrize("name", ["requirements-floor.in", "requirements-floor.txt"])
def test_the_declared_floors_are_those_that_are_tested(name: str) -> None:
    tested, floors = pinned(name), declared()
    assert {one: tested.get(one) for one in floors} == floors


def test_no_floor_is_above_what_ubuntu_has() -> None:
    floors = declared()
    too_new = [name for name, has in UBUNTU.items() if Version(floors[name]) > Version(has)]
    assert not too_new
