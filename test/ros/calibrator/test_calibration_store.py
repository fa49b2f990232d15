from __future__ import annotations

import dataclasses
import errno
import os
import subprocess
import sys
from pathlib import Path

import pytest

from reliability.broken_disk import BrokenDisk
from ros.bodies import calibration, nao, nao_shoe
from shoecal_core.errors import FileError
from shoecal_core.estimation.calibration import (
    Calibration,
    WrongShoeError,
    save_calibration,
)
from shoecal_core.files import read_yaml, write_yaml
from shoecal_ros.calibrator.calibration_store import (
    AHEAD_NS,
    BEFORE,
    CURRENT,
    NEXT,
    RECORD,
    CalibrationStore,
    NotApplicableError,
)
from shoecal_ros.common.origin import Origin

KILLED = Path(__file__).with_name("killed_store.py")


T0 = 10**18
SECOND = 10**9


def store(folder: Path, *, simulated: bool = False) -> CalibrationStore:
    return CalibrationStore(folder, nao(), nao_shoe(), simulated=simulated)


def made(identity: str, **changes: object) -> Calibration:
    return calibration(nao(), nao_shoe(), identity, **changes)


def identity(found: Calibration | None) -> str:
    return "" if found is None else found.id


def test_it_survives_a_restart(tmp_path: Path) -> None:
    folder = tmp_path / "not" / "there"
    first = store(folder)
    assert first.load(T0) is None
    assert first.current is None
    for name in ("one", "two", "three"):
        first.apply(made(name), T0)
    again = store(folder)
    assert again.load(T0) is None
    assert (identity(again.current), identity(again.before)) == ("three", "two")


def test_going_back_and_forth(tmp_path: Path) -> None:
    kept = store(tmp_path)
    with pytest.raises(NotApplicableError, match="no calibration before"):
        kept.one_before()
    kept.apply(made("one"), T0)
    kept.apply(made("two"), T0)
    for name in ("one", "two"):
        kept.apply(kept.one_before()[0], T0)
        assert identity(kept.current) == name
    again = store(tmp_path)
    again.load(T0)
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
    kept.apply(made("one"), T0)
    kept.apply(made("two"), T0)
    (tmp_path / CURRENT).write_text("format: 1\nid: [")
    again = store(tmp_path)
    problem = str(again.load(T0))
    assert CURRENT in problem
    assert again.current is None
    assert identity(again.before) == "one"


@pytest.mark.parametrize(
    ("changes", "reported"),
    [
        ({"shoe_hash": "0" * 64}, "another shoe file"),
        ({"verdict": "FAIL", "reasons": ("blind",)}, "blind"),
        ({"verdict": "WARN", "reasons": ("odd",)}, "set it with force"),
    ],
)
def test_a_file_laid_there_is_taken_only_if_it_might_be_set(
    tmp_path: Path, changes: dict[str, object], reported: str
) -> None:
    save_calibration(made("one", **changes), tmp_path / CURRENT)
    again = store(tmp_path)
    assert reported in str(again.load(T0))
    assert again.current is None
    warned = store(tmp_path)
    assert (warned.load(T0, warned=True) is not None) == (changes.get("verdict") != "WARN")


def test_what_was_accepted_stays_in_force(tmp_path: Path) -> None:
    kept = store(tmp_path)
    kept.apply(made("one", verdict="WARN", reasons=("odd",), shoe_hash="0" * 64), T0)
    kept.apply(made("two", verdict="WARN", reasons=("odd",)), T0)
    again = store(tmp_path)
    assert again.load(T0) is None
    assert (identity(again.current), identity(again.before)) == ("two", "one")
    # Until robot or shoe are others.
    other = CalibrationStore(tmp_path, nao(), dataclasses.replace(nao_shoe(), digest="1" * 64))
    assert str(other.load(T0)).count("another shoe file") == 2
    assert other.current is None


def test_since_when_survives_restarts(tmp_path: Path) -> None:
    kept = store(tmp_path)
    for count, name in enumerate(("one", "two")):
        kept.apply(made(name), T0 + count * SECOND)
        assert kept.since_ns == T0 + count * SECOND
    again = store(tmp_path)
    again.load(T0 + 50 * SECOND)
    assert again.since_ns == T0 + SECOND
    again.apply(again.one_before()[0], T0 + 60 * SECOND)
    assert again.since_ns == T0 + 60 * SECOND
    last = store(tmp_path)
    last.load(T0 + 70 * SECOND)
    assert (identity(last.current), last.since_ns) == ("one", T0 + 60 * SECOND)


