"""What scripts import from the package itself."""

from __future__ import annotations

import ast
import subprocess
import sys
from importlib import import_module
from pathlib import Path

import pytest

import shoecal_core

SOURCE = Path(shoecal_core.__file__).read_text()
TYPED = {
    alias.name: node.module
    for node in ast.walk(ast.parse(SOURCE))
    if isinstance(node, ast.ImportFrom) and node.module and node.module.startswith("shoecal_core.")
    for alias in node.names
}
"""Names and their modules, as type checkers see them."""


@pytest.mark.parametrize("name", shoecal_core.__all__)
def test_a_public_name_is_what_its_module_defines(name: str) -> None:
    defined = getattr(import_module(TYPED[name]), name)
    assert getattr(shoecal_core, name) is defined
    assert defined.__module__ == TYPED[name]


def test_every_name_is_listed() -> None:
    assert sorted(TYPED) == sorted(shoecal_core.__all__) == dir(shoecal_core)


def test_an_unknown_name_is_an_error() -> None:
    with pytest.raises(AttributeError, match="no attribute 'calibrate'"):
        _ = shoecal_core.calibrate


def test_the_package_alone_loads_nothing_heavy() -> None:
    program = "import sys, shoecal_core; print({'numpy', 'pinocchio'} & set(sys.modules))"
    done = subprocess.run(
        [sys.executable, "-c", program], capture_output=True, text=True, check=True
    )
    assert done.stdout.strip() == "set()"
