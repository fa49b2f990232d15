from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from core.report import samples
from core.report.pages import read_svg
from core.robot import robots
from core.shoe import shoes
from shoecal_core.arrays import FloatArray
from shoecal_core.errors import ShapeError
from shoecal_core.estimation.series import Mae, Series
from shoecal_core.report import palette
from shoecal_core.report.calibration.figures import (
    accuracy_pictures,
    foot_picture,
    run_pictures,
)
from shoecal_core.report.calibration.tables import channels_table
from shoecal_core.report.figures.bars import Bar, mae_bars
from shoecal_core.report.figures.feet import CopPath, FootShape, cop_plane, cop_under_feet
from shoecal_core.report.figures.loads import (
    KnownLoads,
    cop_under_loads,
    forces_under_loads,
)
from shoecal_core.report.figures.motion import BODY, skeleton, snapshots
from shoecal_core.report.figures.series import (
    Line,
    cop_and_grf,
    errors_in_time,
    joined,
)


def series(count: int = 200, *, start: float = 0.0, gap: slice = slice(0, 0)) -> Series:
    time = start + np.linspace(0.0, 10.0, count)
    cop = 0.03 * np.column_stack((np.sin(time), np.cos(time)))
    cop[gap] = np.nan
    both = np.stack((cop, cop), axis=1)
    grf = np.full(count, 54.0)
    return Series(time, grf, cop, np.column_stack((grf, grf)) / 2.0, both)


def test_the_same_instants_next_to_each_other() -> None:
    one, other = series(5), series(5, start=20.0)
    both = joined([other, one])
    assert len(both.time) == 11
    assert (np.diff(both.time) >= 0.0).all()
    np.testing.assert_array_equal(np.flatnonzero(np.isnan(both.grf)), [5])
    assert both.foot_cop.shape == (11, 2, 2)
    assert joined([one]) is one


@pytest.mark.parametrize("gap", [slice(0, 0), slice(50, 90), slice(None)])
def test_series_with_gaps(gap: slice) -> None:
    lines = [
        Line("initial guess", palette.GUESS, series()),
        Line("calibrated", palette.MEASURED, series(gap=gap)),
    ]
    for svg in (cop_and_grf(lines), errors_in_time(lines, series())):
        text = "".join(read_svg(svg).itertext())
        for label in ("CoP x (mm)", "CoP y (mm)", "GRF (N)", "time (s)", "calibrated"):
            assert label in text


def test_a_wild_line_does_not_flatten_the_others() -> None:
    wild = series()
    wild.cop[100] = 1e6
    tame = [Line("guess", palette.GUESS, series()), Line("best", palette.MEASURED, series())]
    heights = []
    for lines in (tame, [Line("guess", palette.GUESS, wild), tame[1]]):
        ticks = [
            float(text.replace("\N{MINUS SIGN}", "-"))
            for text in read_svg(cop_and_grf(lines)).itertext()
            if text.strip("\N{MINUS SIGN}").replace(".", "").isdigit()
        ]
        heights.append(max(map(abs, ticks)))
    assert heights[1] < 10.0 * heights[0]


def test_long_recordings_stay_small() -> None:
    long = series(100_000, gap=slice(10, 20))
    lines = [Line(str(index), palette.TRUTH, long) for index in range(4)]
    read_svg(cop_and_grf(lines))
    read_svg(cop_plane([foot()], [CopPath("a", palette.TRUTH, long.cop)] * 4))


def foot(cells: int = 4) -> FootShape:
    shape = robots.load("nao").feet[0]
    shoe = samples.shoe_of(cells)
    return FootShape("left", shape.outline, shape.sensing_polygon, shoe.positions[shoe.of_foot(0)])


@pytest.mark.parametrize("cells", [3, 4, 6])
def test_cells_are_drawn(cells: int) -> None:
    paths = [CopPath("truth", palette.TRUTH, series().cop)]
    for svg in (cop_plane([foot(cells)], paths), cop_under_feet([(foot(cells), paths)])):
        assert f"cells ({cells} left)" in read_svg(svg).attrib["aria-label"]
        # One of them stands in the legend.
        assert len([use for use in read_svg(svg).iter("use") if use.get("style")]) >= cells + 1


def test_no_cop_at_all() -> None:
    nothing = [CopPath("truth", palette.TRUTH, np.full((9, 2), np.nan))]
    read_svg(cop_plane([foot()], nothing))


@pytest.mark.parametrize("name", robots.NAMES)
def test_a_skeleton_stands_on_the_floor_and_has_the_robots_com(name: str) -> None:
    robot = robots.load(name)
    for angles in (robot.posture, robots.random_angles(robot, 1, seed=3)[0]):
        body = skeleton(robot, angles)
        states = robots.kinematics(name).states(angles[None])
        lifted = states.translation[0, 2] < -0.01
        np.testing.assert_allclose(body.com, states.com[0, int(lifted)], atol=1e-9)
        standing = body.soles[int(lifted)]
        np.testing.assert_allclose(standing[:, 2], 0.0, atol=1e-12)
        outline = robot.feet[int(lifted)].outline
        np.testing.assert_allclose(standing[:, :2], outline, atol=1e-12)
        assert {0, 1, BODY} == set(body.side.tolist())