def test_since_when_of_a_file_laid_there(tmp_path: Path) -> None:
    save_calibration(made("one"), tmp_path / CURRENT)
    for start in (T0, T0 + SECOND):
        again = store(tmp_path)
        assert again.load(start) is None
        assert again.since_ns == T0


SIMULATED_NS = 500 * SECOND
"""Simulated clocks start at zero."""


def test_a_simulated_calibration_is_refused_on_the_robot(tmp_path: Path) -> None:
    demo = store(tmp_path, simulated=True)
    demo.apply(made("demo", made_ns=SIMULATED_NS), SIMULATED_NS)
    demo.apply(made("next", made_ns=SIMULATED_NS), SIMULATED_NS)
    real = store(tmp_path)
    reported = str(real.load(T0))
    assert reported.count("was made in simulated time") == 2
    assert (real.current, real.before) == (None, None)
    for force in (False, True):
        with pytest.raises(NotApplicableError, match="calibrate on the robot itself"):
            real.check(made("demo", made_ns=SIMULATED_NS), force=force)
    # Said by its origin alone, as a message does.
    with pytest.raises(NotApplicableError, match="on host 'lab' with device 'shoe'"):
        real.check(made("demo"), Origin(simulated=True, host="lab", device="shoe"), force=True)
    # The next run of the demo goes on with its own.
    again = store(tmp_path, simulated=True)
    assert again.load(SIMULATED_NS) is None
    assert identity(again.current) == "next"


def test_a_real_calibration_is_refused_in_simulated_time() -> None:
    demo = store(Path(), simulated=True)
    for force in (False, True):
        with pytest.raises(NotApplicableError, match="calibrate in the simulation"):
            demo.check(made("real"), force=force)
    with pytest.raises(NotApplicableError, match="on host 'lab'"):
        demo.check(made("real", made_ns=SIMULATED_NS), Origin(simulated=False, host="lab"))
    demo.check(made("demo", made_ns=SIMULATED_NS))


def test_a_calibration_of_the_future_is_refused_unless_it_was_accepted(tmp_path: Path) -> None:
    kept = store(tmp_path)
    late = made("late", made_ns=T0 + AHEAD_NS + 1)
    for force in (False, True):
        with pytest.raises(NotApplicableError, match="set the clocks"):
            kept.check(late, force=force, now_ns=T0)
    kept.check(late, now_ns=T0 + 1)
    save_calibration(late, tmp_path / CURRENT)
    assert "set the clocks" in str(kept.load(T0))
    # The clock of a computer without a battery is behind until it is set.
    assert kept.load(T0 + 1) is None
    assert store(tmp_path).load(0) is None


@pytest.mark.parametrize("noted", [True, False])
def test_a_simulation_does_not_displace_a_real_calibration(tmp_path: Path, noted: bool) -> None:
    store(tmp_path).apply(made("real"), T0)
    if not noted:
        (tmp_path / RECORD).unlink()
    demo = store(tmp_path, simulated=True)
    assert "'real' was made in wall-clock time" in str(demo.load(SIMULATED_NS))
    assert demo.current is None
    with pytest.raises(NotApplicableError, match="a state_dir of its own"):
        demo.apply(made("demo", made_ns=SIMULATED_NS), SIMULATED_NS)
    real = store(tmp_path)
    assert real.load(T0) is None
    assert (identity(real.current), real.before) == ("real", None)


def test_the_origin_survives_a_restart_and_comes_back_with_a_rollback(tmp_path: Path) -> None:
    first = Origin(simulated=False, host="one", device="shoe_driver")
    # A robot without a battery for its clock lives in 1970, and is real all the same.
    kept = store(tmp_path)
    kept.apply(made("one", made_ns=SIMULATED_NS), T0, first)
    kept.apply(made("two"), T0)
    again = store(tmp_path)
    assert again.load(T0) is None
    assert again.origin == Origin(simulated=False)
    before, origin = again.one_before()
    assert (before.id, origin) == ("one", first)
    again.apply(before, T0, origin)
    assert again.origin == first


