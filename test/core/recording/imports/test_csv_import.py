from __future__ import annotations

import os
import re
from pathlib import Path

import numpy as np
import pytest
import yaml
from scipy.spatial.transform import Rotation

from core.recording import samples
from core.recording.two_feet import leg_pairs
from shoecal_core.errors import FileError, FileMissingError
from shoecal_core.files import write_yaml
from shoecal_core.recording.imports.csv_import import import_csv
from shoecal_core.recording.session import Session
from shoecal_core.robot.double_support import DoubleSupport
from shoecal_core.robot.kinematics import Kinematics
from shoecal_core.robot.robot_file import load_robot

CHECKOUT = Path(__file__).parents[4]
Yaml = dict[str, object]

MAPPING = """\
format: 1
robot: robot.yaml
urdf: robot.urdf
shoe: shoe.yaml
separator: ";"
clock: joints
tables:
  joints:
    time: {column: t, unit: ms}
    joints: all
    base_pose: {frame: world, translation: [tx, ty, tz], zyx: [rz, ry, rx]}
  feet:
    wrench:
      foot: left
      frame: ankle
      force: [fx, fy, {column: fz, scale: -1}]
      torque: [mx, my, mz]
trials:
  - motion: stepping
    set: train
    support: [0.01, -0.2, 0.1]
    files: {joints: a/pos.csv, feet: a/ft.csv}
  - {motion: walking, files: {joints: b/pos.csv, feet: b/ft.csv}}
"""
POS = """\
t;LKneePitch;tx;ty;tz;rz;ry;rx;LHipRoll;other
0;0.1;1;2;3;0.1;0.2;0.3;-0.1;9
20;0.2;1;2;3;0.1;0.2;0.3;-0.2;9
40.5;0.3;1;2;3;0.1;0.2;0.3;-0.3;9
"""
FT = """\
fx;fy;fz;mx;my;mz
1;2;-3;4;5;6
1;2;-4;4;5;6

1;2;-5;4;5;6
"""


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """Recordings of two trials, mapping and what it names beside them."""
    folder = tmp_path / "recordings"
    for trial in "ab":
        (folder / trial).mkdir(parents=True)
        (folder / trial / "pos.csv").write_text(POS)
        (folder / trial / "ft.csv").write_text(FT)
    (folder / "mapping.yaml").write_text(MAPPING)
    (folder / "robot.yaml").write_text(samples.ROBOT_YAML)
    (folder / "robot.urdf").write_text(samples.URDF)
    (folder / "shoe.yaml").write_text(samples.ANKLE_YAML)
    return folder


def import_all(folder: Path) -> Session:
    return import_csv(folder / "mapping.yaml", folder, folder.parent / "session")


def test_a_robot_that_hangs_stands_nowhere(folder: Path) -> None:
    mapping = folder / "mapping.yaml"
    mapping.write_text(MAPPING.replace("motion: stepping", "motion: hanging"))
    with pytest.raises(FileError, match=r"support: a robot that hangs stands nowhere") as caught:
        import_all(folder)
    assert str(mapping) in str(caught.value)
    mapping.write_text(MAPPING.replace("motion: walking", "motion: hanging"))
    first, second = import_all(folder).runs
    assert second.info.hanging
    assert not first.info.hanging


def test_import(folder: Path) -> None:
    session = Session.open(import_all(folder).folder)
    first, second = session.runs
    assert (first.info.motion, first.hint) == ("stepping", "train")
    assert first.info.support == DoubleSupport(0.01, -0.2, 0.1)
    assert (second.info.motion, second.hint, second.info.support) == ("walking", "", None)
    run = session.read(1)
    assert run.start_ns == 0
    assert run.joints.names == ("LKneePitch", "LHipRoll")
    np.testing.assert_allclose(run.joints.time, [0.0, 0.02, 0.0405])
    np.testing.assert_allclose(run.joints.position, [[0.1, -0.1], [0.2, -0.2], [0.3, -0.3]])
    np.testing.assert_array_equal(run.readings.time, run.joints.time)
    np.testing.assert_array_equal(run.readings.value[:, :5], [[1, 2, f, 4, 5] for f in (3, 4, 5)])
    assert run.base_pose is not None
    np.testing.assert_array_equal(run.base_pose.position[0], [1, 2, 3])
    turn = Rotation.from_rotvec([0, 0, 0.1]) * Rotation.from_rotvec([0, 0.2, 0])
    turn *= Rotation.from_rotvec([0.3, 0, 0])
    np.testing.assert_allclose(
        Rotation.from_quat(run.base_pose.quaternion[0]).as_matrix(), turn.as_matrix(), atol=1e-12
    )