def test_legs_reach_from_base_to_sole() -> None:
    robot = robots.load("nao")
    body = skeleton(robot, robot.posture)
    for side in (0, 1):
        leg = body.bones[body.side == side]
        # Six joints, then down to the sole.
        assert len(leg) == 7
        np.testing.assert_allclose(leg[1:-1, 0], leg[:-2, 1], atol=1e-12)
        np.testing.assert_allclose(leg[-1, 1], body.soles[side].mean(axis=0), atol=1e-9)


def test_snapshots_tell_when() -> None:
    robot = robots.load("nao")
    bodies = [skeleton(robot, angles) for angles in samples.swaying(robot, 5)]
    text = "".join(read_svg(snapshots(bodies, [0.0, 2.5, 5.0, 7.5, 10.0])).itertext())
    for label in ("2.5 s", "10.0 s", "left leg", "right leg", "from the front"):
        assert label in text
    with pytest.raises(ShapeError):
        skeleton(robot, robot.posture[:3])


def test_bars_are_filled_for_training_and_empty_for_tests() -> None:
    mae = Mae(0.35, 0.5, 10)
    unknown = Mae(np.nan, np.nan, 0)
    bars = [
        Bar("initial guess", palette.GUESS, "guess", False, Mae(7.5, 1.0, 10), Mae(0.023, 0, 10)),
        Bar("calibrated", palette.MEASURED, "best", False, mae, unknown),
        Bar("calibrated", palette.MEASURED, "best", True, mae, mae),
    ]
    root = read_svg(mae_bars(bars))
    text = list(root.itertext())
    for label in ("7.50", "23.00", "0.35", "GRF MAE (N)", "CoP MAE (mm)", "empty: test runs"):
        assert label in text
    styles = [element.get("style", "") for element in root.iter("path")]
    drawn = [style for style in styles if "var(--calibrated)" in style]
    assert any("fill: none" in style for style in drawn)
    assert any("fill: var(--calibrated)" in style for style in drawn)


def test_many_bars_go_without_figures() -> None:
    mae = Mae(0.351, 0.2, 10)
    bars = [Bar(str(n), palette.MEASURED, "best", n > 9, mae, mae) for n in range(20)]
    assert "0.35" not in list(read_svg(mae_bars(bars)).itertext())


def known_loads(masses: FloatArray) -> KnownLoads:
    """Each weight in each of six holes, 3 mm off before the correction and 1 mm after."""
    shape = 1e-2 * np.array([[0, 0], [4, 0], [4, 6], [0, 6]])
    holes = 1e-2 * np.array([[x, y] for x in (1, 2, 3) for y in (2, 4)])
    places = np.tile(holes, (len(masses), 1))
    each = np.repeat(masses, len(holes))
    return KnownLoads(
        FootShape("left", shape, shape, shape), each, 9.81 * each + 0.02, 9.81 * each, places,
        places + np.array([3e-3, 0.0]), places + np.array([0.0, 1e-3]),
    )  # fmt: skip


@pytest.mark.parametrize("masses", [[2.0], [1.0, 1.5, 2.0, 2.5, 3.0, 3.5, 4.0, 5.0]])
def test_loads_of_a_shoe(masses: list[float]) -> None:
    loads = known_loads(np.array(masses))
    root = read_svg(forces_under_loads(loads))
    assert "mean absolute error 0.020 N" in root.attrib["aria-label"]
    assert {"GRF (N)", "Δ GRF (mN)"} <= set(root.itertext())
    for corrected, error in ((False, "3.00 mm"), (True, "1.00 mm")):
        root = read_svg(cop_under_loads(loads, corrected=corrected))
        assert error in root.attrib["aria-label"]
        assert {f"{masses[-1]:g} kg", "hole"} <= set(root.itertext())
    with pytest.raises(ShapeError, match=r"loads\.corrected"):
        replace(loads, corrected=loads.corrected[1:])


@pytest.mark.parametrize(("cells", "truth"), [(3, True), (4, False), (6, True), (6, False)])
def test_every_picture_of_a_calibration(cells: int, truth: bool) -> None:
    content = samples.content(samples.shoe_of(cells), truth=truth, runs=1)
    run = samples.with_gap(content.runs[0])
    pictures = (
        *accuracy_pictures(content),
        *run_pictures(content, run),
        foot_picture(content, run),
    )
    for picture in pictures:
        read_svg(picture.svg)
    assert len(pictures) == 7


def test_torques_have_units_of_their_own() -> None:
    shoe = shoes.made([*shoes.six_axis(0, (0.0, 0.0, 0.1)), *shoes.six_axis(1, (0.0, 0.0, 0.1))])
    content = samples.content(shoe, runs=1)
    told = " ".join(" ".join(row) for row in channels_table(content).rows)
    assert "N m/V" in told
    assert "N/V" in told
    newtons = replace(content, shoe=replace(shoe, unit="N"))
    assert "/V" not in " ".join(" ".join(row) for row in channels_table(newtons).rows)
