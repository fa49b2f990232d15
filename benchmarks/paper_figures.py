"""The paper's figures of results, drawn again from the reproduction."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from paper_reproduction import GUESS, Difference, Paper, Reproduction, shoe_and_robot
from paper_targets import ALPHA
from shoecal_core.estimation.run_errors import ComparedRun, errors_by_set
from shoecal_core.report import palette
from shoecal_core.report.figures.bars import Bar, mae_bars
from shoecal_core.report.figures.feet import CopPath, FootShape, cop_plane
from shoecal_core.report.figures.loads import KnownLoads, cop_under_loads, forces_under_loads
from shoecal_core.report.figures.motion import skeleton, snapshots
from shoecal_core.report.figures.series import Line
from shoecal_core.report.palette import Look
from shoecal_core.report.quantities import mean_error
from shoecal_core.report.sheet import SheetFigure, write_sheet
from shoecal_core.report.svg import canvas, draw_line, line_key, readable, y_label
from shoecal_core.robot.double_support import DoubleSupport
from shoecal_core.shoe.shoe import FEET
from shoecal_core.workflows.evaluation import MEASURED, MODELLED, REFERENCE

SNAPSHOTS = 5
WEIGHT = Look(palette.INK, 1.4)
LOOKS = {
    GUESS: ("initial guess", palette.GUESS),
    REFERENCE: ("manual", palette.TRUTH),
    MEASURED: ("self-calibration", palette.MEASURED),
}
RUNS = tuple(
    Look(colour, 0.9)
    for colour in (palette.GUESSED, palette.TRUE, palette.LEFT, palette.CALIBRATED, palette.MODEL)
)


def write_figures(paper: Paper, folder: Path) -> None:
    """Write every figure as an SVG file."""
    folder.mkdir(parents=True, exist_ok=True)
    robot = paper.first
    write_sheet(
        folder / "paper-manual.svg",
        _manual(robot),
        "Manual calibration of both shoes: force under known weights, CoP before and after the "
        "correction.",
    )
    write_sheet(
        folder / "paper-assumptions.svg",
        _assumptions(robot),
        "GRF of five runs around the weight, and modelled against measured CoP in each.",
    )
    for part in ("train", "test"):
        chosen = [run for run in robot.runs if run.set == part][:2]
        write_sheet(
            folder / f"paper-{part}.svg",
            _runs(robot, chosen),
            f"Motion, CoP and GRF of {part} runs {', '.join(str(run.run) for run in chosen)}.",
        )
    write_sheet(
        folder / "paper-errors.svg",
        [[_errors(paper.robots[:1], "Robot 1, as in the paper", {}), _pooled(paper)]],
        "Errors of GRF and CoP against the manual calibration, training and test runs.",
    )


def _manual(robot: Reproduction) -> list[list[SheetFigure]]:
    loads = [_loads(robot, foot) for foot in (0, 1)]
    found = robot.manual.feet
    rows = [
        [
            SheetFigure(
                f"{name.capitalize()} shoe, GRF: {mean_error(foot.grf, 'mN', 1e3)}",
                forces_under_loads(shoe),
            )
            for name, foot, shoe in zip(FEET, found, loads, strict=True)
        ]
    ]
    for name, foot, shoe in zip(FEET, found, loads, strict=True):
        rows.append(
            [
                SheetFigure(
                    f"{name.capitalize()} shoe, CoP {label}: {mean_error(mae, 'mm', 1e3)}",
                    cop_under_loads(shoe, corrected=corrected),
                )
                for label, mae, corrected in (
                    ("as measured", foot.known_cop.before, False),
                    ("corrected", foot.known_cop.after, True),
                )
            ]
        )
    return rows


def _loads(robot: Reproduction, foot: int) -> KnownLoads:
    """CoPs around their holes: the shoe's own weight, which moves each a little, taken off."""
    found = robot.manual.feet[foot]
    holes = shoe_and_robot()[0].holes[foot]
    assert holes is not None
    places = np.array([holes.position(load.place) for load in found.loads.loads])
    return KnownLoads(
        foot=_foot(robot, foot, None),
        masses=found.loads.masses,
        force=found.loads.force,
        expected_force=found.loads.expected_force,
        places=places,
        measured=places + found.loads.cop - found.loads.expected_cop,
        corrected=places + found.known_cop.corrected - found.loads.expected_cop,
    )


