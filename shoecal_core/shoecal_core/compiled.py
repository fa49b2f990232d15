"""CasADi functions as machine code, where the system has a C compiler.

CasADi writes a function out as C, the system's compiler translates it, and the result is compared
with the interpreted function before it is used. Where any of that fails, the interpreted one
serves: slower, with the same values, and said once.
"""

from __future__ import annotations

import logging
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TypeVar

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from shoecal_core.compiler import CompilerError, cache_folder, find_compiler, library, switched_off

FloatArray = NDArray[np.float64]
Made = TypeVar("Made")

_POINTS = 3
"""Inputs at which a compiled function is compared with its source."""
_ROUNDING = 1e-9
"""Largest difference there, as a share of an output's largest value, or of one."""

_log = logging.getLogger(__name__)
_compiled: set[str] = set()
_interpreted: dict[str, str] = {}


def compiled(function: ca.Function) -> ca.Function:
    """The same function, compiled; the function itself where that is impossible.

    Name, inputs and outputs stay. A compiled function has no derivatives: take them before.
    The first time on a machine takes a while (some 2 s for 15000 operations), later times do not.
    """
    return made_or_interpreted(function.name(), lambda: _load(function)) or function


def compiler_state() -> dict[str, object]:
    """What is compiled and what is not, and why: for diagnostics and `--json`."""
    state: dict[str, object] = {"enabled": not switched_off()}
    try:
        state |= {"compiler": find_compiler().version, "cache": str(cache_folder())}
    except CompilerError as error:
        state["problem"] = str(error)
    return state | {"compiled": sorted(_compiled), "interpreted": dict(_interpreted)}


def made_or_interpreted(name: str, make: Callable[[], Made]) -> Made | None:
    """What `make` compiles; None where the interpreted function has to serve.

    Each reason is said once.
    """
    if switched_off():
        return None
    try:
        made = make()
    except CompilerError as error:
        if str(error) not in _interpreted.values():
            _log.warning("shoecal: functions are interpreted, which is slower: %s", error)
        _interpreted[name] = str(error)
        return None
    _compiled.add(name)
    return made


def require_same(found: Sequence[FloatArray], expected: Sequence[FloatArray], file: Path) -> None:
    """Refuse compiled values that differ from interpreted ones by more than rounding.

    Raises:
        CompilerError: names the library.
    """
    for one, other in zip(found, expected, strict=True):
        known = np.isfinite(other)
        size = max(1.0, float(np.abs(other[known]).max(initial=0.0)))
        if not np.allclose(one, other, rtol=0.0, atol=_ROUNDING * size, equal_nan=True):
            raise CompilerError(f"{file} computes other values than its source; remove it")


def _load(function: ca.Function) -> ca.Function:
    file = library(_source(function))
    try:
        made = ca.external(function.name(), str(file))
    except RuntimeError as error:
        raise CompilerError(f"{file} cannot be loaded; remove it") from error
    rng = np.random.default_rng(0)
    for _ in range(_POINTS):
        point = [ca.DM(rng.uniform(-1.0, 1.0, function.size_in(i))) for i in range(function.n_in())]
        found, expected = (
            [np.array(value) for value in each.call(point)] for each in (made, function)
        )
        require_same(found, expected, file)
    return made


def _source(function: ca.Function) -> str:
    generator = ca.CodeGenerator(function.name())
    try:
        generator.add(function)
        return str(generator.dump())
    except RuntimeError as error:
        raise CompilerError(f"'{function.name()}' cannot be written as C") from error
