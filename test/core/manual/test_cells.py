from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from core.manual.benches import (
    DEFAULT,
    SETTINGS,
    changed,
    entry_of,
    nao_shoe,
    odd_shoe,
    read_cells,
    some_law,
    without,
)
from shoecal_core.errors import ShoecalError
from shoecal_core.manual.cells import fit_cells, law
from shoecal_core.manual.checks import check_lines
from shoecal_core.manual.loads import CELLS, Load
from shoecal_core.manual.measurements import Measurements
from shoecal_core.robot.gravity import GRAVITY
from shoecal_core.simulation.rig import LoadingRig
from shoecal_core.simulation.sampled_robot import draw_shoes
from shoecal_core.workflows.simulated_manual import read_rig

ONE = "left/front_right"


@given(st.integers(0, 2**32 - 1), st.lists(st.floats(0.1, 20.0), min_size=1, max_size=4))
def test_the_law_is_found(seed: int, weights: list[float]) -> None:
    shoe = nao_shoe()
    true = some_law(shoe, seed)
    # Half the converter's range bears half of the weights.
    scaled = sorted({round(weight / 10.0, 3) for weight in weights} - {0.0}) or [1.0]
    gain, offset, _ = law(fit_cells(read_cells(shoe, true, scaled)))
    np.testing.assert_allclose(gain, true.gain, rtol=1e-9)
    np.testing.assert_allclose(offset, true.offset, rtol=1e-9, atol=1e-9)


def test_two_loads_give_the_papers_formula() -> None:
    shoe = nao_shoe()
    cells = read_cells(shoe, some_law(shoe))
    own = shoe.index(ONE)
    unloaded, loaded = (entry.mean[own] for entry in cells.of_cell(ONE))
    sigma = (loaded - unloaded) / (2.0 * GRAVITY)
    fit = fit_cells(cells)[own]
    assert fit.gain == pytest.approx(1.0 / sigma)
    assert fit.offset == pytest.approx(-unloaded / sigma)
    assert np.isnan(fit.residual_std)


def test_cells_of_another_pair(tmp_path: Path) -> None:
    shoe = odd_shoe(tmp_path)
    true = some_law(shoe)
    gain, offset, _ = law(fit_cells(read_cells(shoe, true)))
    np.testing.assert_allclose(gain, true.gain)
    np.testing.assert_allclose(offset, true.offset)


def test_uncertainties_hold() -> None:
    """95 % intervals of gains and offsets hold what the rig drew, in about 95 % of the cases."""
    shoe = nao_shoe()
    inside, gains = [], []
    for seed in range(1, 26):
        drawn = draw_shoes(DEFAULT, shoe, seed)
        rig = LoadingRig(shoe, DEFAULT, drawn, np.random.default_rng(seed))
        cells, true = read_rig(rig, CELLS, SETTINGS), drawn.parameters
        gain, offset, covariance = law(fit_cells(cells))
        assert covariance is not None
        error = np.concatenate((gain - true.gain, offset - true.offset))
        inside.append(np.abs(error) < 1.96 * np.sqrt(np.diag(covariance)))
        gains.append(gain / true.gain)
    # Three loads leave one degree of freedom: where it shows more scatter than noise, it counts.
    assert 0.93 < np.mean(inside) < 0.995
    assert np.abs(np.array(gains) - 1.0).max() < 2e-3


def test_without_any_scatter_told_there_is_no_covariance() -> None:
    shoe = nao_shoe()
    cells = read_cells(shoe, some_law(shoe))
    blind = Measurements(
        CELLS,
        shoe,
        tuple(
            entry_of(shoe, entry.load, np.tile(entry.mean, 2), std=float("nan"))
            for entry in cells.entries
        ),
    )
    assert law(fit_cells(blind))[2] is None


def test_a_bent_line_shows_in_the_scatter() -> None:
    shoe = nao_shoe()
    cells = read_cells(shoe, some_law(shoe), (1.0, 2.0))
    fit = fit_cells(cells)[shoe.index(ONE)]
    assert fit.residual_std < 1e-9
    middle = Load(0, ONE, 1.0)
    mean = next(entry.mean for entry in cells.entries if entry.load == middle)
    bent = changed(cells, middle, mean=mean + 0.1)
    assert fit_cells(bent)[shoe.index(ONE)].residual_std > 0.5


def test_exchanged_weights_are_named_and_refused() -> None:
    shoe = nao_shoe()
    cells = read_cells(shoe, some_law(shoe), (1.0, 2.0))
    assert check_lines(fit_cells(cells)) == []
    loads = [Load(0, ONE, mass) for mass in (1.0, 2.0)]
    light, heavy = (
        next(entry.mean for entry in cells.entries if entry.load == load) for load in loads
    )
    other = changed(changed(cells, loads[0], mean=heavy), loads[1], mean=light)
    (finding,) = check_lines(fit_cells(other))
    assert finding.verdict == "FAIL"
    assert "about its line, and does not with 1 and 2 kg exchanged" in finding.reason
    # What bends a line a little is no exchange.
    (finding,) = check_lines(fit_cells(changed(cells, loads[0], mean=light + 0.03)))
    assert finding.verdict == "WARN"
    assert "exchanged" not in finding.reason


# ---- refused ----------------------------------------------------------------------------------


def refused(cells: Measurements, *texts: str) -> None:
    with pytest.raises(ShoecalError) as caught:
        fit_cells(cells)
    for text in texts:
        assert text in str(caught.value)


def test_cells_that_were_not_read() -> None:
    shoe = nao_shoe()
    cells = read_cells(shoe, some_law(shoe))
    loads = [Load(1, "right/rear_left", mass) for mass in (0.0, 2.0)]
    refused(without(cells, *loads), "no readings of right/rear_left")
    refused(without(cells, loads[0]), "right/rear_left was read under 2 kg only")
    refused(without(cells, loads[1]), "right/rear_left was read under 0 kg only")


def test_a_dead_cell() -> None:
    shoe = nao_shoe()
    cells = read_cells(shoe, some_law(shoe))
    load = Load(0, ONE, 2.0)
    bare = next(entry.mean for entry in cells.of_cell(ONE) if not entry.load.mass)
    refused(changed(cells, load, mean=bare), f"{ONE} does not respond to 2 kg")


def test_a_weight_on_the_cell_beside_it() -> None:
    shoe = nao_shoe()
    cells = read_cells(shoe, some_law(shoe))
    swapped = next(
        entry.mean for entry in cells.entries if entry.load == Load(0, "left/rear_left", 2.0)
    )
    refused(
        changed(cells, Load(0, ONE, 2.0), mean=swapped),
        f"left/rear_left responded to the weight on {ONE}",
    )


def test_cells_beside_it_may_be_unplugged() -> None:
    shoe = nao_shoe()
    true = some_law(shoe)
    cells = read_cells(shoe, true)
    entries = []
    for entry in cells.entries:
        alone = np.full(len(shoe.names), np.nan)
        own = shoe.of_foot(entry.load.foot).tolist().index(shoe.index(entry.load.place))
        alone[shoe.index(entry.load.place)] = entry.mean[own]
        entries.append(entry_of(shoe, entry.load, alone))
    gain, *_ = law(fit_cells(Measurements(CELLS, shoe, tuple(entries))))
    np.testing.assert_allclose(gain, true.gain)
