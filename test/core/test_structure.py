"""Dependencies run one way, and the core needs neither ROS nor a serial port."""

from __future__ import annotations

import ast
import subprocess
import sys
from collections.abc import Iterator
from graphlib import TopologicalSorter
from pathlib import Path

import pytest

import shoecal_core

ROOT = Path(shoecal_core.__file__).parent

FOUNDATION = {
    "arrays",
    "errors",
    "file_kinds",
    "files",
    "parameter_file",
    "progress",
    "settings",
    "workspace",
}
DESCRIPTION = FOUNDATION | {"robot", "shoe"}
RECORDED = DESCRIPTION | {"recording", "samples"}
ESTIMATION = RECORDED | {"error_sources", "screening", "planning", "estimation"}
MAY_IMPORT = {
    "arrays": set[str](),
    "end_with_parent": set[str](),
    "errors": set[str](),
    "file_kinds": set[str](),
    "files": FOUNDATION,
    "parameter_file": FOUNDATION,
    "progress": set[str](),
    "settings": FOUNDATION,
    "workspace": FOUNDATION,
    "shoe": DESCRIPTION,
    "robot": DESCRIPTION,
    "drafting": DESCRIPTION,
    "planning": DESCRIPTION,
    "simulation": DESCRIPTION,
    "recording": DESCRIPTION,
    "samples": RECORDED,
    "error_sources": DESCRIPTION | {"samples"},
    "screening": RECORDED | {"error_sources"},
    "estimation": ESTIMATION,
    "manual": DESCRIPTION | {"screening", "estimation"},
    "diagnosis": ESTIMATION,
    "report": ESTIMATION | {"manual", "diagnosis"},
    "workflows": ESTIMATION | {"manual", "diagnosis", "simulation", "report"},
}
"""What each part may import besides itself; parts not listed are the ends."""


def module_name(file: Path) -> str:
    parts = file.relative_to(ROOT.parent).with_suffix("").parts
    return ".".join(parts[:-1] if parts[-1] == "__init__" else parts)


MODULES = {module_name(file): file for file in sorted(ROOT.rglob("*.py"))}


class WithoutTyping(ast.NodeTransformer):
    """Drops what is imported for type checking only."""

    def visit_If(self, node: ast.If) -> ast.AST | None:
        return None if ast.unparse(node.test) == "TYPE_CHECKING" else self.generic_visit(node)


def imports(module: str, *, at_run_time: bool = False) -> Iterator[str]:
    """Names of all that a module imports, wherever in it."""
    tree: ast.AST = ast.parse(MODULES[module].read_text())
    if at_run_time:
        tree = WithoutTyping().visit(tree)
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0, f"{module}: relative imports hide where a name comes from"
            assert node.module is not None
            yield node.module
            yield from (f"{node.module}.{alias.name}" for alias in node.names)


def part(module: str) -> str:
    """The part of the core a module belongs to; empty for the root and for foreign modules."""
    names = module.split(".")
    return names[1] if names[0] == "shoecal_core" and len(names) > 1 else ""


@pytest.mark.parametrize("module", [name for name in MODULES if part(name) in MAY_IMPORT])
def test_dependencies_run_one_way(module: str) -> None:
    allowed = MAY_IMPORT[part(module)] | {part(module), ""}
    wrong = sorted({name for name in imports(module) if part(name) not in allowed})
    assert not wrong, f"{module} must not import {wrong}"


def test_only_the_ends_are_unlisted() -> None:
    assert {part(name) for name in MODULES} - {*MAY_IMPORT, ""} <= {"cli", "one_thread"}


def test_modules_import_each_other_in_no_circle() -> None:
    graph = {
        module: set(imports(module, at_run_time=True)).intersection(MODULES) - {module}
        for module in MODULES
    }
    list(TopologicalSorter(graph).static_order())


def test_the_core_imports_no_ros_and_no_serial_port() -> None:
    program = (
        "import importlib, sys\n"
        "for name in sys.argv[1:]: importlib.import_module(name)\n"
        "print(*{'rclpy', 'serial', 'shoecal_msgs', 'shoecal_ros'}.intersection(sys.modules))\n"
    )
    done = subprocess.run(
        [sys.executable, "-c", program, *MODULES], capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr
    assert not done.stdout.split()


@pytest.mark.parametrize("command", ["apply", "calibrate", "check", "diagnose", "evaluate"])
def test_commands_on_recordings_load_no_simulation_and_no_solver_of_motions(command: str) -> None:
    program = (
        f"import sys; import shoecal_core.cli.{command}_command\n"
        "print(*{'mujoco', 'matplotlib'}.intersection(sys.modules))\n"
        "print(*(name for name in sys.modules if name.startswith(\n"
        "    ('shoecal_core.simulation', 'shoecal_core.planning.horizon', 'shoecal_core.drafting')"
        ")))\n"
    )
    done = subprocess.run(
        [sys.executable, "-c", program], capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr
    assert not done.stdout.split()
