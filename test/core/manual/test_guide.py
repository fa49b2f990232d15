from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from core.manual.benches import (
    SETTINGS,
    nao,
    nao_shoe,
    read_cells,
    read_shoe,
    some_law,
)
from shoecal_core.manual.calibrate import calibrate_cells
from shoecal_core.manual.guide import Check, Guide, GuidePhase, Key, cell_check, shoe_check
from shoecal_core.manual.loads import CELLS, SHOE, Load, planned_loads
from shoecal_core.manual.measurements import LoadReading, Measurements
from shoecal_core.manual.still import StillState

SHOE_FILE = nao_shoe()
WHOLE = {
    SHOE: read_shoe(SHOE_FILE, some_law(SHOE_FILE), (1.0, 2.0)),
    CELLS: read_cells(SHOE_FILE, some_law(SHOE_FILE), (2.0,)),
}
PLAN = planned_loads(SHOE, SHOE_FILE, (1.0, 2.0))


def accept(measurements: Measurements, entry: LoadReading) -> str:
    return ""


def begin(done: int = 0, kind: str = SHOE, check: Check = accept) -> Guide:
    """A guide through a plan whose first loads have been read."""
    whole = WHOLE[kind]
    plan = tuple(entry.load for entry in whole.entries)
    return Guide(plan, Measurements(kind, SHOE_FILE, whole.entries[:done]), SETTINGS, check)


def show(guide: Guide, load: Load | None = None, samples: int = SETTINGS.samples) -> None:
    """Samples as they are under a load: the one that is asked for, if none is given."""
    wanted = guide.load if load is None else load
    entry = next(one for one in WHOLE[guide.measurements.kind].entries if one.load == wanted)
    readings = np.zeros(len(SHOE_FILE.names))
    readings[SHOE_FILE.of_foot(wanted.foot)] = entry.mean
    for _ in range(samples):
        guide.take(readings, 7)


def read(guide: Guide, load: Load | None = None) -> None:
    """Say that the weight stands there, and let it be read."""
    guide.press(Key.READ)
    show(guide, load)


def test_from_the_first_load_to_the_last() -> None:
    guide = begin()
    asked = []
    while guide.phase is not GuidePhase.COMPLETE:
        asked.append(guide.load)
        assert guide.number == len(asked)
        read(guide)
    assert tuple(asked) == PLAN
    assert guide.pending == 0
    for entry, true in zip(guide.measurements.entries, WHOLE[SHOE].entries, strict=True):
        assert (entry.load, entry.count, entry.made_ns) == (true.load, SETTINGS.samples, 7)
        np.testing.assert_allclose(entry.mean, true.mean)


def test_readings_count_only_after_the_key() -> None:
    guide = begin()
    show(guide, samples=50)
    assert not guide.measurements.entries
    guide.press(Key.READ)
    show(guide, samples=SETTINGS.samples - 1)
    assert guide.phase is GuidePhase.READING
    assert guide.gathered == SETTINGS.samples - 1
    show(guide, samples=1)
    assert guide.number == 2


def test_what_moves_is_asked_for_again() -> None:
    guide = begin(3)
    load = guide.load
    guide.press(Key.READ)
    for index in range(SETTINGS.patience):
        guide.take(np.full(8, 0.1 * (index % 2)), 7)
    assert guide.phase is GuidePhase.ASKING
    assert guide.news() == StillState.MOVED.value
    assert guide.news() == ""
    assert guide.load == load
    assert len(guide.measurements.entries) == 3


def test_a_session_goes_on_where_the_one_before_stopped() -> None:
    guide = begin(5)
    assert guide.load == PLAN[5]
    assert guide.pending == len(PLAN) - 5
    guide.press(Key.STOP)
    assert guide.phase is GuidePhase.STOPPED
    guide.press(Key.READ)
    show(guide, PLAN[5])
    assert guide.phase is GuidePhase.STOPPED
    assert begin(len(PLAN)).phase is GuidePhase.COMPLETE


def test_a_session_goes_on_in_the_gap_that_was_left() -> None:
    entries = WHOLE[SHOE].entries
    held = Measurements(SHOE, SHOE_FILE, (*entries[:4], *entries[6:]))
    guide = Guide(PLAN, held, SETTINGS, accept)
    assert (guide.load, guide.pending) == (PLAN[4], 2)


def test_the_last_one_again() -> None:
    guide = begin()
    guide.press(Key.REPEAT)
    assert guide.number == 1
    for _ in range(3):
        read(guide)
    guide.press(Key.REPEAT)
    assert guide.load == PLAN[2]
    # It may stand there still; its new reading takes the place of the old one.
    before = guide.measurements.entries[2]
    read(guide)
    assert len(guide.measurements.entries) == 3
    assert guide.measurements.entries[2] is not before
    assert guide.load == PLAN[3]


