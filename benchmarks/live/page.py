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

Latency from before a frame of eight cells is written into a pseudo-terminal to a subscriber's
callback of `/shoe/cop`: real driver and calibrator, joint angles at {joints:g} Hz, Fast DDS, one
process per node. For comparison a bare chain of two default rclpy nodes relays messages of the
same size over as many hops. Both get frames in turns of {turn:g} s, {seconds:g} s per chain, rate
and row.

{table}

- *solving*: repeated diagnoses by the calibrator's worker; *recording*: a self-calibration
  records a run; *planning*: repeated plans.
- *Ratio*: shoecal over the bare chain. *With/without*: relative to shoecal without other work;
  *bare's with/without* likewise. All processes share {cores} cores: what grows in both comes from
  sharing.
- Target at most {allowed:g}. Above it: {above}.
- Frames lost of {frames}: shoecal {lost_shoecal:.0f}, bare {lost_bare:.0f}.

In the calibrator a separate thread handles readings and joint angles, another one writes runs;
workers have the lowest priority (nice {nice}).
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