def test_cells_own_times_named_joints_and_commas(folder: Path) -> None:
    mapping = yaml.safe_load(MAPPING)
    del mapping["clock"]
    mapping |= {
        "decimal": ",",
        "tables": {
            "joints": {
                "time": {"column": "t", "unit": "ms"},
                "joints": {"LHipRoll": {"column": "q", "scale": 0.5}},
            },
            "feet": {
                "time": {"column": "t", "unit": "s"},
                "cells": {"right/rear_left": "b", "left/front": {"column": "a", "scale": -2}},
            },
        },
    }
    (folder / "mapping.yaml").write_text(yaml.safe_dump(mapping))
    (folder / "shoe.yaml").write_text(samples.SHOE_YAML)
    for trial in "ab":
        (folder / trial / "pos.csv").write_text("t;q\n5;1,5\n15;2,5\n")
        (folder / trial / "ft.csv").write_text("\ufefft; a;b\n0,005;1;1e-3\n0,006;2;2\n0,007;3;3\n")
    run = import_all(folder).read(2)
    np.testing.assert_allclose(run.joints.position, [[0.75], [1.25]])
    np.testing.assert_allclose(run.readings.time, [0.0, 0.001, 0.002])
    left, right = (
        run.readings.names.index("left/front"),
        run.readings.names.index("right/rear_left"),
    )
    np.testing.assert_allclose(run.readings.value[:, left], [-2, -4, -6])
    np.testing.assert_allclose(run.readings.value[:, right], [1e-3, 2, 3])


@pytest.mark.parametrize(
    ("file", "old", "new", "problem"),
    [
        ("b/pos.csv", ";tx;", ";txx;", "b/pos.csv: column 'tx': is missing (there are: t, "),
        ("b/pos.csv", ";other", ";tx", "b/pos.csv: column 'tx': is there twice"),
        ("b/pos.csv", "0.3;-0.2;9", "0.3;-0.2", "b/pos.csv: line 3: 9 values for 10 columns"),
        ("b/pos.csv", "20;0.2", "20;x0.2", "column 'LKneePitch', line 3: 'x0.2' is not a number"),
        ("b/pos.csv", "20;0.2", ";0.2", "column 't', line 3: '' is not a number"),
        (
            "mapping.yaml",
            "[0.01, -0.2, 0.1]",
            "[10, -200, 0.1]",
            "trials[0].support: dx 10, dy -200, dtheta 0.1: dx and dy are metres",
        ),
        ("b/pos.csv", "20;0.2", "nan;0.2", "column 't', line 3: 'nan' is not a number"),
        ("b/pos.csv", POS, POS.replace(";", ","), "; add separator: ',' to the mapping"),
        ("b/pos.csv", POS, POS.replace(";", "\t"), "; add separator: '\\t' to the mapping"),
        ("b/pos.csv", POS, "sep=;\n" + POS, "add lines_before_header: 1 and separator: ';'"),
        ("b/pos.csv", POS, POS.partition("\n")[2], "header: holds numbers, not names of columns"),
        ("b/pos.csv", POS, POS[:-9], "the file is cut there: delete its last line"),
        ("b/pos.csv", "\n20;0.2;", "\n20\0\0", "zero bytes"),
        ("b/pos.csv", "\n20;", f"\n{POS.splitlines()[0]}\n20;", "but the header again"),
        ("b/pos.csv", "\n20;", "\n2026-11-27 10:00;", "a date or time of day; write it as"),
        ("b/pos.csv", "40.5;", "20;", "column 't', line 4: time repeats or goes back"),
        ("b/pos.csv", "\n0;", "\n-1;", "column 't', line 2: time is negative"),
        ("b/pos.csv", "40.5;", "1e15;", "column 't', line 4: time is negative or after 2038"),
        ("b/pos.csv", POS, "", "b/pos.csv: has no rows"),
        ("b/pos.csv", "t;LKnee", "exported by x\nt;LKnee", "skip what stands above the header"),
        ("b/pos.csv", "\n0;0.1", "\nms;rad", "skip a row of units below the header"),
        ("b/ft.csv", "1;2;-4;4", "1;2;-4,5;4", "'-4,5' is not a number; does the mapping lack"),
        ("b/ft.csv", FT, FT + 6 * "1;2;3;4;5;6\n", "has 9 rows, another file of its trial 3"),
        ("b/ft.csv", "1;2;-5;4;5;6\n", "1;2;é;4;5;6\n", "column 'fz', line 5: 'é' is not"),
        ("robot.urdf", "</robot>", "", "robot.urdf: not valid XML"),
        ("robot.urdf", "revolute", "fixed", "no column has the name of one of the robot's"),
        ("mapping.yaml", "b/ft.csv", "b/no.csv", "b/no.csv: cannot be read"),
        ("mapping.yaml", "robot.urdf", "no.urdf", "urdf: 'no.urdf' is neither next"),
        ("mapping.yaml", "format: 1", "format: 9", "version 9"),
        ("mapping.yaml", "clock: joints", "clock: feet", "tables.joints.time: is not used"),
        ("mapping.yaml", "clock: joints", "clock: arms", "clock: 'arms' is not one of"),
        ("mapping.yaml", 'separator: ";"', "separator: tab", "separator: expected one character"),
        ("mapping.yaml", 'separator: ";"', 'separator: "."', "decimal: must differ"),
        ("mapping.yaml", "unit: ms", "unit: min", "time.unit: 'min' is not one of"),
        ("mapping.yaml", "scale: -1", "scale: 0", "wrench.force.scale: must not be zero"),
        ("mapping.yaml", "[mx, my, mz]", "[mx, my]", "wrench.torque: expected three columns"),
        ("mapping.yaml", "[mx, my, mz]", "[mx, my, 3]", "wrench.torque: expected a column's name"),
        ("mapping.yaml", "joints: all", "joints: {Neck: LHipRoll}", "joints: 'Neck' is not one of"),
        ("mapping.yaml", "joints: all", "{}", "not valid YAML"),
        ("mapping.yaml", "    joints: all\n", "", "tables: no table has 'joints'"),
        ("mapping.yaml", "zyx: [rz, ry, rx]", "quaternion: [rz]", "expected four columns"),
        ("mapping.yaml", ", zyx: [rz, ry, rx]", "", "base_pose.zyx: is missing; add it, or 'quat"),
        ("mapping.yaml", "zyx: [rz", "quaternion: [a, b, c, d], zyx: [rz", "keep one of them"),
        ("mapping.yaml", "set: train", "start: 2026-03-01", "start: expected seconds, or a time"),
        ("mapping.yaml", "set: train", "start: noon", "start: expected seconds, or a time"),
        ("mapping.yaml", "set: train", "start: -1", "start: must be at least 0"),
        ("mapping.yaml", "foot: left", "foot: middle", "wrench.foot: 'middle' is not one of"),
        ("mapping.yaml", ", feet: b/ft.csv", "", "files.feet: is missing"),
        ("shoe.yaml", "unit: N", "unit: 3", "shoe.yaml: unit: expected text"),
    ],
)
def test_bad_input_is_one_error_that_names_its_place(
    folder: Path, file: str, old: str, new: str, problem: str
) -> None:
    path = folder / file
    text = path.read_text()
    assert old in text
    path.write_text(text.replace(old, new))
    with pytest.raises(FileError) as caught:
        import_all(folder)
    assert problem in str(caught.value)
    assert "\n" not in str(caught.value)
    assert not (folder.parent / "session").exists()


