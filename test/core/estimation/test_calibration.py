"""A calibration as a value and as a file: whole, bit for bit, or not at all."""

from __future__ import annotations

import math
import tempfile
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from core.shoe import mutations, shoes
from core.shoe.mutations import DELETE, Key
from shoecal_core.arrays import FloatArray
from shoecal_core.errors import FileError, ShapeError, ShoecalError, VersionError
from shoecal_core.estimation.calibration import (
    Calibration,
    WrongShoeError,
    load_calibration,
    save_calibration,
)
from shoecal_core.files import read_yaml
from shoecal_core.shoe.correction import CopCorrection
from shoecal_core.shoe.shoe import Shoe
from shoecal_core.shoe.wrench import ChannelParameters

finite = st.floats(allow_nan=False, allow_infinity=False)
nonzero = finite.filter(bool)


def calibration(shoe: Shoe, rng: np.random.Generator) -> Calibration:
    """A full one, with awkward numbers."""
    count = len(shoe.channels)
    root = rng.normal(size=(2 * count, 2 * count))
    corrections = []
    for foot in (0, 1):
        own = len(shoe.of_foot(foot))
        x, y = rng.normal(size=4 + own) / 3.0, rng.normal(size=4 + own) * 1e-9
        places = np.array([[-0.05, -0.03], [0.1, 0.03]])
        corrections.append(CopCorrection(foot, x, y, places, rng.normal(size=(2, own))))
    return Calibration(
        id="self-0123456789ab",
        source="self",
        made_ns=1_795_000_000_123_456_789,
        robot="nao",
        shoe=shoe.name,
        robot_hash="12e5" * 16,
        shoe_hash=shoe.digest,
        channels=shoe.names,
        parameters=ChannelParameters(rng.normal(size=count) * 25.0, rng.normal(size=count) / 7.0),
        covariance=root @ root.T,
        corrections=tuple(corrections),
        weight=53.888,
        time_offset=-1.25e-3,
        temperature=24.5,
        verdict="WARN",
        reasons=("WARN: one thing: another", "5 % off\nand more", ""),
        fitted_runs=("0" * 64, "12e5" * 16),
    )


@pytest.fixture
def whole(shoe: Shoe, rng: np.random.Generator) -> Calibration:
    return calibration(shoe, rng)


def same(one: object, other: object) -> bool:
    """Equality, bit for bit, of values that may hold arrays."""
    if isinstance(one, np.ndarray):
        return isinstance(other, np.ndarray) and one.tobytes() == other.tobytes()
    if isinstance(one, tuple) and isinstance(other, tuple):
        return len(one) == len(other) and all(map(same, one, other))
    if isinstance(one, float) and isinstance(other, float):
        return one == other or (math.isnan(one) and math.isnan(other))
    if hasattr(one, "__dataclass_fields__"):
        return type(one) is type(other) and all(
            same(getattr(one, name), getattr(other, name)) for name in one.__dataclass_fields__
        )
    return one == other


# ---- round trips ------------------------------------------------------------------------------


def test_there_and_back(whole: Calibration, tmp_path: Path) -> None:
    path = tmp_path / "calibration.yaml"
    save_calibration(whole, path)
    assert same(load_calibration(path), whole)


def test_there_and_back_with_as_little_as_possible(whole: Calibration, tmp_path: Path) -> None:
    little = replace(
        whole, covariance=None, corrections=(), temperature=math.nan, reasons=(), fitted_runs=()
    )
    path = tmp_path / "calibration.yaml"
    save_calibration(little, path)
    assert same(load_calibration(path), little)


def test_calibrated_columns(whole: Calibration, shoe: Shoe, tmp_path: Path) -> None:
    """They go into the file and into what is measured; without them the file is an older one."""
    path = tmp_path / "calibration.yaml"
    save_calibration(whole, path)
    assert read_yaml(path).integer("format") == 1
    columns = shoe.columns + 0.001 * np.arange(shoe.columns.size).reshape(-1, 3)
    moved = replace(whole, columns=columns, corrections=())
    save_calibration(moved, path)
    assert read_yaml(path).integer("format") == 2
    assert same(load_calibration(path), moved)
    np.testing.assert_array_equal(moved.sensing(shoe).shoe.columns, columns)
    np.testing.assert_array_equal(whole.sensing(shoe).shoe.columns, shoe.columns)
    for wrong in (columns[1:], np.full_like(columns, np.nan)):
        with pytest.raises(ShoecalError, match="columns"):
            replace(whole, columns=wrong)


