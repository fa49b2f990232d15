"""The section of docs/evidence/performance.md."""

from __future__ import annotations

import os
import platform
from collections.abc import Mapping
from typing import Any

import pages
from live.latency import disturbance

BODY = """\
## The live path: from a frame to its CoP

Made by `{command}`.

From just before a frame of eight cells is written into a pseudo-terminal to when a subscriber's
callback has `/shoe/cop`: the real driver, the real calibrator under a calibration in force, joint
angles at {joints:g} Hz, Fast DDS, each node its own process. Beside it a bare chain of two nodes
that relay messages of the same size over as many hops: the first publishes a ready message for
every frame that comes on a pseudo-terminal of its own, the second answers each with a point. They
are nodes of rclpy with rclpy's defaults: its executor with one thread, its events at every topic,
its services for parameters. Both chains get frames in turns of {turn:g} s, {seconds:g} s a chain,
rate and row, and end at one subscriber.

{table}

- *solving*: diagnoses of a session one after the other, by the calibrator's worker;
  *recording*: a self-calibration that records a run; *planning*: plans of the planner one after
  the other.
- Ratio: shoecal's over the bare chain's. *With/without*: shoecal's median, and its 99 %, over its
  own while nothing goes on. *Bare's with/without*: the bare chain's 99 % likewise. It grows with
  what goes on, too, though its nodes take no part in that: all processes share {cores} cores. What
  grows there as here comes from sharing the cores, not from the suite's nodes.
- Asked for at most {allowed:g} as a ratio, and of a median with to one without. Above it: {above}.
- Frames lost of {frames}: shoecal {lost_shoecal:.0f}, bare {lost_bare:.0f}.

Readings and joint angles have a thread of their own in the calibrator, which waits for nothing
else; one instant is computed in plain numbers; a run is written by another thread; workers have
the lowest priority (nice {nice}).
{priority}
Measured on {cores} cores ({machine}) with a load of {load:.1f}, Python {python}.
"""


def write_page(
    figures: Mapping[str, Any], seconds: float, allowed: float, **values: object
) -> None:
    """Write the section.

    Args:
        figures: as in out/bench.json.
        seconds: of each measurement.
        allowed: ratio.
        values: for the text.
    """
    rows = [["", "rate [Hz]", "median [ms]", "99 % [ms]", "bare median [ms]", "bare 99 % [ms]",
             "ratio of medians", "ratio of 99 %", "with/without", "with/without, 99 %",
             "bare's with/without, 99 %"]]  # fmt: skip
    quiet = figures["activities"]["nothing"]
    for activity, rates in figures["activities"].items():
        for rate, one in rates.items():
            rows.append(
                [
                    activity,
                    rate,
                    *(
                        f"{one[f'{chain}_{what}_ms']:.2f}"
                        for chain in ("shoecal", "bare")
                        for what in ("median", "p99")
                    ),
                    f"{one['vs_relay_median']:.2f}",
                    f"{one['vs_relay_p99']:.2f}",
                    *(
                        f"{disturbance(one, quiet[rate], figure):.2f}"
                        for figure in ("shoecal_median", "shoecal_p99", "bare_p99")
                    ),
                ]
            )
    above = [
        f"{names} {value:.2f} ({activity}, {rate} Hz)"
        for activity, rates in figures["activities"].items()
        for rate, one in rates.items()
        for names, value in (
            ("medians", one["vs_relay_median"]),
            ("99 %", one["vs_relay_p99"]),
            ("median with/without", disturbance(one, quiet[rate], "shoecal_median")),
        )
        if value > allowed
    ]
    body = BODY.format(
        allowed=allowed,
        above="; ".join(above) or "none",
        seconds=seconds,
        table=pages.table(rows),
        lost_shoecal=figures["lost"],
        lost_bare=figures["bare_lost"],
        cores=os.cpu_count(),
        machine=platform.machine(),
        python=platform.python_version(),
        **values,
    )
    pages.write_performance("live", body)
