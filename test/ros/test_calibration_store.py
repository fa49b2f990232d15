from __future__ import annotations

from pathlib import Path

import pytest

from ros.bodies import calibration, nao, nao_shoe
from shoecal_core.calibration.calibration import Calibration, WrongShoeError
from shoecal_core.errors import FileError
from shoecal_ros.calibration_store import BEFORE, CURRENT, CalibrationStore, NotApplicableError


def store(folder: Path) -> CalibrationStore:
    return CalibrationStore(folder, nao(), nao_shoe())


def made(identity: str, **changes: object) -> Calibration:
    return calibration(nao(), nao_shoe(), identity, **changes)


def identity(found: Calibration | None) -> str:
    return "" if found is None else found.id


def test_it_survives_a_restart(tmp_path: Path) -> None:
    folder = tmp_path / "not" / "there"
    first = store(folder)
    assert first.load() == ""
    assert first.current is None
    for name in ("one", "two", "three"):
        first.apply(made(name))
    again = store(folder)
    assert again.load() == ""
    assert (identity(again.current), identity(again.before)) == ("three", "two")


def test_going_back_and_forth(tmp_path: Path) -> None:
    kept = store(tmp_path)
    with pytest.raises(NotApplicableError, match="no calibration before"):
        kept.rollback()
    kept.apply(made("one"))
    kept.apply(made("two"))
    assert kept.rollback().id == "one"
    assert kept.rollback().id == "two"
    again = store(tmp_path)
    again.load()
    assert (identity(again.current), identity(again.before)) == ("two", "one")


def test_a_failed_calibration_is_never_applied() -> None:
    failed = made("bad", verdict="FAIL", reasons=("left/a is blind",))
    for force in (False, True):
        with pytest.raises(NotApplicableError, match="left/a is blind"):
            store(Path()).check(failed, force=force)


@pytest.mark.parametrize("which", ["robot", "shoe"])
def test_another_robots_or_shoes_calibration_needs_force(which: str) -> None:
    other = made("other", **{f"{which}_hash": "0" * 64})
    with pytest.raises(NotApplicableError, match=f"another {which} file"):
        store(Path()).check(other)
    store(Path()).check(other, force=True)


def test_other_channels_are_never_applied() -> None:
    names = tuple(name.replace("left", "up") for name in nao_shoe().names)
    with pytest.raises(WrongShoeError):
        store(Path()).check(made("other", channels=names), force=True)


def test_a_damaged_file_is_told_and_not_taken(tmp_path: Path) -> None:
    kept = store(tmp_path)
    kept.apply(made("one"))
    kept.apply(made("two"))
    (tmp_path / CURRENT).write_text("format: 1\nid: [")
    again = store(tmp_path)
    problem = again.load()
    assert CURRENT in problem
    assert again.current is None
    assert identity(again.before) == "one"


def test_a_file_of_other_shoes_is_told_and_not_taken(tmp_path: Path) -> None:
    kept = store(tmp_path)
    kept.apply(made("one", shoe_hash="0" * 64))
    again = store(tmp_path)
    assert "another shoe file" in again.load()
    assert again.current is None


def test_nothing_changes_where_nothing_can_be_saved(tmp_path: Path) -> None:
    kept = store(tmp_path / "folder")
    kept.apply(made("one"))
    (tmp_path / "folder" / BEFORE).unlink(missing_ok=True)
    (tmp_path / "folder").rename(tmp_path / "moved")
    (tmp_path / "folder").write_text("in the way")
    with pytest.raises(FileError):
        kept.apply(made("two"))
    assert identity(kept.current) == "one"
