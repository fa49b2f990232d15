"""What was found is read as it was written."""

from __future__ import annotations

from pathlib import Path

import pytest

from shoecal_core.errors import FieldError, VersionError
from shoecal_core.files import atomic_write
from shoecal_core.robot.randomisation import UNITS, Parameter, Randomisation, load_randomisation

FOUND = Randomisation(
    "wren", tuple(Parameter(kind, f"at_{kind}", 1e-5 / 3.0, 0.02 / 7.0) for kind in UNITS)
)


def test_it_is_read_as_it_was_written(tmp_path: Path) -> None:
    file = tmp_path / "randomisation.yaml"
    atomic_write(file, FOUND.text())
    assert load_randomisation(file) == FOUND
    assert FOUND.of("mass") == {"at_mass": FOUND.parameters[1]}


@pytest.mark.parametrize(
    ("old", "new", "field"),
    [
        ("unit: kg", "unit: g", "parameters[1].unit"),
        ("kind: mass", "kind: weight", "parameters[1].kind"),
        ("at: at_mass", "at: at_mass, gain: 1", "parameters[1].gain"),
        ("kind: com_y, at: at_com_y", "kind: com_x, at: at_com_x", "at"),
    ],
)
def test_what_is_wrong_is_named(tmp_path: Path, old: str, new: str, field: str) -> None:
    file = tmp_path / "randomisation.yaml"
    assert old in FOUND.text()
    file.write_text(FOUND.text().replace(old, new))
    with pytest.raises(FieldError) as raised:
        load_randomisation(file)
    assert raised.value.field == field


def test_a_newer_file_is_refused(tmp_path: Path) -> None:
    file = tmp_path / "randomisation.yaml"
    file.write_text(FOUND.text().replace("format: 1", "format: 2"))
    with pytest.raises(VersionError):
        load_randomisation(file)