def test_a_record_of_an_older_version_is_read(tmp_path: Path) -> None:
    kept = store(tmp_path)
    kept.apply(made("one", shoe_hash="0" * 64), T0)
    record = tmp_path / RECORD
    old = read_yaml(record)
    (entry,) = old.items("calibrations")
    lines = {key: entry.value(key) for key in entry.keys() if key != "origin"}
    write_yaml(record, {"format": 1, "calibrations": [lines]})
    again = store(tmp_path)
    assert again.load(T0 + SECOND) is None
    assert (again.since_ns, again.origin) == (T0, Origin(simulated=False))


def test_what_is_in_force_already_changes_nothing(tmp_path: Path) -> None:
    kept = store(tmp_path)
    kept.apply(made("one"), T0)
    kept.apply(made("two"), T0 + SECOND)
    kept.apply(made("two"), T0 + 2 * SECOND)
    assert (identity(kept.before), kept.since_ns) == ("one", T0 + SECOND)
    assert sorted(path.name for path in tmp_path.iterdir()) == [CURRENT, BEFORE, RECORD]


def test_a_damaged_record_is_told(tmp_path: Path) -> None:
    kept = store(tmp_path)
    kept.apply(made("one"), T0)
    record = (tmp_path / RECORD).read_text()
    for damaged in (
        "format: 9",
        "format: 1",
        record.replace(str(T0), str(10**30)),
        "[",
        record[:-9],
    ):
        (tmp_path / RECORD).write_text(damaged)
        again = store(tmp_path)
        assert RECORD in str(again.load(T0 + SECOND))
        assert identity(again.current) == "one"


def test_a_file_taken_away_is_no_loss(tmp_path: Path) -> None:
    kept = store(tmp_path)
    kept.apply(made("one"), T0)
    (tmp_path / CURRENT).unlink()
    kept.apply(made("two"), T0)
    again = store(tmp_path)
    again.load(T0)
    assert (identity(again.current), identity(again.before)) == ("two", "one")


def test_killed_at_any_moment_it_is_the_old_pair_or_the_new_one(tmp_path: Path) -> None:
    """A process makes a first, a second, a third change and goes back; each is cut everywhere."""
    done = subprocess.run(
        [sys.executable, KILLED, tmp_path], check=True, capture_output=True, text=True
    )
    cuts = done.stdout.split()
    states = []
    for cut in cuts:
        kept = store(tmp_path / cut)
        assert kept.load(T0 + 99 * SECOND) is None
        since = (kept.since_ns - T0) // SECOND if kept.current else None
        states.append((identity(kept.current), identity(kept.before), since))
        left = {path.name for path in (tmp_path / cut).iterdir() if path.name[0] != "."}
        assert left <= {CURRENT, BEFORE, RECORD}
    steps = [("", "", None), ("one", "", 1), ("two", "one", 2), ("three", "two", 3),
             ("two", "three", 4)]  # fmt: skip
    assert states[0] == steps[0]
    assert states[-1] == steps[-1]
    assert len(cuts) > 20
    # Every state on the way is one of them, in this order, without a step back.
    assert [steps.index(state) for state in states] == sorted(
        steps.index(state) for state in states
    )
    assert set(states) == set(steps)


