"""Intervals of sizes hold as often as they say."""

from __future__ import annotations

import numpy as np
import pytest

from core.diagnosis.drawn import Urn, hypothesis, part
from shoecal_core.diagnosis.sizes import form_spread, sizes

TRUTH = {
    "cell_position (right/front_left)": (0.003, -0.002),
    "foot_placement (left)": (0.003, -0.002, 0.02),
    "floor_tilt": (0.006, -0.004),
    "payload (base_link)": (0.12,),
}


def test_intervals_hold_in_correlated_noise(urn: Urn) -> None:
    rng = np.random.default_rng(1)
    parts = [part(urn.workspace, label) for label in TRUTH]
    held, off = [], []
    for _ in range(20):
        drawn = urn.draw(rng, TRUTH)
        scored = drawn.scorer.score(parts)
        for index, truth in enumerate(TRUTH.values()):
            found = sizes(drawn, scored, index)
            assert tuple(found) == tuple(one.name for one in parts[index][0].effect.components)
            for size, true in zip(found.values(), truth, strict=True):
                low, high = size.ci95
                held.append(low <= true <= high)
                off.append((size.value - true) / (high - low))
                assert size.value == pytest.approx(0.5 * (low + high))
    # They are wider than this noise asks for: in reality signals tell partly the same.
    assert np.mean(held) >= 0.88
    assert abs(np.mean(off)) < 0.1


def test_units_are_the_components(urn: Urn) -> None:
    drawn = urn.draw(np.random.default_rng(2), TRUTH)
    scored = drawn.scorer.score([part(urn.workspace, "foot_placement (left)")])
    units = {name: size.unit for name, size in sizes(drawn, scored, 0).items()}
    assert units == {"dx": "m", "dy": "m", "dtheta": "rad"}


def test_a_component_that_forms_hold_is_as_sure_as_they_differ(urn: Urn) -> None:
    """Creep's time constant is that of the best of several forms."""
    label = "creep (left)"
    creep = hypothesis(urn.workspace, label)
    spreads = []
    for fraction in (0.01, 0.06):
        drawn = urn.draw(np.random.default_rng(3), {label: [fraction]})
        (glance,) = drawn.scorer.gains([creep])
        scored = max(
            (drawn.scorer.score([one]) for one in glance.parts), key=lambda one: one.evidence
        )
        time = sizes(drawn, scored, 0)["time"]
        assert time.value == scored.parts[0][1].shape.fixed["time"]
        spreads.append(form_spread(drawn, scored, 0, "time", time.value))
        assert time.ci95[1] - time.value >= 1.96 * spreads[-1]
    true = creep.usual.shape.fixed["time"]
    assert time.ci95[0] <= true <= time.ci95[1]
    assert spreads[1] < spreads[0]