def test_back_and_on_again() -> None:
    guide = begin(3)
    guide.press(Key.BACK)
    guide.press(Key.BACK)
    assert guide.load == PLAN[1]
    read(guide)
    assert len(guide.measurements.entries) == 3
    assert guide.load == PLAN[3]
    for _ in range(10):
        guide.press(Key.BACK)
    assert guide.number == 1


def test_skipped_loads_are_left_for_another_time() -> None:
    guide = begin(len(PLAN) - 3)
    guide.press(Key.SKIP)
    assert guide.news() == "skipped"
    assert guide.load == PLAN[-2]
    read(guide)
    read(guide)
    assert guide.phase is GuidePhase.COMPLETE
    assert guide.pending == 1
    again = Guide(PLAN, guide.measurements, SETTINGS, accept)
    assert again.load == PLAN[-3]


def test_a_key_in_the_middle_of_a_reading_breaks_it_off() -> None:
    for key in (Key.BACK, Key.SKIP, Key.REPEAT, Key.STOP):
        guide = begin(3)
        guide.press(Key.READ)
        show(guide, samples=2)
        guide.press(key)
        if key is not Key.REPEAT:  # nothing was read in this session yet
            assert guide.phase is not GuidePhase.READING
            show(guide, PLAN[3], samples=50)
        assert len(guide.measurements.entries) == 3


def test_a_second_enter_changes_nothing() -> None:
    guide = begin()
    guide.press(Key.READ)
    show(guide, samples=3)
    guide.press(Key.READ)
    show(guide, samples=2)
    assert guide.number == 2


@given(st.lists(st.sampled_from([*Key, "samples", "restless"]), max_size=80))
def test_whatever_is_pressed_nothing_read_is_lost(acts: list[Key | str]) -> None:
    guide = begin(2)
    loads = guide.measurements.loads
    for act in acts:
        if guide.phase in {GuidePhase.COMPLETE, GuidePhase.STOPPED}:
            break
        if isinstance(act, Key):
            guide.press(act)
        elif act == "samples":
            show(guide)
        else:
            guide.take(np.full(8, np.nan), 0)
        assert loads <= guide.measurements.loads
        loads = guide.measurements.loads
        assert guide.load in PLAN
        assert guide.pending == len(PLAN) - len(loads)


# ---- checks while the weight still stands there -------------------------------------------------


def shoe_guide(done: int) -> Guide:
    cells = calibrate_cells(SHOE_FILE, nao(), WHOLE[CELLS]).calibration
    return begin(done, SHOE, shoe_check(cells))


def test_another_weight_is_noticed_at_once() -> None:
    guide = shoe_guide(1)
    read(guide, Load(0, "a1", 2.0))
    assert "left shoe, 1 kg in hole a1: weighs 2.00 kg" in guide.news()
    assert guide.load == PLAN[1]
    read(guide)
    assert guide.news() == ""
    assert guide.load == PLAN[2]


def test_a_bare_shoe_has_nothing_to_compare_with() -> None:
    guide = shoe_guide(0)
    guide.press(Key.SKIP)
    read(guide)
    assert len(guide.measurements.entries) == 1


def test_the_end_of_the_range_is_noticed_at_once() -> None:
    guide = begin(1)
    guide.press(Key.READ)
    for _ in range(SETTINGS.samples):
        guide.take(np.array([5.0, 0, 0, 0, 0, 0, 0, 0]), 0)
    assert "left/front_left is at the end of its range" in guide.news()
    assert len(guide.measurements.entries) == 1


@pytest.mark.parametrize(
    ("stood", "problem"),
    [
        (Load(0, "left/front_left", 2.0), ""),
        (Load(0, "left/rear_left", 2.0), "left/rear_left responded to the weight on"),
    ],
)
def test_a_weight_on_another_cell_is_noticed_at_once(stood: Load, problem: str) -> None:
    guide = begin(1, CELLS, cell_check)
    assert guide.load == Load(0, "left/front_left", 2.0)
    before = guide.measurements
    _read_beside(guide, stood)
    said = guide.news()
    assert problem in said
    assert (guide.measurements is before) == bool(problem)


def _read_beside(guide: Guide, stood: Load) -> None:
    """The cell asked for changes a little in any case: the others hang on one plate with it."""
    guide.press(Key.READ)
    entry = next(one for one in WHOLE[CELLS].entries if one.load == stood)
    readings = np.zeros(8)
    readings[:4] = entry.mean
    readings[0] += 0.05
    for _ in range(SETTINGS.samples):
        guide.take(readings, 0)


@pytest.mark.parametrize("done", [0, 1])
def test_a_dead_cell_is_noticed_at_once(done: int) -> None:
    guide = begin(done, CELLS, cell_check)
    bare = guide.plan[0]
    if not done:
        read(guide)
    guide.press(Key.READ)
    show(guide, bare, SETTINGS.patience)
    said = (
        StillState.UNCHANGED.value,
        "left/front_left does not respond to 2 kg; check its wiring",
    )
    assert guide.news() == said[done]
    assert guide.number == 2
