"""Compiled functions are their sources, or give way to them."""

from __future__ import annotations

import logging
import subprocess
import sys
from collections.abc import Sequence
from pathlib import Path

import casadi as ca
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from core.compile_cache import libraries, program
from shoecal_core.compiled import compiled, compiler_state


def example() -> ca.Function:
    """Two inputs, two outputs, one of them sparse."""
    x, y = ca.SX.sym("x", 3), ca.SX.sym("y", 2, 2)
    value = ca.sin(x[0]) * ca.fmax(x[1], y[0, 1]) + ca.sqrt(y[1, 1] ** 2 + 1.0)
    other = ca.diag(ca.vertcat(ca.atan2(x[2], y[0, 0]), ca.if_else(x[0] > 0.0, x[1], x[2])))
    return ca.Function("example", [x, y], [value, other], ["x", "y"], ["value", "other"])


def around(inner: ca.Function) -> ca.Function:
    """The same as a graph of matrices that calls it."""
    symbols = inner.mx_in()
    return ca.Function("around", symbols, inner.call(symbols))


def angle_function() -> ca.Function:
    x = ca.SX.sym("x")
    return ca.Function("angle", [x], [ca.sin(x)])


NUMBERS = st.floats(allow_nan=True, allow_infinity=True)


@given(st.lists(NUMBERS, min_size=7, max_size=7))
def test_values_are_those_of_the_source(numbers: list[float]) -> None:
    for source in (example(), around(example())):
        made = compiled(source)
        assert made.class_name() == "External"
        point = [ca.DM(numbers[:3]), ca.DM(np.reshape(numbers[3:], (2, 2)))]
        for one, other in zip(made.call(point), source.call(point), strict=True):
            np.testing.assert_allclose(np.array(one), np.array(other), rtol=1e-15)


def test_name_inputs_and_outputs_stay() -> None:
    source = example()
    made = compiled(source)
    assert str(made).replace("External", "") == str(source).replace("SXFunction", "")
    assert made.sparsity_out(1) == source.sparsity_out(1)
    x, y = np.arange(12.0).reshape(3, 4), np.arange(16.0).reshape(2, 8)
    for one, other in zip(made.map(4)(x, y), source.map(4)(x, y), strict=True):
        np.testing.assert_allclose(np.array(one), np.array(other), rtol=1e-15)


def test_the_second_time_it_comes_from_the_cache(
    library_cache: Path, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    compiled(example())
    (file,) = libraries(library_cache)
    written = file.stat()
    compiled(example())
    assert libraries(library_cache) == [file]
    assert (file.stat().st_ino, file.stat().st_size) == (written.st_ino, written.st_size)
    state = compiler_state()
    assert (state["enabled"], state["compiled"], state["interpreted"]) == (True, ["example"], {})
    assert state["cache"] == str(library_cache)
    assert state["compiler"]


def interpreted(caplog: pytest.LogCaptureFixture, reason: str) -> None:
    """Two functions stay as they are, and the reason is said once, in one line."""
    caplog.clear()
    with caplog.at_level(logging.WARNING):
        for source in (angle_function(), angle_function()):
            assert compiled(source) is source
    (line,) = caplog.messages
    assert reason in line
    assert "slower" in line
    assert len(line.splitlines()) == 1
    assert reason in str(compiler_state()["interpreted"])


def test_without_a_compiler(
    library_cache: Path, caplog: pytest.LogCaptureFixture, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("PATH", "")
    interpreted(caplog, "no C compiler")
    assert "no C compiler" in str(compiler_state()["problem"])


def test_a_compiler_that_miscalculates(
    library_cache: Path, caplog: pytest.LogCaptureFixture, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("CC", "cc -Dsin=cos")
    interpreted(caplog, "computes other values than its source")


def test_a_compiler_that_makes_something_else(
    library_cache: Path,
    caplog: pytest.LogCaptureFixture,
    monkeypatch: pytest.MonkeyPatch,
    tmp_path: Path,
) -> None:
    script = 'while [ $# -gt 1 ]; do [ "$1" = -o ] && echo no library > "$2"; shift; done'
    monkeypatch.setenv("CC", program(tmp_path / "scribe", script))
    interpreted(caplog, "cannot be loaded")


def test_a_compiler_that_fails(
    library_cache: Path,
    caplog: pytest.LogCaptureFixture,
    monkeypatch: pytest.MonkeyPatch,
    tmp_path: Path,
) -> None:
    monkeypatch.setenv("CC", program(tmp_path / "failing", "echo no memory >&2; exit 1"))
    interpreted(caplog, "no memory")


def test_a_cache_that_others_can_write(
    library_cache: Path, caplog: pytest.LogCaptureFixture
) -> None:
    library_cache.mkdir(parents=True)
    library_cache.chmod(0o777)
    interpreted(caplog, "another user")
    assert libraries(library_cache) == []


def test_a_function_that_c_cannot_express(
    library_cache: Path, caplog: pytest.LogCaptureFixture
) -> None:
    class Own(ca.Callback):
        def __init__(self) -> None:
            super().__init__()
            self.construct("own", {})

        def eval(self, arg: Sequence[ca.DM]) -> list[ca.DM]:
            return [2.0 * arg[0]]

    own = Own()
    source = around(own)
    assert compiled(source) is source
    assert "error" in caplog.text
    assert len(caplog.messages) == 1


def test_switched_off(
    library_cache: Path, caplog: pytest.LogCaptureFixture, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("SHOECAL_COMPILE", "0")
    source = angle_function()
    assert compiled(source) is source
    assert not caplog.messages
    assert libraries(library_cache) == []
    assert compiler_state()["enabled"] is False


def test_a_program_shows_the_reason_on_standard_error(library_cache: Path) -> None:
    code = (
        "import casadi as ca; from shoecal_core.compiled import compiled; x = ca.SX.sym('x');"
        "print(compiled(ca.Function('f', [x], [2.0 * x]))(21.0))"
    )
    done = subprocess.run(
        [sys.executable, "-c", code], env={"PATH": ""}, capture_output=True, text=True, check=True
    )
    assert done.stdout == "42\n"
    assert done.stderr == (
        "shoecal: functions are interpreted, which is slower: there is no C compiler "
        "(cc, gcc, clang)\n"
    )