def test_the_time_of_other_units(folder: Path) -> None:
    mapping = folder / "mapping.yaml"
    mapping.write_text(MAPPING.replace("unit: ms", "unit: s"))
    with pytest.raises(FileError, match=r"rows are 20\.2 s apart, .*; correct the unit"):
        import_all(folder)
    mapping.write_text(MAPPING.replace("unit: ms", "unit: ns"))
    with pytest.raises(FileError, match=r"rows are 2\.0.e-08 s apart"):
        import_all(folder)


def test_times_that_count_from_1970_need_no_start(folder: Path) -> None:
    mapping = folder / "mapping.yaml"
    mapping.write_text(MAPPING.replace("set: train", "start: 1763740000"))
    for trial in "ab":
        pos = folder / trial / "pos.csv"
        head, *rows = pos.read_text().splitlines()
        later = [
            f"17900000000{one.partition(';')[0].zfill(2)};{one.partition(';')[2]}" for one in rows
        ]
        pos.write_text("\n".join([head, *later]) + "\n")
    with pytest.raises(FileError, match="counts from 1970 already: leave the trial's 'start' out"):
        import_all(folder)


def test_two_logs_in_one_file(folder: Path) -> None:
    rows = [f"{20 * at};{0.001 * at}" for at in range(50)]
    for trial in "ab":
        (folder / trial / "pos.csv").write_text("\n".join(["t;LKneePitch", *rows, *rows]) + "\n")
        (folder / trial / "ft.csv").write_text(
            "\n".join([FT.splitlines()[0], *100 * ["1;2;-4;4;5;6"]]) + "\n"
        )
    lines = MAPPING.splitlines(keepends=True)
    text = "".join(line for line in lines if "base_pose" not in line)
    (folder / "mapping.yaml").write_text(text)
    with pytest.raises(FileError, match="line 52: time goes back to that of an earlier row"):
        import_all(folder)


