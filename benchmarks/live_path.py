"""From a frame on the serial line to the CoP at a subscriber, beside a bare chain of nodes.

    make live-path   (ARGS="--seconds 8 --rates 100 1000")

Writes the key `live` of out/bench.json and a section of docs/evidence/performance.md; fails where
the chain takes more than 1.5 times as long as the bare one, and longer by more than 0.25 ms.
"""

from __future__ import annotations

import argparse
import os
import sys
import tempfile
import time
from collections.abc import Mapping, Sequence
from pathlib import Path

import pages
from live.chains import CHAINS, Chains
from live.latency import Turn, latencies_ms, summary
from live.robot import RATE

ALLOWED = 1.5
"""Times the bare chain's."""
ALLOWED_MS = 0.25
"""Or so much longer: a quarter of the period at 1 kHz, where a bare chain takes a third of a
millisecond and the work on a frame, which it does not do, 0.18 ms."""
PRIORITY = 5
TURN_S = 0.4
"""So long one chain gets frames, then the other: shorter than what makes voltages stale."""
REST_S = 0.02
"""From turn to turn: what is under way arrives."""
WARM_UP_S = 3.0

BODY = """\
## The live path: from a frame to its CoP

Made by `make live-path`{realtime}.

Latency from before a frame of eight cells is written into a pseudo-terminal to a subscriber's
callback of `/shoe/cop`: real driver and calibrator, joint angles at {joints:g} Hz, Fast DDS, one
process a node. For comparison a bare chain of two default rclpy nodes relays messages of the same
size over as many hops. Both get frames in turns of {turn:g} s, {seconds:g} s a chain and rate.
*Ratio*: over the bare chain, at most {allowed:g} wanted, or at most {allowed_ms:g} ms longer: at
1 kHz the bare chain takes so little that the work on a frame (decoding, joining, forces, CoP),
which it does not do, counts for more. *Lost*: frames that were not heard.

{table}

{machine}
"""
REALTIME = ", both chains with real-time priority (`--realtime`, SCHED_FIFO)"


def measure(chains: Chains, rate: float, seconds: float) -> list[Turn]:
    """Both chains in turns."""
    turns = []
    for index in range(2 * round(seconds / TURN_S)):
        chain = CHAINS[index % 2]
        sent = chains.lines[chain].send(rate, round(rate * TURN_S))
        turns.append(Turn(chain, rate, sent))
        time.sleep(REST_S)
    return turns


def run(folder: Path, rates: Sequence[float], seconds: float) -> list[Turn]:
    """All turns, and what was heard of them."""
    turns = []
    with Chains(folder) as chains:
        time.sleep(WARM_UP_S)
        for rate in rates:
            measure(chains, rate, WARM_UP_S)
            print(f"{rate:g} Hz", flush=True)
            turns += measure(chains, rate, seconds)
        heard = chains.heard()
    for turn in turns:
        turn.latency_ms = latencies_ms(turn.sent, *heard[turn.chain])
    return turns


def main(arguments: Sequence[str] | None = None) -> int:
    """Measure, write, and fail where a ratio is missed."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--seconds", type=float, default=8.0, help="a chain and rate")
    parser.add_argument("--rates", type=float, nargs="+", default=[100.0, 1000.0])
    parser.add_argument(
        "--realtime", action="store_true",
        help="both chains at real-time priority, where other programs keep the machine busy",
    )  # fmt: skip
    args = parser.parse_args(arguments)
    if args.realtime:
        # Every process that is started from now on inherits it; workers give it back.
        os.sched_setscheduler(0, os.SCHED_FIFO, os.sched_param(PRIORITY))
    with tempfile.TemporaryDirectory(prefix="shoecal-live-") as folder:
        turns = run(Path(folder), args.rates, args.seconds)
    rows = [summary(turns, rate) for rate in args.rates]
    pages.record("live", rows)
    body = BODY.format(
        realtime=REALTIME if args.realtime else "", joints=RATE, turn=TURN_S,
        seconds=args.seconds, allowed=ALLOWED, allowed_ms=ALLOWED_MS,
        table=pages.markdown(rows), machine=pages.machine(),
    )  # fmt: skip
    pages.write_section("live", body, pages.PERFORMANCE)
    missed = [row for row in rows if any(_misses(row, part) for part in ("median", "99 %"))]
    for row in missed:
        bound = f"ratios at most {ALLOWED:g}, or {ALLOWED_MS:g} ms longer"
        print(f"missed: {bound}, at {row['rate [Hz]']:g} Hz")
    return 1 if missed else 0


def _misses(row: Mapping[str, float], part: str) -> bool:
    longer_ms = row[f"{part} [ms]"] - row[f"bare {part} [ms]"]
    return row[f"ratio, {part}"] > ALLOWED and longer_ms > ALLOWED_MS


if __name__ == "__main__":
    sys.exit(main())