def test_errors_of_columns_and_supports(whole: Calibration, shoe: Shoe, tmp_path: Path) -> None:
    """They come back; who does not know them reads a file without them."""
    path, count = tmp_path / "calibration.yaml", len(shoe.names)
    rng = np.random.default_rng(8)
    root = rng.normal(size=(5 * count, 5 * count))
    joint = root @ root.T
    full = replace(
        whole,
        covariance=joint[: 2 * count, : 2 * count],
        columns=shoe.columns,
        column_covariance=joint[2 * count :],
        support_covariance=np.diag(rng.uniform(size=3)),
    )
    save_calibration(full, path)
    assert read_yaml(path).integer("format") == 3
    assert same(load_calibration(path), full)
    found = full.joint_covariance
    assert found is not None
    np.testing.assert_array_equal(found, joint)
    assert whole.joint_covariance is not None
    assert not whole.joint_covariance[2 * count :].any()
    for wrong in (joint, np.full_like(joint[2 * count :], np.nan)):
        with pytest.raises(ShoecalError, match="column covariance"):
            replace(full, column_covariance=wrong)
    for wrong in (np.eye(2), np.full((3, 3), np.nan)):
        with pytest.raises(ShoecalError, match="support covariance"):
            replace(full, support_covariance=wrong)
    with pytest.raises(ShoecalError, match="need the covariance"):
        replace(full, covariance=None)


@given(st.data())
@settings(max_examples=20)
def test_every_number_and_text_survives_bit_for_bit(data: st.DataObject) -> None:
    shoe = shoes.shoe("nao_shoe")
    base = calibration(shoe, np.random.default_rng(0))

    def numbers(*shape: int) -> FloatArray:
        return data.draw(arrays(np.float64, shape, elements=finite))

    foot = CopCorrection(1, numbers(8), numbers(8), numbers(2, 2), numbers(2, 4))
    one = replace(
        base,
        parameters=ChannelParameters(
            data.draw(arrays(np.float64, 8, elements=nonzero)), numbers(8)
        ),
        corrections=(foot,),
        weight=data.draw(st.floats(1e-300, 1e300)),
        time_offset=data.draw(finite),
        temperature=data.draw(st.one_of(finite, st.just(math.nan))),
        id=data.draw(st.text()),
        robot=data.draw(st.text()),
        reasons=tuple(data.draw(st.lists(st.text(), max_size=3))),
        made_ns=data.draw(st.integers(0, 2**63)),
    )
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "calibration.yaml"
        save_calibration(one, path)
        assert same(load_calibration(path), one)


def test_saving_over_an_older_one_replaces_it_whole(whole: Calibration, tmp_path: Path) -> None:
    path = tmp_path / "calibration.yaml"
    save_calibration(whole, path)
    newer = replace(whole, id="self-newer", corrections=())
    save_calibration(newer, path)
    assert same(load_calibration(path), newer)
    assert list(tmp_path.iterdir()) == [path]


# ---- use --------------------------------------------------------------------------------------


def test_it_measures_with_its_parameters_and_corrections(whole: Calibration, shoe: Shoe) -> None:
    sensing = whole.sensing(shoe)
    assert sensing.shoe is shoe
    assert sensing.parameters is whole.parameters
    assert sensing.corrections == whole.corrections


def test_another_shoe_is_refused(whole: Calibration, shoe: Shoe) -> None:
    other = shoes.shoe("odd_shoe" if shoe.name == "nao_shoe" else "nao_shoe")
    with pytest.raises(WrongShoeError, match=f"of shoe '{shoe.name}'.*but shoe '{other.name}'"):
        whole.sensing(other)
    turned = replace(shoe, channels=shoe.channels[::-1])
    with pytest.raises(WrongShoeError):
        whole.sensing(turned)