def test_rows_stamped_when_received_are_refused(folder: Path) -> None:
    rows = [f"{400 * (at // 20) + at % 20};{0.001 * at}" for at in range(300)]
    for trial in "ab":
        (folder / trial / "pos.csv").write_text("\n".join(["t;LKneePitch", *rows]) + "\n")
        (folder / trial / "ft.csv").write_text(
            "\n".join([FT.splitlines()[0], *300 * ["1;2;-4;4;5;6"]]) + "\n"
        )
    lines = MAPPING.splitlines(keepends=True)
    text = "".join(line for line in lines if "base_pose" not in line)
    (folder / "mapping.yaml").write_text(text)
    with pytest.raises(FileError, match=r"line 22: .* in packets of 20 every 0.40 s"):
        import_all(folder)


def test_cells_by_the_names_of_columns(folder: Path) -> None:
    mapping = MAPPING.replace("joints: all", "joints: all\n    cells: all")
    (folder / "mapping.yaml").write_text(mapping)
    with pytest.raises(FileError, match=r"one of the shoe's channels \(left/f.*in 'cells'"):
        import_all(folder)


def test_thousands_separators_are_refused(folder: Path) -> None:
    for trial in "ab":
        (folder / trial / "ft.csv").write_text(FT.replace("-3", "-3.000").replace("-4", "-4,5"))
        pos = folder / trial / "pos.csv"
        pos.write_text(POS.replace(".", ","))
    (folder / "mapping.yaml").write_text(MAPPING.replace("clock:", 'decimal: ","\nclock:'))
    with pytest.raises(FileError, match=r"column 'fz', line 2: '-3.000' has a '\.', but 'decimal'"):
        import_all(folder)


def test_lines_around_the_header_can_be_skipped(folder: Path) -> None:
    head, _, rows = POS.partition("\n")
    ft_head, _, ft_rows = FT.partition("\n")
    for trial in "ab":
        (folder / trial / "pos.csv").write_text(f"made by x\n1;2\n{head}\nms;rad\n{rows}")
        (folder / trial / "ft.csv").write_text(f"made by x\n\n{ft_head}\nN;N\n{ft_rows}")
    skipped = "lines_before_header: 2\nlines_after_header: 1\nclock:"
    (folder / "mapping.yaml").write_text(MAPPING.replace("clock:", skipped))
    run = import_all(folder).read(1)
    np.testing.assert_allclose(run.joints.time, [0.0, 0.02, 0.0405])
    (folder / "a" / "ft.csv").write_text(
        f"made by x\n\n{ft_head}\nN;N\n{ft_rows}".replace("-4", "?")
    )
    with pytest.raises(FileError, match=r"ft.csv: column 'fz', line 6: '\?' is not a number"):
        import_all(folder.rename(folder.with_name("again")))


@pytest.mark.parametrize("nothing", ["", "NaN", "nan", "N/A"])
def test_readings_that_are_not_there(folder: Path, nothing: str) -> None:
    """Of cells they are marked so; of a wrench its row is left out. Both are noted."""
    (folder / "a" / "ft.csv").write_text(FT.replace("-4", nothing))
    run = import_all(folder).read(1)
    np.testing.assert_allclose(run.readings.time, [0.0, 0.0405])
    assert "ft.csv: 1 values are not there, 1 of 3 of 'fz'" in run.notes


def test_rows_without_any_value_are_no_messages(folder: Path) -> None:
    """As where a logger writes faster than joints are sampled: nothing is missing there."""
    first, *rows = POS.splitlines()
    between = [re.sub(";0.1;(.*);-0.1;", r";;\1;;", rows[0].replace("0;", f"{at};", 1))
               for at in (5, 10)]  # fmt: skip
    (folder / "a" / "pos.csv").write_text("\n".join([first, rows[0], *between, *rows[1:], ""]))
    (folder / "a" / "ft.csv").write_text(FT + "1;2;-3;4;5;6\n" * 2)
    run = import_all(folder).read(1)
    assert [note for note in run.notes if "pos.csv" in note] == [
        "pos.csv: 2 of 5 rows have no value of 'LKneePitch' and 1 more, and are left out of them"
    ]


