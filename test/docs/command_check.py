"""Whether a command that is not run could be: its program, arguments, names and types."""

from __future__ import annotations

import ast
import contextlib
import importlib
import io
import re
from functools import cache

import yaml

from docs.pages import ROOT, blocks, words
from reference.commands import command_parser
from reference.launch_files import arguments
from shoecal_core.cli.parsers import COMMANDS, command_line

ROS_CALLS = ("echo", "list", "info", "hz", "show", "prefix", "executables", "play")


def problem(command: str) -> str:
    """What is wrong with a command, empty where nothing is known to be."""
    try:
        parts = words(command)
    except ValueError as error:
        return str(error)
    while parts and re.match(r"[A-Z_]+=", parts[0]):
        parts = parts[1:]
    name = parts[0].rpartition("/")[2] if parts else ""
    check = {"shoecal": _shoecal, "make": _make, "ros2": _ros2, "python": _python}.get(name)
    return check(parts[1:]) if check else ""


def _shoecal(parts: list[str]) -> str:
    if not parts or parts[0].startswith("-"):
        return ""
    if parts[0] not in COMMANDS:
        return f"no command {parts[0]}"
    cut = next((i for i, part in enumerate(parts) if part in ("|", ">", "&&")), len(parts))
    errors = io.StringIO()
    try:
        with contextlib.redirect_stderr(errors):
            command_line(parts[:1]).parse_args(parts[:cut])
    except SystemExit:
        return errors.getvalue()
    return ""


def _make(parts: list[str]) -> str:
    makefile = (ROOT / "Makefile").read_text()
    for part in parts:
        name, is_variable, value = part.partition("=")
        if is_variable and name == "ARGS":
            continue
        if is_variable:
            if name not in makefile + (ROOT / "scripts/setup.sh").read_text():
                return f"make knows no {name}"
        elif not re.search(rf"^{re.escape(part)}:", makefile, re.MULTILINE):
            return f"make knows no {part}"
        del value
    given = " ".join(part.removeprefix("ARGS=") for part in parts if part.startswith("ARGS="))
    for option in re.findall(r"--[a-z-]+", given):
        if option not in _sources_of(parts[0]):
            return f"make {parts[0]} takes no {option}"
    return ""


@cache
def _sources_of(target: str) -> str:
    """What a target starts: a script, or a command of shoecal."""
    makefile = (ROOT / "Makefile").read_text()
    found = re.search(rf"^{target}:(?! export).*\n((?:\t.*\n)+)", makefile, re.MULTILINE)
    recipe = found[1] if found else ""
    scripts = re.findall(r"(?:benchmarks|scripts)/\w+\.py", recipe)
    texts = [(ROOT / script).read_text() for script in scripts]
    if "shoecal demo" in recipe:
        texts.append(command_parser("demo").format_help())
    return "\n".join(texts)


def _python(parts: list[str]) -> str:
    script = next((part for part in parts if part.endswith(".py")), "")
    if parts[:1] == ["-m"]:
        package = parts[1].split(".")
        return (
            ""
            if (ROOT / package[0] / "/".join(package)).with_suffix(".py").exists()
            else (f"no module {parts[1]}")
        )
    written = {block.title for block in blocks()}
    known = not script or script in written or (ROOT / script).exists()
    return "" if known else f"no file {script}"


def _ros2(parts: list[str]) -> str:
    kind, *rest = parts
    if kind == "launch":
        return _launch(rest)
    if kind == "run":
        return _run(rest)
    if kind in ("service", "action") and rest[0] in ("call", "send_goal"):
        return _call(kind, [part for part in rest[1:] if not part.startswith("--")])
    if kind == "topic" and rest[0] in ROS_CALLS:
        names = [part for part in rest[1:] if part.startswith("/")]
        known = _page("topics.md") + "/rosout /tf"
        return next((f"no topic {name}" for name in names if name not in known), "")
    return ""


def _launch(parts: list[str]) -> str:
    package, name, *given = parts
    file = ROOT / package / "launch" / name
    if package != "shoecal_ros" or not file.exists():
        return f"no launch file {package} {name}"
    known = {key for key, _ in arguments(ast.parse(file.read_text()))}
    unknown = {part.partition(":=")[0] for part in given if ":=" in part} - known
    return f"{name} has no {', '.join(sorted(unknown))}" if unknown else ""


def _run(parts: list[str]) -> str:
    package, name, *given = parts
    if package != "shoecal_ros":
        return f"{package} is not ours"
    if f'"{name}"' not in (setup := (ROOT / "shoecal_ros/setup.py").read_text()) and (
        f'"{name} = ' not in setup
    ):
        return f"no node {name}"
    names = [part.partition(":=")[0] for part in given if ":=" in part]
    known = _page("parameters.md")
    return next((f"no parameter {one}" for one in names if f"`{one}`" not in known), "")


def _call(kind: str, parts: list[str]) -> str:
    name, type_name, *fields = parts
    row = next((row for row in _page("topics.md").splitlines() if f"`{name}`" in row), "")
    package, _, plain = type_name.split("/")
    if f"{package}/{plain}" not in row:
        return f"{name} is no {type_name}"
    cls = getattr(
        importlib.import_module(f"{package}.{'srv' if kind == 'service' else kind}"), plain
    )
    request = cls.Request if kind == "service" else cls.Goal
    values = yaml.safe_load(fields[0]) if fields else {}
    unknown = set(values or {}) - set(request.get_fields_and_field_types())
    return f"{type_name} has no {', '.join(sorted(unknown))}" if unknown else ""


@cache
def _page(name: str) -> str:
    return (ROOT / "docs/reference" / name).read_text()
