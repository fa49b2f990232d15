from __future__ import annotations

from pathlib import Path

import pytest

from core.manual.benches import ROOT
from core.shoe import mutations
from shoecal_core.manual.loads import CELLS, SHOE
from shoecal_core.manual.settings import load_manual_settings

FILE = ROOT / "config" / "manual.yaml"


def test_the_papers_weights() -> None:
    settings = load_manual_settings(FILE)
    assert settings.weights(SHOE) == (1.0, 1.5, 2.0, 2.5, 3.0, 3.5, 4.0)
    assert settings.weights(CELLS) == settings.cell_weights
    assert settings.patience >= settings.samples


BAD: dict[str, tuple[str, object, str]] = {
    "grams": ("shoe_weights_kg", [1000, 1500], "looks like grams"),
    "no weights": ("cell_weights_kg", [], "above 0 kg"),
    "a weight of zero": ("cell_weights_kg", [0, 1], "above 0 kg"),
    "weights in no order": ("shoe_weights_kg", [2, 1], "larger than the one before"),
    "one weight": ("shoe_weights_kg", 2, "expected n numbers"),
    "one sample": ("samples", 1, "at least 2"),
    "half a sample": ("samples", 1.5, "whole number"),
    "never still": ("still_fraction", 0, "above 0"),
    "no patience": ("patience_samples", 10, "at least 50"),
    "a typing error": ("sample", 10, "unknown key"),
}


@pytest.mark.parametrize("name", BAD)
def test_each_fault_is_one_error_that_names_its_field(name: str, tmp_path: Path) -> None:
    field, value, problem = BAD[name]
    path = tmp_path / "manual.yaml"
    mutations.write_edited(path, FILE, ((field,), value))
    error = mutations.refused(path, lambda: load_manual_settings(path))
    assert error.field == field
    assert problem in error.problem
