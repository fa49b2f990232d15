"""From a frame on the serial line to the CoP at a subscriber, beside a bare chain of nodes.

    .venv/bin/python benchmarks/live_path.py [--seconds 8] [--rates 100 1000]

Writes the key `live` of out/bench.json and a section of docs/evidence/performance.md.
"""

from __future__ import annotations

import argparse
import json
import os
import shlex
import sys
import tempfile
import time
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import bench_json
from live import session
from live.activity import UNDER_WAY
from live.chains import CHAINS, SESSIONS, Chains
from live.latency import Turn, disturbance, latencies_ms, summary
from live.page import write_page
from live.robot import RATE
from shoecal_core.errors import ShoecalError
from shoecal_ros.common.worker import NICE

ALLOWED = 1.5
"""Times the bare chain's."""
COMMAND = "make live-path"
PRIORITY = 5
REALTIME = (
    "\nBoth chains had real-time priority (`--realtime`, SCHED_FIFO), so that other programs on "
    "the\nmachine do not count; workers never have it.\n"
)
TURN_S = 0.4
"""So long one chain gets frames, then the other: shorter than what makes voltages stale."""
REST_S = 0.02
"""From turn to turn: what is under way arrives."""
WARM_UP_S = 3.0
BEGIN_S = 120.0
"""Longest time for something to get under way."""
ACTIVITIES = ("nothing", "solving", "recording", "planning")


def measure(chains: Chains, activity: str, rate: float, seconds: float) -> list[Turn]:
    """Both chains in turns."""
    turns = []
    for index in range(2 * round(seconds / TURN_S)):
        chain = CHAINS[index % 2]
        sent = chains.lines[chain].send(rate, round(rate * TURN_S))
        turns.append(Turn(chain, activity, rate, sent))
        time.sleep(REST_S)
    return turns


def run(folder: Path, rates: Sequence[float], seconds: float, *, realtime: bool) -> list[Turn]:
    """All turns, and what was heard of them."""
    session.make(folder / SESSIONS / session.NAME)
    if realtime:
        # Every process that is started from now on inherits it; workers give it back.
        os.sched_setscheduler(0, os.SCHED_FIFO, os.sched_param(PRIORITY))
    turns = []
    with Chains(folder) as chains:
        time.sleep(WARM_UP_S)
        for rate in rates:
            measure(chains, "", rate, WARM_UP_S)
        for activity in ACTIVITIES:
            _begin(chains, activity)
            for rate in rates:
                print(f"{activity}, {rate:g} Hz", flush=True)
                turns += measure(chains, activity, rate, seconds)
            _end(chains, activity)
        heard = chains.heard()
    for turn in turns:
        turn.latency_ms = latencies_ms(turn.sent, *heard[turn.chain])
    return turns


def _begin(chains: Chains, activity: str) -> None:
    if activity == "planning":
        chains.start_node("planner", {})
    if activity == "nothing":
        return
    chains.start(activity, "-m", "live.activity", activity)
    deadline = time.monotonic() + BEGIN_S
    while UNDER_WAY not in chains.log(activity).read_text():
        # The calibrator begins nothing without voltages.
        measure(chains, "", 100.0, TURN_S)
        if time.monotonic() > deadline:
            said = " | ".join(chains.log(activity).read_text().splitlines()[-3:])
            raise ShoecalError(f"{activity} does not begin within {BEGIN_S:g} s; it said: {said}")


def _end(chains: Chains, activity: str) -> None:
    if activity != "nothing":
        chains.stop(activity)
    if activity == "planning":
        chains.stop("planner")


def figures_of(turns: Sequence[Turn], rates: Sequence[float]) -> dict[str, Any]:
    """What goes into out/bench.json; the ratios are the worst of all rates."""
    found = {
        activity: {f"{rate:g}": summary(turns, activity, rate) for rate in rates}
        for activity in ACTIVITIES
    }
    quiet = found["nothing"]

    def disturbed(activity: str, figure: str) -> float:
        """With an activity over without it."""
        return max(disturbance(one, quiet[rate], figure) for rate, one in found[activity].items())

    every = [one for rates_of in found.values() for one in rates_of.values()]
    return {
        "vs_relay_median": max(one["vs_relay_median"] for one in quiet.values()),
        "vs_relay_p99": max(one["vs_relay_p99"] for one in quiet.values()),
        **{f"while_{one}": disturbed(one, "shoecal_median") for one in ACTIVITIES[1:]},
        **{f"while_{one}_p99": disturbed(one, "shoecal_p99") for one in ACTIVITIES[1:]},
        **{f"bare_while_{one}_p99": disturbed(one, "bare_p99") for one in ACTIVITIES[1:]},
        "frames": sum(len(turn.sent) for turn in turns if turn.chain == CHAINS[0]),
        "lost": sum(one["shoecal_lost"] for one in every),
        "bare_lost": sum(one["bare_lost"] for one in every),
        "activities": found,
    }


def main(arguments: Sequence[str] | None = None) -> int:
    """Measure, write, and fail where a target is missed."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seconds", type=float, default=8.0, help="a chain, rate and activity")
    parser.add_argument("--rates", type=float, nargs="+", default=[100.0, 1000.0])
    parser.add_argument(
        "--realtime", action="store_true",
        help="both chains at real-time priority, where other programs keep the machine busy",
    )  # fmt: skip
    given = sys.argv[1:] if arguments is None else arguments
    args = parser.parse_args(given)
    with tempfile.TemporaryDirectory(prefix="shoecal-live-") as folder:
        turns = run(Path(folder), args.rates, args.seconds, realtime=args.realtime)
    figures = figures_of(turns, args.rates)
    bench_json.record("live", figures)
    write_page(
        figures, args.seconds, ALLOWED,
        joints=RATE, turn=TURN_S, frames=figures["frames"], nice=NICE,
        load=os.getloadavg()[0], priority=REALTIME if args.realtime else "",
        command=COMMAND + (f' ARGS="{shlex.join(given)}"' if given else ""),
    )  # fmt: skip
    print(json.dumps(figures, indent=1))
    targets = ["vs_relay_median", "vs_relay_p99", *(f"while_{one}" for one in ACTIVITIES[1:])]
    missed = [key for key in targets if not figures[key] <= ALLOWED]
    for key in missed:
        print(f"missed: {key} at most {ALLOWED:g}")
    return 1 if missed else 0


if __name__ == "__main__":
    sys.exit(main())
