"""What a screening left out and found, as parts of a report."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from shoecal_core.report.page import Group, Picture
from shoecal_core.report.palette import INK, RULE, STEPS
from shoecal_core.report.recorded_tables import cause_name, findings_table, left_out_table
from shoecal_core.report.svg import LINE, area_key, canvas, readable
from shoecal_core.screening.result import Screening

ROW, BOTTOM = 20.0, 34.0
PER_LINE = 3
"""Entries in one line of the legend."""
APART = 3
"""Steps between the colours of two causes that follow each other."""
LEAST_SHOWN = 0.004
"""Part of the width that even the shortest stretch gets."""


@dataclass(frozen=True)
class RunSpan:
    """One run.

    Attributes:
        label: of it.
        start, end: of its samples [s].
        stretches: first and last time of what was left out, by cause [s].
    """

    label: str
    start: float
    end: float
    stretches: Mapping[str, Sequence[tuple[float, float]]]


def left_out_in_time(runs: Sequence[RunSpan]) -> str:
    """One line a run: what counts, and what was left out for which cause."""
    causes = list(dict.fromkeys(cause for run in runs for cause in run.stretches))
    colours = {cause: STEPS[APART * index % len(STEPS)] for index, cause in enumerate(causes)}
    keys = [area_key(RULE, "counts")]
    keys += [area_key(colour, cause) for cause, colour in colours.items()]
    top = LINE * -(-len(keys) // PER_LINE) + 8.0
    height = ROW * len(runs)
    left = 14.0 + 5.6 * max(len(run.label) for run in runs)
    low, high = min(run.start for run in runs), max(run.end for run in runs)
    with canvas(top + height + BOTTOM) as page:
        page.legends(keys, PER_LINE, left=left - 6.0)
        axes = page.panel(top, height, left=left)
        axes.grid(visible=False, axis="y")
        least = LEAST_SHOWN * (high - low)
        for row, run in enumerate(runs):
            axes.barh(row, run.end - run.start, 0.6, left=run.start, color=RULE.light,
                      edgecolor="none")  # fmt: skip
            for cause, found in run.stretches.items():
                # Each cause has a lane of its own, in the order of the legend.
                lane = 0.6 / len(causes)
                axes.broken_barh(
                    [(start, max(end - start, least)) for start, end in found],
                    (row - 0.3 + lane * causes.index(cause), lane),
                    facecolors=colours[cause].light, edgecolor="none",
                )  # fmt: skip
        axes.set_xlim(low, high)
        axes.set_ylim(len(runs) - 0.4, -0.6)
        axes.set_yticks(range(len(runs)), [readable(run.label) for run in runs])
        axes.tick_params(axis="y", length=0.0, labelcolor=INK.light)
        axes.set_xlabel("time since the run's start (s)")
        listed = "; ".join(
            f"{run.label}: "
            + (", ".join(f"{cause} {len(found)} ×" for cause, found in run.stretches.items())
               or "nothing")
            for run in runs
        )  # fmt: skip
        return page.svg(f"When samples were left out. {listed}.")


def left_out_group(
    screening: Screening, ends: Mapping[int, float], title: str = "", text: str = ""
) -> Group:
    """What does not count, when, and what else was found.

    Args:
        screening: of a recording.
        ends: when each run ends, since its start [s].
        title: of the group.
        text: what else there is to say.
    """
    counted = sum(screening.samples.values())
    lost = sum(one.samples for one in screening.left_out)
    if not counted:
        summary = "The recording was not screened."
    elif lost:
        summary = f"{lost} of {counted} samples do not count ({100.0 * lost / counted:.1f} %)."
    else:
        summary = f"Nothing: all {counted} samples count."
    picture = left_out_spans(screening, ends)
    tables = (left_out_table(screening), findings_table(screening))
    return Group(
        title,
        f"{summary} {text}".strip(),
        pictures=() if picture is None else (picture,),
        tables=tuple(table for table in tables if table is not None),
    )


def left_out_spans(screening: Screening, ends: Mapping[int, float]) -> Picture | None:
    """When samples were left out; None where every one counts.

    Args:
        screening: of a recording.
        ends: when each run ends, since its start [s].
    """
    if not screening.left_out:
        return None
    lost: dict[int, dict[str, list[tuple[float, float]]]] = {}
    for one in screening.left_out:
        found = lost.setdefault(one.run, {}).setdefault(cause_name(one.fault), [])
        found.extend(one.stretches)
    runs = []
    for run in screening.samples:
        own = lost.get(run, {})
        last = [end for found in own.values() for _, end in found]
        runs.append(RunSpan(f"run {run}", 0.0, max([ends.get(run, 0.0), *last]), own))
    shown = [run for run in runs if run.end > 0.0]
    if not shown:
        return None
    return Picture(
        "Samples left out, in time",
        left_out_in_time(shown),
        "Each cause has a lane of its own, from above as in the legend.",
    )