def test_joint_angles_that_are_not_there(folder: Path) -> None:
    """Some are gaps; a joint without any is refused unless it is optional."""
    pos = folder / "a" / "pos.csv"
    pos.write_text(POS.replace("20;0.2", "20;"))
    run = import_all(folder).read(1)
    assert "pos.csv: 1 values are not there, 1 of 3 of 'LKneePitch'" in run.notes
    np.testing.assert_array_equal(run.joints.position[:, 0], [0.1, np.nan, 0.3])
    pos.write_text(
        POS.replace(";0.1;1", ";;1").replace(";0.2;1", ";;1").replace(";0.3;1", ";NaN;1")
    )
    other = folder.rename(folder.with_name("again"))
    mapping = other / "mapping.yaml"
    expected = "column 'LKneePitch': holds no angle of joint 'LKneePitch'; record it, or, if it"
    with pytest.raises(FileError, match=expected):
        import_csv(mapping, other, other / "out")
    (other / "robot.yaml").write_text(f"{samples.ROBOT_YAML}optional_joints: [LKneePitch]\n")
    run = import_csv(mapping, other, other / "out").read(1)
    assert "joint 'LKneePitch' was never recorded" in run.notes


def test_a_span_of_the_tables(folder: Path) -> None:
    mapping = yaml.safe_load(MAPPING)
    mapping["trials"][0] |= {"from_s": 0.01, "to_s": 0.03}
    (folder / "mapping.yaml").write_text(yaml.safe_dump(mapping))
    run = import_all(folder).read(1)
    np.testing.assert_array_equal(run.joints.position, [[0.2, -0.2]])
    np.testing.assert_array_equal(run.readings.value[:, 2], [4.0])
    mapping["trials"][0] |= {"from_s": 10, "to_s": 20}
    (folder / "mapping.yaml").write_text(yaml.safe_dump(mapping))
    expected = r"csv: has no row from 10 s to 20 s: its rows are at 0.000 to 0.041 s"
    with pytest.raises(FileError, match=expected):
        import_csv(folder / "mapping.yaml", folder, folder / "out")


def test_angles_in_degrees(folder: Path) -> None:
    """Of joints and of a base pose."""
    (folder / "mapping.yaml").write_text(f"{MAPPING}angle_unit: deg\n")
    run = import_all(folder).read(1)
    np.testing.assert_allclose(run.joints.position[0], np.radians([0.1, -0.1]))
    assert run.base_pose is not None
    turn = Rotation.from_euler("ZYX", np.radians([0.1, 0.2, 0.3]))
    np.testing.assert_allclose(run.base_pose.quaternion[0], turn.as_quat())


def test_a_table_that_is_missing_is_no_other_trials(folder: Path) -> None:
    (folder / "b" / "pos.csv").unlink()
    with pytest.raises(FileMissingError) as raised:
        import_all(folder)
    assert raised.value.path in raised.value.named
    assert folder / "a" / "pos.csv" in raised.value.named


def test_one_row_more_is_left_out_and_reported(folder: Path) -> None:
    (folder / "b" / "ft.csv").write_text(FT + "9;9;9;9;9;9\n")
    session = import_all(folder)
    assert session.runs[0].info.notes == ()
    run = session.read(2)
    assert run.notes == (
        "ft.csv: the last row is left out, another file has only 3 rows",
        *session.read(1).notes,
    )
    assert len(run.joints.time) == len(run.readings.time) == 3


def test_a_time_that_repeats_now_and_then_is_left_out_and_reported(folder: Path) -> None:
    rows = [f"{20 * k};0.1;1;2;3;0.1;0.2;0.3;-0.1;9" for k in range(30)]
    rows.insert(5, rows[4])
    (folder / "a" / "pos.csv").write_text("\n".join([POS.splitlines()[0], *rows]))
    (folder / "a" / "ft.csv").write_text("\n".join([FT.splitlines()[0], *31 * ["1;2;3;4;5;6"]]))
    run = import_all(folder).read(1)
    np.testing.assert_allclose(run.joints.time, 0.02 * np.arange(30), atol=1e-9)
    assert run.notes[0] == (
        "pos.csv: 1 of 31 rows left out, their time repeats or goes back (first in line 7)"
    )


