"""What the race comes to: which clock judges what, and which targets and aims were missed."""

from __future__ import annotations

from typing import Any, cast

import numpy as np
import pytest

from planner_cases import Loop, Solve, Span
from planner_figures import AIMS, COMPILED, MX, TARGETS, Measured, figures, missed
from shoecal_core.planning.horizon.problem import Solution
from shoecal_core.planning.settings import MODES

NOTHING = cast(Any, None)


def solves(wall: float, cpu: float) -> list[Solve]:
    solution = Solution(np.zeros((1, 3)), 1.0, 0.0, True, "Solved", 1)
    return [Solve(NOTHING, solution.states, solution, Span(wall, cpu)) for _ in range(3)]


def measured(fast: Span, slow: Span) -> Measured:
    loop = Loop(NOTHING, (), (), NOTHING, NOTHING, (), 1e-12, 1e-9, Span(1.0, 1.0))
    results = {mode: solves(fast.wall, fast.cpu) for mode in MODES}
    results |= {name: solves(slow.wall, slow.cpu) for name in (MX, COMPILED)}
    return Measured(results, np.ones(3), 3, {mode: [loop] for mode in MODES}, "")


def test_waiting_is_judged_by_the_clock_and_speed_by_the_processors_time() -> None:
    found = figures(measured(Span(0.012, 0.002), Span(0.5, 0.14)))
    assert found["bounded"]["p99_ms"] == pytest.approx(12.0)
    assert found["bounded"]["p99_cpu_ms"] == pytest.approx(2.0)
    assert found["realtime"]["vs_ipopt_mx"] == pytest.approx(70.0)
    assert missed(found, TARGETS) == ["bounded p99_ms: 12, not at most 10"]
    assert missed(found, AIMS) == []


def test_an_aim_that_is_missed_is_named() -> None:
    found = figures(measured(Span(0.002, 0.002), Span(0.04, 0.04)))
    assert "realtime vs_ipopt_compiled: 20, not at least 25" in missed(found, AIMS)