def test_a_correction_of_another_foot_s_width_is_refused(whole: Calibration, shoe: Shoe) -> None:
    narrow = CopCorrection(0, np.zeros(6), np.zeros(6), np.zeros((2, 2)), np.zeros((2, 2)))
    with pytest.raises(ShapeError, match="correction of the left foot"):
        replace(whole, corrections=(narrow,)).sensing(shoe)
    with pytest.raises(ShoecalError, match="left foot has two"):
        replace(whole, corrections=whole.corrections[:1] * 2).sensing(shoe)


IMPOSSIBLE: dict[str, tuple[object, str]] = {
    "parameters": (ChannelParameters(np.ones(2), np.zeros(2)), "gain"),
    "channels": (("a", "b"), "gain"),
    "covariance": (np.eye(3), "covariance"),
    "verdict": ("FINE", "'FINE' is not one of PASS, WARN, FAIL"),
    "weight": (0.0, "must be a positive number"),
    "time_offset": (math.nan, "time offset"),
    "temperature": (math.inf, "temperature"),
}


@pytest.mark.parametrize("name", IMPOSSIBLE)
def test_impossible_values_are_refused(whole: Calibration, name: str) -> None:
    value, problem = IMPOSSIBLE[name]
    with pytest.raises(ShoecalError, match=problem):
        replace(whole, **{name: value})  # type: ignore[arg-type]


def test_blind_cells_double_names_and_nan_covariances_are_refused(whole: Calibration) -> None:
    count = len(whole.channels)
    blind = ChannelParameters(np.r_[0.0, np.ones(count - 1)], np.zeros(count))
    with pytest.raises(ShoecalError, match="gain of zero"):
        replace(whole, parameters=blind)
    with pytest.raises(ShoecalError, match="appears twice"):
        replace(whole, channels=(whole.channels[0],) * count)
    spoilt = np.full((2 * count, 2 * count), np.nan)
    with pytest.raises(ShoecalError, match="covariance holds a number"):
        replace(whole, covariance=spoilt)
    for weight in (-1.0, math.nan, math.inf):
        with pytest.raises(ShoecalError, match="positive number"):
            replace(whole, weight=weight)


# ---- bad files --------------------------------------------------------------------------------

GAIN: tuple[Key, ...] = ("channels", 2, "gain")
FIRST: tuple[Key, ...] = ("corrections", 0)
BAD: dict[str, tuple[tuple[Key, ...], object, str, str]] = {
    "no format": (("format",), DELETE, "format", "is missing"),
    "no name": (("id",), DELETE, "id", "is missing"),
    "a stray key": (("colour",), 1, "colour", "unknown key"),
    "a misspelt covariance": (("covarience",), None, "covarience", "unknown key"),
    "a time before time": (("made_ns",), -1, "made_ns", "at least 0"),
    "a time of text": (("made_ns",), "now", "made_ns", "whole number"),
    "no weight": (("weight_n",), 0, "weight_n", "above 0"),
    "no time offset": (("time_offset_s",), DELETE, "time_offset_s", "is missing"),
    "a temperature of text": (("temperature_degc",), "warm", "temperature_degc", "number"),
    "no verdict": (("verdict",), DELETE, "verdict", "is missing"),
    "another verdict": (("verdict",), "MAYBE", "verdict", "one of: PASS, WARN, FAIL"),
    "a reason that is a number": (("reasons",), [1], "reasons", "list of names"),
    "no channels": (("channels",), [], "channels", "is empty"),
    "channels of numbers": (("channels",), [1, 2], "channels[0]", "mapping"),
    "a channel without a name": (("channels", 2, "name"), DELETE, "channels[2].name", "missing"),
    "a gain that is none": (GAIN, math.nan, "channels[2].gain", "finite"),
    "a gain without end": (GAIN, math.inf, "channels[2].gain", "finite"),
    "a gain of text": (GAIN, "big", "channels[2].gain", "expected a number"),
    "a gain of zero": (GAIN, 0.0, "", "gain of zero"),
    "a channel twice": (("channels", 2, "name"), "left/0", "", "appears twice"),
    "an offset in kilograms": (
        ("channels", 2, "offset_kg"), 1.0, "channels[2].offset_kg", "unknown key"
    ),
    "a channel too few": (("channels",), lambda c: c[:-1], "covariance", "numbers, got shape"),
    "a covariance of another size": (("covariance",), [[1.0]], "covariance", "got shape (1, 1)"),
    "a covariance with a hole": (("covariance", 0, 0), math.nan, "covariance", "finite"),
    "no corrections": (("corrections",), DELETE, "corrections", "is missing"),
    "a correction of no foot": ((*FIRST, "foot"), "tail", "corrections[0].foot", "one of"),
    "a correction of nothing": ((*FIRST, "x"), [], "corrections[0].x", "needs 4 numbers"),
    "a correction with a stray key": ((*FIRST, "z"), 1, "corrections[0].z", "unknown key"),
    "a correction of two widths": ((*FIRST, "y"), [1.0], "corrections[0].y", "numbers, got"),
    "a correction with a hole": ((*FIRST, "x", 1), math.nan, "corrections[0].x", "finite"),
    "a correction without its range": (
        (*FIRST, "cop_range_m"), DELETE, "corrections[0].cop_range_m", "is missing"
    ),
    "a correction of another range": (
        (*FIRST, "output_range_n"), [[0.0], [1.0]], "corrections[0].output_range_n", "2 x"
    ),
}  # fmt: skip


