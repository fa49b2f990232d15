"""What an expression of a source may say, as far as that stands in its own file."""

from __future__ import annotations

import ast
from collections.abc import Iterator
from itertools import product
from pathlib import Path

ELSEWHERE = "…"
"""Stands for what is put into a text from elsewhere."""

Function = ast.FunctionDef | ast.AsyncFunctionDef


class Source:
    """One file."""

    def __init__(self, path: Path) -> None:
        self.tree = ast.parse(path.read_text())
        self._under_way: list[ast.expr] = []
        self._functions = [one for one in ast.walk(self.tree) if isinstance(one, Function)]

    def calls(self) -> Iterator[ast.Call]:
        """All there are."""
        return (node for node in ast.walk(self.tree) if isinstance(node, ast.Call))

    def texts(self, said: ast.expr) -> list[str]:
        """All that an expression may be, each with ELSEWHERE for what is not known here."""
        return [ELSEWHERE] if said in self._under_way else self._known(said)

    def _known(self, said: ast.expr) -> list[str]:
        if isinstance(said, ast.Constant):
            return [str(said.value)]
        if isinstance(said, ast.JoinedStr):
            return ["".join(parts) for parts in product(*map(self.texts, said.values))]
        if isinstance(said, ast.FormattedValue):
            return self.texts(said.value) if said.format_spec is None else [ELSEWHERE]
        if isinstance(said, ast.IfExp):
            return self.texts(said.body) + self.texts(said.orelse)
        if isinstance(said, ast.GeneratorExp | ast.ListComp):
            return self.texts(said.elt)
        self._under_way.append(said)
        found = [text for one in self._behind(said) for text in self.texts(one)]
        self._under_way.pop()
        return found or [ELSEWHERE]

    def _behind(self, said: ast.expr) -> list[ast.expr]:
        """What a name, an attribute of `self` or a call of this file stands for."""
        if isinstance(said, ast.Name):
            return self._assigned(said)
        if isinstance(said, ast.Attribute) and ast.unparse(said.value) == "self":
            return self._returned(said.attr) or self._kept(said.attr)
        if isinstance(said, ast.Call):
            name = ast.unparse(said.func).removeprefix("self.")
            return self._returned(name)
        return []

    def _assigned(self, name: ast.Name) -> list[ast.expr]:
        """The last before it in its function; else of the whole file."""
        inside = [one for one in self._functions if _holds(one, name)]
        for scope in (*reversed(inside), self.tree):
            found = [
                (line, value)
                for target, value, line in _assignments(scope)
                if target == name.id and (line < name.lineno or scope is self.tree)
            ]
            if found:
                return [max(found, key=lambda one: one[0])[1]]
        return []

    def _kept(self, attribute: str) -> list[ast.expr]:
        return [v for target, v, _ in _assignments(self.tree) if target == f"self.{attribute}"]

    def _returned(self, name: str) -> list[ast.expr]:
        return [
            node.value
            for function in self._functions
            if function.name == name
            for node in ast.walk(function)
            if isinstance(node, ast.Return) and node.value is not None
        ]


def _holds(function: Function, node: ast.expr) -> bool:
    return function.lineno <= node.lineno <= (function.end_lineno or 0)


def _assignments(scope: ast.AST) -> Iterator[tuple[str, ast.expr, int]]:
    """Target, value and line."""
    for node in ast.walk(scope):
        if isinstance(node, ast.Assign):
            for target in node.targets:
                yield from _pairs(target, node.value, node.end_lineno or 0)
        elif isinstance(node, ast.comprehension):
            yield ast.unparse(node.target), node.iter, node.iter.lineno - 1


def _pairs(target: ast.expr, value: ast.expr, line: int) -> Iterator[tuple[str, ast.expr, int]]:
    if isinstance(target, ast.Tuple) and isinstance(value, ast.Tuple):
        for one, its in zip(target.elts, value.elts, strict=True):
            yield ast.unparse(one), its, line
    else:
        yield ast.unparse(target), value, line