def _assumptions(robot: Reproduction) -> list[list[SheetFigure]]:
    runs = robot.in_order
    lines = [
        Line(f"run {run.run}", look, run.sources[REFERENCE][0])
        for run, look in zip(runs, RUNS, strict=False)
    ]
    parts = [
        SheetFigure(
            "GRF by the manual calibration, and the weight",
            grf_in_time(lines, robot.data.robot.weight, least=3.0),
            (
                "Bursts, which the floor feels too: at the start, and where a foot carries little.",
                "Between them the scale's error, which the simulated robot has by its file.",
            ),
        )
    ]
    for run in runs:
        found = robot.assumption(run)
        parts.append(
            SheetFigure(
                f"Run {run.run}: CoP {mean_error(found.cop, 'mm', 1e3)}, "
                f"GRF {mean_error(found.grf, 'N')}",
                _plane(robot, run, {**LOOKS, MODELLED: ("model", palette.MEASURED)},
                       (REFERENCE, MODELLED)),
            )
        )  # fmt: skip
    return [parts[start : start + 2] for start in range(0, len(parts), 2)]


def _runs(robot: Reproduction, runs: Sequence[ComparedRun]) -> list[list[SheetFigure]]:
    """A column a run: motion, CoP, GRF."""
    weight = robot.data.robot.weight
    columns = []
    for run in runs:
        lines = [Line(*LOOKS[name], run.sources[name][0]) for name in LOOKS]
        columns.append(
            (
                SheetFigure(f"Run {run.run}: motion", _motion(robot, run)),
                SheetFigure("CoP", _plane(robot, run, LOOKS, tuple(LOOKS))),
                SheetFigure("GRF", grf_in_time(lines, weight)),
            )
        )
    return [list(row) for row in zip(*columns, strict=True)]


def _motion(robot: Reproduction, run: ComparedRun) -> str:
    (stance,) = robot.data.stances[run.run]
    assert stance.angles is not None
    shown = np.linspace(0, len(stance.time) - 1, SNAPSHOTS).round().astype(int)
    bodies = [skeleton(robot.data.robot, stance.angles[index]) for index in shown]
    return snapshots(bodies, stance.time[shown].tolist())


def grf_in_time(lines: Sequence[Line], weight: float, least: float = 0.8) -> str:
    """GRF of several sources, or of several runs, around the weight.

    Args:
        lines: later ones are drawn over earlier ones.
        weight: drawn as a line [N].
        least: no less than this is shown [N].
    """
    with canvas(222.0) as page:
        keys = [line_key(line.look, line.label) for line in lines]
        page.legend([*keys, line_key(WEIGHT, "weight")], left=46.0)
        axes = page.panel(24.0, 164.0, left=52.0)
        axes.axhline(weight, color=WEIGHT.colour.light, linewidth=WEIGHT.width)
        for line in lines:
            draw_line(axes, line.series.time, line.series.grf, line.look)
        every = np.concatenate([[weight], *(line.series.grf for line in lines)])
        low, high = float(np.nanmin(every)), float(np.nanmax(every))
        margin = 0.06 * (high - low) + max(0.0, (least - (high - low)) / 2.0)
        axes.set_ylim(low - margin, high + margin)
        axes.margins(x=0.0)
        y_label(axes, "GRF (N)")
        axes.locator_params(axis="y", nbins=5)
        axes.set_xlabel("time (s)")
        named = ", ".join(readable(line.label) for line in lines)
        return page.svg(f"GRF [N] against time [s] around {weight:.2f} N: {named}.")


def _plane(
    robot: Reproduction,
    run: ComparedRun,
    looks: dict[str, tuple[str, Look]],
    names: Sequence[str],
) -> str:
    support = robot.data.stances[run.run][0].support
    feet = [_foot(robot, 0, None), _foot(robot, 1, support)]
    return cop_plane(feet, [CopPath(*looks[name], run.sources[name][0].cop) for name in names])


def _foot(robot: Reproduction, foot: int, support: DoubleSupport | None) -> FootShape:
    data = robot.data
    shape = data.robot.feet[foot]
    cells = data.shoe.positions[data.shoe.of_foot(foot)]
    here = support.right_to_left if support is not None else np.asarray
    return FootShape(FEET[foot], here(shape.outline), here(shape.sensing_polygon), here(cells))


def _pooled(paper: Paper) -> SheetFigure:
    return _errors(
        paper.robots,
        f"All {len(paper.robots)} robots, and the test of their runs",
        paper.differences(REFERENCE),
    )


def _errors(
    robots: Sequence[Reproduction], title: str, compared: dict[str, Difference]
) -> SheetFigure:
    runs = [run for robot in robots for run in robot.runs]
    bars = []
    for name in (GUESS, MEASURED):
        label, look = LOOKS[name]
        sets = errors_by_set(runs, name, REFERENCE)
        bars += [
            Bar(label, look, label, part == "test", found.grf, found.cop)
            for part, found in sets.items()
        ]
    notes = [
        f"Self-calibration, training against test: {name.upper()} {_sign(found)}"
        for name, found in compared.items()
    ]
    return SheetFigure(title, mae_bars(bars), tuple(notes))


def _sign(found: Difference) -> str:
    word = "n.s." if found.p_value > ALPHA else "differ"
    return f"{word}, p = {found.p_value:.2g}"