@pytest.mark.parametrize("name", BAD)
def test_each_fault_is_one_error_that_names_its_field(name: str, tmp_path: Path) -> None:
    place, value, field, problem = BAD[name]
    good, path = tmp_path / "good.yaml", tmp_path / "bad.yaml"
    one = calibration(shoes.shoe("nao_shoe"), np.random.default_rng(0))
    names = tuple(f"left/{index}" for index in range(8))
    save_calibration(replace(one, channels=names), good)
    mutations.write_edited(path, good, (place, value))
    error = mutations.refused(path, lambda: load_calibration(path))
    assert error.field == field
    assert problem in error.problem


def test_a_newer_format_is_refused(whole: Calibration, tmp_path: Path) -> None:
    path = tmp_path / "calibration.yaml"
    save_calibration(whole, path)
    mutations.write_edited(path, path, (("format",), 4))
    with pytest.raises(VersionError, match="update shoecal"):
        load_calibration(path)


@pytest.mark.parametrize("full", [True, False])
def test_a_file_that_lost_its_end_is_refused(
    whole: Calibration, tmp_path: Path, *, full: bool
) -> None:
    """Wherever it was cut, or it is still the same calibration."""
    one = whole if full else replace(whole, covariance=None, corrections=())
    good, path = tmp_path / "good.yaml", tmp_path / "cut.yaml"
    save_calibration(one, good)
    content = good.read_bytes()
    lines = [at for at, byte in enumerate(content) if byte == ord("\n")]
    cuts = {*range(0, len(content), 997), *range(len(content) - 12, len(content)), *lines[::15]}
    ends = [at + 1 for at in lines[-5:]]
    for cut in sorted({*cuts, *ends}):
        path.write_bytes(content[:cut])
        if content[:cut].rstrip() == content.rstrip():
            assert same(load_calibration(path), one)
        else:
            with pytest.raises(FileError):
                load_calibration(path)


@given(st.data())
@settings(max_examples=40)
def test_whatever_happens_to_the_text(data: st.DataObject) -> None:
    shoe = shoes.shoe("odd_shoe")
    one = replace(calibration(shoe, np.random.default_rng(0)), covariance=None)
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "calibration.yaml"
        save_calibration(one, path)
        path.write_text(data.draw(mutations.mutated(path.read_text())), encoding="utf-8")
        try:
            sensing = load_calibration(path).sensing(shoe)
        except ShoecalError:
            return
    sensing.measure(np.ones((3, len(shoe.channels))))
