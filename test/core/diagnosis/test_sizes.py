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
        scored = drawn.scorer.score(parts, foretell=False)
        for index, truth in enumerate(TRUTH.values()):
            found = sizes(drawn, scored, index)
            assert tuple(found) == tuple(one.name for one in parts[index][0].effect.components)
            for size, true in zip(found.values(), truth, strict=True):
                low, high = size.ci95
                held.append(low <= true <= high)
                off.append((size.value - true) / (high - low))
                assert size.value == pytest.approx(0.5 * (low + high))
    assert 0.88 <= np.mean(held) <= 0.99 + 1e-9
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
    for fraction in (0.003, 0.1):
        drawn = urn.draw(np.random.default_rng(3), {label: [fraction]})
        scored = drawn.scorer.best_form(creep)
        time = sizes(drawn, scored, 0)["time"]
        assert time.value == scored.parts[0][1].shape.fixed["time"]
        spreads.append(form_spread(drawn, scored, 0, "time", time.value))
        assert time.ci95[1] - time.value == pytest.approx(1.96 * spreads[-1])
    assert scored.parts[0][1].shape.fixed["time"] == creep.forms[2].shape.fixed["time"]
    assert spreads[1] < spreads[0]


def test_larger_blocks_of_alike_errors_widen_intervals(urn: Urn) -> None:
    """What the noise model does not tell: an error alike for seconds, in all signals."""
    rng = np.random.default_rng(4)
    parts = [part(urn.workspace, "floor_tilt")]
    widths = []
    for wild in (0.0, 3.0):
        residuals = urn.draw(rng, {"floor_tilt": TRUTH["floor_tilt"]}).scene.residuals
        samples = urn.workspace.scene.samples
        blocks = np.floor(samples.clock / 5.0).astype(int)
        error = rng.normal(size=(blocks.max() + 1, residuals.shape[1]))[blocks]
        wilder = residuals + wild * error * urn.workspace.noise.std
        drawn = urn.showing(np.where(urn.workspace.scene.mask, wilder, 0.0))
        found = sizes(drawn, drawn.scorer.score(parts), 0)["about_x"]
        widths.append(found.ci95[1] - found.ci95[0])
    assert widths[1] > 1.5 * widths[0]
