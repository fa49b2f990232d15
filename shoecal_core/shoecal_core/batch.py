"""A function of one vector over many samples, compiled for several samples at a time."""

from __future__ import annotations

import ctypes
from collections.abc import Callable
from pathlib import Path

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from shoecal_core.batch_source import batch_source
from shoecal_core.compiled import made_or_interpreted, require_same
from shoecal_core.compiler import CompilerError, library
from shoecal_core.errors import ShapeError

FloatArray = NDArray[np.float64]

LEAST = 4096
"""Samples of one call that pay for compiling a function of some 1000 operations (0.4 s)."""
_FUSED = ("-ffp-contract=fast", "-fexpensive-optimizations")
_CHECKED = 21
"""Samples that compiled code is tried on: whole blocks and a part of one."""


class Batch:
    """Evaluates a function (n,) -> (m,) for T samples, (T, n) -> (T, m)."""

    def __init__(self, function: ca.Function, least: int = LEAST, *, fused: bool = False) -> None:
        """Take a function; nothing is compiled before it pays.

        Args:
            function: SX function of one dense vector with one vector as output.
            least: samples of a call from which on machine code is used; fewer are interpreted, with
                the same values but for rounding. A call's own size decides, so that one call has
                one result, whatever was called before.
            fused: round a product and its sum once, where the processor can: a fifth faster. Not
                for functions with roots or comparisons: `x * x - x * x` is no more zero then.
        """
        self._function = function
        self._least = least
        self._flags = _FUSED if fused else ()
        self._code: Callable[[FloatArray], FloatArray] | None = None
        self._tried = False

    def __call__(self, samples: FloatArray) -> FloatArray:
        """(T, m) values of samples (T, n).

        Raises:
            ShapeError: for samples of another shape.
        """
        width = self._function.size1_in(0)
        if samples.ndim != 2 or samples.shape[1] != width:
            raise ShapeError("samples", f"(T, {width})", samples.shape)
        if len(samples) >= self._least and not self._tried:
            self._code = made_or_interpreted(self._function.name(), self._load)
            self._tried = True
        if len(samples) < self._least or self._code is None:
            return self._interpreted(samples)
        return self._code(samples)

    def _interpreted(self, samples: FloatArray) -> FloatArray:
        if not len(samples):
            return np.zeros((0, self._function.size1_out(0)))
        return np.array(self._function(samples.T)).T

    def _load(self) -> Callable[[FloatArray], FloatArray]:
        file = library(batch_source(self._function), *self._flags)
        code = _loaded(file, self._function.size1_out(0))
        trial = np.random.default_rng(0).uniform(
            -np.pi, np.pi, (_CHECKED, self._function.size1_in(0))
        )
        require_same([code(trial)], [self._interpreted(trial)], file)
        return code


def _loaded(file: Path, outputs: int) -> Callable[[FloatArray], FloatArray]:
    try:
        entry = ctypes.CDLL(str(file)).batch
    except (OSError, AttributeError) as error:
        raise CompilerError(f"{file} cannot be loaded; remove it") from error
    entry.argtypes = [ctypes.c_void_p, ctypes.c_void_p, ctypes.c_long]
    entry.restype = None

    def evaluate(samples: FloatArray) -> FloatArray:
        rows = np.ascontiguousarray(samples, dtype=np.float64)
        values = np.empty((len(rows), outputs))
        entry(rows.ctypes.data, values.ctypes.data, len(rows))
        return values

    return evaluate
