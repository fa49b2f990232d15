"""Functions that take or return arrays name their shapes."""

from __future__ import annotations

import ast
import re
from collections.abc import Iterator
from pathlib import Path

import pytest

import shoecal_core

ROOT = Path(shoecal_core.__file__).parent

ARRAY = re.compile(r"\b(FloatArray|BoolArray|IntArray|NDArray)\b")
AXIS = r"(?:[0-9]*[a-wA-Z]'?|[0-9]+|[A-Z][A-Z_]+|T_run|count|feet|njoints|nq|segments|size|width)"
SIZE = rf"(?:\.\.\.|{AXIS}(?: [-+] {AXIS})?)"
SHAPE = re.compile(rf"\(\.\.\.\)|\({SIZE},(?: {SIZE}(?:, {SIZE})*)?\)")
"""(3,), (T, n), (..., 3), (...), (2n + 1, BANDS); values such as (x, y) are none."""

MODULES = sorted(ROOT.rglob("*.py"))


def public_functions(parent: ast.Module | ast.ClassDef) -> Iterator[ast.FunctionDef]:
    """Of a module or a class and its classes; functions inside functions are not public."""
    for node in parent.body:
        if isinstance(node, ast.FunctionDef | ast.ClassDef) and not node.name.startswith("_"):
            if isinstance(node, ast.ClassDef):
                yield from public_functions(node)
            else:
                yield node


def has_arrays(function: ast.FunctionDef) -> bool:
    given = function.args
    annotations = [argument.annotation for argument in given.args + given.kwonlyargs]
    return any(
        ARRAY.search(ast.unparse(annotation))
        for annotation in (*annotations, function.returns)
        if annotation is not None
    )


@pytest.mark.parametrize("file", MODULES, ids=lambda file: str(file.relative_to(ROOT)))
def test_functions_with_arrays_name_their_shapes(file: Path) -> None:
    without = [
        f"{function.name} (line {function.lineno})"
        for function in public_functions(ast.parse(file.read_text()))
        if has_arrays(function) and not SHAPE.search(ast.get_docstring(function) or "")
    ]
    assert not without, f"no shape such as (T, n) in the docstrings of {without}"
