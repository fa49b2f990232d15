"""Launch files and their arguments, read without starting anything."""

from __future__ import annotations

import ast
from pathlib import Path

from reference.markdown import code, fenced, page, table


def launch_page(root: Path) -> str:
    """The page.

    Args:
        root: of the checkout.
    """
    parts: list[str] = []
    for file in sorted((root / "shoecal_ros" / "launch").glob("*.launch.py")):
        tree = ast.parse(file.read_text())
        title, _, rest = (ast.get_docstring(tree) or "").partition("\n\n")
        parts += [f"## {file.name}", title]
        parts += [_prose(block) for block in rest.split("\n\n") if block]
        rows = [(code(name), code(default), text) for name, (default, text) in arguments(tree)]
        parts.append(table(("argument", "default", "what it is"), rows))
    lead = (
        "`CONFIG` is the installed configuration, `share/shoecal_core/config`. "
        "`ros2 launch shoecal_ros FILE --show-args` tells the same."
    )
    return page("Launch files", lead, parts)


def arguments(tree: ast.Module) -> list[tuple[str, tuple[str, str]]]:
    """Name, default and text of the arguments that a launch file lists in `ARGUMENTS`."""
    found = []
    for statement in tree.body:
        if not isinstance(statement, ast.Assign):
            continue
        names = [target.id for target in statement.targets if isinstance(target, ast.Name)]
        if names == ["ARGUMENTS"] and isinstance(statement.value, ast.Dict):
            for key, value in zip(statement.value.keys, statement.value.values, strict=True):
                if not (isinstance(key, ast.Constant) and isinstance(value, ast.Tuple)):
                    continue
                default, text = value.elts
                found.append((str(key.value), (_told(default), _told(text))))
    return found


def _told(node: ast.expr) -> str:
    """A constant as it stands, a path by its parts."""
    if isinstance(node, ast.Constant):
        return str(node.value)
    text = ast.unparse(node)
    parts = text.removeprefix("str(").removesuffix(")").split(" / ")
    return "/".join(part.strip("'") for part in parts)


def _prose(block: str) -> str:
    lines = block.splitlines()
    if all(line.startswith("    ") for line in lines):
        return fenced("\n".join(line[4:] for line in lines))
    return " ".join(lines)