@pytest.mark.parametrize("left", [NEXT, CURRENT, BEFORE, RECORD])
def test_what_cannot_be_dealt_with_is_told_and_the_rest_taken(
    tmp_path: Path, left: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A read-only disk on which a change was cut; files that nobody may look at."""
    kept = store(tmp_path)
    kept.apply(made("one"), T0)
    kept.apply(made("two"), T0)
    save_calibration(made("three"), tmp_path / NEXT)
    denied = "unlink" if left == NEXT else "is_file"
    original = getattr(Path, denied)

    def refuse(path: Path, *rest: object, **more: object) -> object:
        if path.name == left:
            raise PermissionError(errno.EACCES, os.strerror(errno.EACCES), str(path))
        return original(path, *rest, **more)

    monkeypatch.setattr(Path, denied, refuse)
    again = store(tmp_path)
    assert left in str(again.load(T0))
    assert identity(again.current) == ("" if left == CURRENT else "two")
    assert identity(again.before) == ("" if left == BEFORE else "one")


def test_what_is_saved_is_in_force_once_it_is_taken(tmp_path: Path) -> None:
    kept = store(tmp_path)
    kept.apply(made("one"), T0)
    assert kept.save(made("two"), T0 + SECOND)
    assert (identity(kept.current), kept.before, kept.since_ns) == ("one", None, T0)
    kept.take(made("two"), T0 + SECOND)
    assert (identity(kept.current), identity(kept.before)) == ("two", "one")
    assert kept.since_ns == T0 + SECOND
    assert not kept.save(made("two"), T0 + 2 * SECOND), "in force already"


def test_nothing_changes_where_nothing_can_be_saved(tmp_path: Path) -> None:
    kept = store(tmp_path / "folder")
    kept.apply(made("one"), T0)
    (tmp_path / "folder" / BEFORE).unlink(missing_ok=True)
    (tmp_path / "folder").rename(tmp_path / "moved")
    (tmp_path / "folder").write_text("in the way")
    with pytest.raises(FileError):
        kept.apply(made("two"), T0)
    assert identity(kept.current) == "one"


def forced(identity: str) -> Calibration:
    """One that is taken only with force: at the next start by the record alone."""
    return made(identity, shoe_hash="0" * 64)


def states(kept: CalibrationStore, folder: Path) -> list[tuple[str, str, int]]:
    """In force, before it and since when: in memory, and as the next start would find it."""
    again = store(folder)
    assert again.load(T0 + 99 * SECOND) is None
    return [(identity(one.current), identity(one.before), one.since_ns) for one in (kept, again)]


@pytest.mark.parametrize("lasting", [False, True])
@pytest.mark.parametrize("kind", ["fsync", "replace", "unlink", "open"])
@pytest.mark.parametrize("changes", [0, 1, 2])
def test_whatever_the_disk_refuses_it_is_the_old_pair_or_the_new_one(
    tmp_path: Path, changes: int, kind: str, lasting: bool
) -> None:
    """Refused and the old pair here and at the next start, or taken here and there."""
    names = ["one", "two"][:changes]
    at, struck = 0, True
    while struck:
        at += 1
        folder = tmp_path / f"{at}"
        kept = store(folder)
        kept.load(T0)
        for count, name in enumerate(names):
            kept.apply(forced(name), T0 + count)
        (old,) = set(states(kept, folder))
        reported = ""
        with BrokenDisk(kind, at, lasting=lasting) as disk:
            try:
                kept.apply(forced("new"), T0 + SECOND)
            except FileError as error:
                reported = str(error)
        struck = disk.struck
        taken = ("new", old[0], T0 + SECOND)
        assert states(kept, folder) == 2 * [old if reported else taken]
        assert str(folder) in reported or not reported
        # And with the disk mended it goes on.
        kept.apply(forced("last"), T0 + 2 * SECOND)
        last = ("last", old[0] if reported else "new", T0 + 2 * SECOND)
        assert states(kept, folder) == 2 * [last]
        files = {path.name for path in folder.iterdir() if path.name[0] != "."}
        assert files <= {CURRENT, BEFORE, RECORD}
    assert at > 1 or kind == "unlink"
    assert reported == ""


def test_what_cannot_be_taken_back_is_told(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The disk breaks for good just after the rename that is the change."""
    kept = store(tmp_path)
    kept.apply(made("one"), T0)

    def refuse(*_: object) -> None:
        raise OSError(errno.EIO, os.strerror(errno.EIO))

    def broken(path: Path) -> None:
        if path.name == CURRENT and not (tmp_path / NEXT).exists():
            monkeypatch.setattr(os, "replace", refuse)
            raise FileError(path, "may not outlast a power cut")

    monkeypatch.setattr("shoecal_ros.calibrator.calibration_store.sync_folder", broken)
    with pytest.raises(FileError, match=r"not in force.* before the next start"):
        kept.apply(made("two"), T0 + SECOND)
    assert identity(kept.current) == "one"
    # Mended and set again, all is as it should be.
    monkeypatch.undo()
    kept.apply(made("two"), T0 + 2 * SECOND)
    assert states(kept, tmp_path) == 2 * [("two", "one", T0 + 2 * SECOND)]