@pytest.mark.parametrize("digits", ["1.7e9 to six digits", "whole seconds"])
def test_times_without_their_digits_are_refused_with_the_cure(folder: Path, digits: str) -> None:
    """In ms, 20 ms apart."""
    times = 1000.0 * (np.arange(60) // 50)
    if digits == "1.7e9 to six digits":
        times = np.array([float(f"{1.7e9 + 20 * k:.6g}") for k in range(60)])
    rows = [f"{time:.0f};0.1;1;2;3;0.1;0.2;0.3;-0.1;9" for time in times]
    (folder / "a" / "pos.csv").write_text("\n".join([POS.splitlines()[0], *rows]))
    (folder / "a" / "ft.csv").write_text("\n".join([FT.splitlines()[0], *60 * ["1;2;3;4;5;6"]]))
    with pytest.raises(FileError) as raised:
        import_all(folder)
    assert "pos.csv" in str(raised.value)
    assert "of 60 times are those of the row before" in str(raised.value)
    assert "too few digits; write them to a millisecond or better" in str(raised.value)


def test_times_without_leading_zeros_are_read_as_they_were_meant(folder: Path) -> None:
    """Of `%d.%d` with seconds and nanoseconds; every tenth row would count at a wrong time."""
    mapping = folder / "mapping.yaml"
    mapping.write_text(mapping.read_text().replace("unit: ms", "unit: s"))
    ticks = [2_990_000_000 + 20_000_000 * k for k in range(150)]
    rows = [f"{tick // 10**9}.{tick % 10**9};0.1;1;2;3;0.1;0.2;0.3;-0.1;9" for tick in ticks]
    (folder / "a" / "pos.csv").write_text("\n".join([POS.splitlines()[0], *rows]))
    (folder / "a" / "ft.csv").write_text("\n".join([FT.splitlines()[0], *150 * ["1;2;3;4;5;6"]]))
    (folder / "b" / "pos.csv").write_text("\n".join([POS.splitlines()[0], *rows[:3]]))
    run = import_all(folder).read(1)
    np.testing.assert_allclose(run.joints.time, 0.02 * np.arange(150), atol=1e-9)
    assert run.notes[0] == (
        "pos.csv: times were printed without the decimals' leading zeros: 3.10000000 (line 3) is "
        "read as 3.010000000 (print decimals with `%09d`)"
    )


@pytest.mark.parametrize("row", [7, 55])
@pytest.mark.parametrize(("bits", "tick_ms"), [(16, 1.0), (32, 1e-3), (32, 1.0)])
def test_a_counter_that_starts_again_is_told_with_its_line_and_period(
    folder: Path, bits: int, tick_ms: float, row: int
) -> None:
    """In ms, 20 ms apart; the counter was not at zero."""
    period = 2.0**bits * tick_ms
    times = 20.0 * np.arange(60) + 5.0 + (period - 20.0 * row)
    times[row:] -= period
    rows = [f"{time:.3f};0.1;1;2;3;0.1;0.2;0.3;-0.1;9" for time in times]
    (folder / "a" / "pos.csv").write_text("\n".join([POS.splitlines()[0], *rows]))
    (folder / "a" / "ft.csv").write_text("\n".join([FT.splitlines()[0], *60 * ["1;2;3;4;5;6"]]))
    with pytest.raises(
        FileError, match=rf"pos.csv: .*, line {row + 2}: time starts again"
    ) as raised:
        import_all(folder)
    assert f"add {1e-3 * period:.10g} s from this line on" in str(raised.value)


def two_clocks(folder: Path, late_s: float) -> Session:
    """Cells sampled every 10 ms, each table by its own times; those of the cells are later."""
    mapping = yaml.safe_load(MAPPING)
    del mapping["clock"]
    mapping["tables"] = {
        "joints": {"time": {"column": "t", "unit": "ms"}, "joints": "all"},
        "feet": {"time": {"column": "t", "unit": "us"}, "cells": "all"},
    }
    files = {"joints": "q.csv", "feet": "cells.csv"}
    mapping["trials"] = [{"motion": "walking", "files": files}]
    write_yaml(folder / "mapping.yaml", mapping)
    (folder / "shoe.yaml").write_text(samples.SHOE_YAML)
    rows = [f"{10 * at};0.1" for at in range(1000)]
    (folder / "q.csv").write_text("\n".join(["t;LKneePitch", *rows]) + "\n")
    rows = [f"{round(1e6 * late_s) + 10_000 * at};0.5" for at in range(1000)]
    (folder / "cells.csv").write_text("\n".join(["t;left/front", *rows]) + "\n")
    return import_all(folder)


@pytest.mark.parametrize("late_s", [0.0, 0.3, 9.98])
def test_tables_that_overlap_are_taken(folder: Path, late_s: float) -> None:
    run = two_clocks(folder, late_s).read(1)
    assert len(run.joints.time) == len(run.readings.time) == 1000


def test_tables_without_a_time_in_common_are_refused(folder: Path) -> None:
    """Joints by their logger's start, cells by their board's."""
    with pytest.raises(FileError) as caught:
        two_clocks(folder, 93.4)
    assert (
        "q.csv: column 't': its times are 0.000 to 9.990 s, those of cells.csv 93.400 to 103.390 s"
        in str(caught.value)
    )
    assert "add 93.4 s to the times of q.csv" in str(caught.value)
    assert not (folder.parent / "session").exists()


def test_legs_or_the_sign_of_a_support_that_is_all_that_is_known(tmp_path: Path) -> None:
    """A NAO that stands astride, and does not move, says as much of one as of the other."""
    config = CHECKOUT / "config"
    kinematics = Kinematics(load_robot(config / "robots/nao.yaml"))
    robot = kinematics.robot
    posture = robot.posture.copy()
    for side, sign in (("L", 1.0), ("R", -1.0)):
        posture[robot.joint(f"{side}HipPitch")] += sign * 0.15
        posture[robot.joint(f"{side}AnklePitch")] -= sign * 0.15
    found = kinematics.states(posture[None]).support()
    other = dict(leg_pairs(kinematics))
    other |= {right: left for left, right in other.items()}
    names = ["t", *(other.get(name, name) for name in robot.joint_names), "left/front_left"]
    rows = [",".join(map(str, [0.01 * at, *posture, 0.5])) for at in range(50)]
    (tmp_path / "q.csv").write_text("\n".join([",".join(names), *rows]) + "\n")
    mapping = {
        "format": 1,
        "robot": str(config / "robots/nao.yaml"),
        "urdf": str(config / "robots/nao.urdf"),
        "shoe": str(config / "shoes/nao_shoe.yaml"),
        "tables": {"all": {"time": {"column": "t", "unit": "s"}, "joints": "all", "cells": "all"}},
        "trials": [
            {
                "motion": "standing",
                "support": [found.dx, found.dy, found.dtheta],
                "files": {"all": "q.csv"},
            }
        ],
    }
    write_yaml(tmp_path / "mapping.yaml", mapping)
    with pytest.raises(FileError) as caught:
        import_csv(tmp_path / "mapping.yaml", tmp_path, tmp_path / "session")
    assert f"dx is {found.dx:.4g} m, but {-found.dx:.4g} m by the joint angles" in str(caught.value)
    assert "or exchange the left and the right leg's joints, which agree" in str(caught.value)


def test_efforts_imu_quaternions_and_start(folder: Path) -> None:
    """Each table with a time column; efforts sampled at other times than the angles."""
    mapping = yaml.safe_load(MAPPING)
    del mapping["clock"]
    time = {"time": {"column": "t", "unit": "s"}}
    mapping["tables"]["feet"] |= time
    mapping["tables"]["joints"] = time | {
        "joints": "all",
        "base_pose": {
            "frame": "world",
            "translation": ["tx", "ty", "tz"],
            "quaternion": ["qx", "qy", "qz", "qw"],
        },
        "imu": {
            "frame": "torso",
            "angular_velocity": ["gx", "gy", "gz"],
            "linear_acceleration": ["ax", "ay", {"column": "az", "scale": 9.81}],
        },
    }
    mapping["tables"]["motors"] = time | {"efforts": "all"}
    mapping["trials"] = [
        {
            "motion": "walking",
            "start": start,
            "files": {"joints": "pos.csv", "feet": "ft.csv", "motors": "tau.csv"},
        }
        for start in (1000.5, "2026-03-01T10:00:00+01:00")
    ]
    write_yaml(folder / "mapping.yaml", mapping)
    columns = "t;LKneePitch;LHipRoll;tx;ty;tz;qx;qy;qz;qw;gx;gy;gz;ax;ay;az\n"
    rows = [f"{0.01 * k:.2f};0.1;0.2;1;2;3;0;0;0.6;0.8;1;2;3;4;5;1\n" for k in range(5)]
    (folder / "pos.csv").write_text(columns + "".join(rows))
    (folder / "ft.csv").write_text(
        "t;fx;fy;fz;mx;my;mz\n" + "".join(f"{0.01 * k:.2f};1;2;3;4;5;6\n" for k in range(5))
    )
    (folder / "tau.csv").write_text("t;LKneePitch\n0;10\n0.03;40\n0.04;40\n")
    session = import_all(folder)
    run, dated = session.read(1), session.read(2)
    assert (run.start_ns, dated.start_ns) == (1_000_500_000_000, 1_772_355_600_000_000_000)
    assert run.joints.effort is not None
    np.testing.assert_allclose(run.joints.effort[:, 0], [10, 20, 30, 40, 40])
    assert np.isnan(run.joints.effort[:, 1]).all()
    assert run.base_pose is not None
    np.testing.assert_allclose(run.base_pose.quaternion, np.tile([0, 0, 0.6, 0.8], (5, 1)))
    assert run.imu is not None
    assert run.imu.frame == "torso"
    assert np.isnan(run.imu.quaternion).all()
    np.testing.assert_allclose(run.imu.angular_velocity[0], [1, 2, 3])
    np.testing.assert_allclose(run.imu.linear_acceleration[0], [4, 5, 9.81])


def test_feet_that_were_sampled_apart_share_instants(folder: Path) -> None:
    """Two logs with jittered times of their own: interpolated by their times, row by row never."""
    mapping = yaml.safe_load(MAPPING)
    del mapping["clock"]
    columns = {key: mapping["tables"]["feet"]["wrench"][key] for key in ("force", "torque")}
    feet = {foot: {"foot": foot, "frame": foot, **columns} for foot in ("left", "right")}
    time = {"time": {"column": "t", "unit": "s"}}
    mapping["tables"] = {
        "joints": {"time": {"column": "t", "unit": "ms"}, "joints": "all"},
        **{foot: time | {"wrench": wrench} for foot, wrench in feet.items()},
    }
    files = {"joints": "a/pos.csv", "left": "left.csv", "right": "right.csv"}
    mapping["trials"] = [{"motion": "walking", "files": files}]
    write_yaml(folder / "mapping.yaml", mapping)
    generator = np.random.default_rng(1)
    for foot, count in (("left", 400), ("right", 300)):
        times = np.linspace(0.0, 1.0, count) + generator.uniform(0.0, 1e-3, count)
        table = np.column_stack([times, *6 * [np.sin(5.0 * times)]])
        header = "t;fx;fy;fz;mx;my;mz"
        np.savetxt(folder / f"{foot}.csv", table, delimiter=";", header=header, comments="")
    run = import_all(folder).read(1)
    assert any("interpolated to common ones" in note for note in run.notes)
    whole = np.isfinite(run.readings.value).all(axis=1)
    assert len(run.readings.time) == 300
    assert whole.sum() >= 298
    truth = np.sin(5.0 * (run.readings.time[whole] + 1e-9 * run.start_ns))
    np.testing.assert_allclose(run.readings.value[whole, 0], truth, atol=1e-4)
    np.testing.assert_allclose(run.readings.value[whole, -1], truth, atol=1e-4)


def test_feet_without_that_sensor(folder: Path) -> None:
    (folder / "shoe.yaml").write_text(samples.SHOE_YAML)
    with pytest.raises(FileError, match="'test_shoe' has no six-axis sensor on the left foot"):
        import_all(folder)


def test_files_are_looked_for_beside_the_mapping_first(folder: Path, tmp_path: Path) -> None:
    (tmp_path / "maps").mkdir()
    (folder / "mapping.yaml").rename(tmp_path / "maps" / "mapping.yaml")
    (tmp_path / "maps" / "robot.yaml").write_text("format: 1\nname: other\n")
    session = import_csv(tmp_path / "maps" / "mapping.yaml", folder, tmp_path / "session")
    assert session.robot == "other"


@pytest.fixture
def real() -> Path:
    """Public recordings of a REEM-C, which are not part of the project."""
    folder = Path(os.environ.get("SHOECAL_REAL_DATA", ""), "reemc")
    if not folder.is_absolute() or not folder.is_dir():
        pytest.skip("SHOECAL_REAL_DATA names no folder with the recordings of the REEM-C")
    return folder


def test_real_recordings(real: Path, tmp_path: Path) -> None:
    for name, text in (("robots", "format: 1\nname: reemc\n"), ("shoes", samples.ANKLE_YAML)):
        (tmp_path / name).mkdir()
        (tmp_path / name / "reemc.yaml").write_text(text)
    (tmp_path / "imports").mkdir()
    mapping = tmp_path / "imports" / "reemc.yaml"
    mapping.write_bytes((CHECKOUT / "config" / "imports" / "reemc.yaml").read_bytes())
    session = import_csv(mapping, real, tmp_path / "session")
    runs = [session.read(entry.run) for entry in session.runs]
    trials = ("stepping", *(f"walk_{letter}" for letter in "abcdefg"))
    assert [len(run.readings.time) for run in runs] == [2919, 881, 1110, 875, 1009, 975, 993, 991]
    for run, trial in zip(runs, trials, strict=True):
        odd = ["ftl.csv", "ftr.csv"] if trial in ("walk_c", "walk_f") else []
        assert [note.partition(":")[0] for note in run.notes] == odd
        assert len(run.joints.names) == 102
        np.testing.assert_array_equal(run.joints.time, run.readings.time)
        force = np.loadtxt(real / trial / "ftl.csv", delimiter=";", skiprows=1, usecols=3)
        fz = run.readings.value[:, run.readings.names.index("left/fz")]
        np.testing.assert_array_equal(fz, force[: len(fz)])
        assert run.base_pose is not None
        assert 0.5 < run.base_pose.position[:, 2].mean() < 1.0
