"""No false alarm on another robot: clean sessions of Wren, another shoe and other motions.

    .venv/bin/python benchmarks/clean_sessions.py [--seeds 20] [--jobs 2]

Wren is a made-up robot, its shoe has three cells a foot: nothing of the diagnosis was tried on it
while it was made. Every seed draws supports, gains, offsets, noise and an engine; nothing else
differs from the model. Writes a section of docs/evidence/diagnosis.md and the key `clean_sessions`
of out/bench.json.
"""

from __future__ import annotations

import argparse
import os
import tempfile
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from blind.intervals import clopper_pearson
from blind.world import draw_world, write_reality
from pages import EVIDENCE, record, table, write_section
from shoecal_core.commands.simulated_session import SimulationPlan, simulate_session
from shoecal_core.diagnosis.diagnose import diagnose
from shoecal_core.model.robot_file import load_robot
from shoecal_core.planning.settings import PlannerSettings
from shoecal_core.planning.standard import PlannedRun
from shoecal_core.planning.supports.draw import draw_supports
from shoecal_core.sensing.shoe import load_shoe
from shoecal_core.workspace import config_dir

MOTIONS = (
    ("landmarks", "train"), ("reversed", "train"), ("hold", "train"), ("torso_tilt", "train"),
    ("unload_right", "train"), ("landmarks", "test"), ("torso_height", "test"),
)  # fmt: skip
"""Not the standard set."""
RATE_HZ = 80.0


@dataclass(frozen=True)
class Outcome:
    """What was said of one clean session; gaps over their floors."""

    seed: int
    verdict: str
    cop: float
    grf: float


def outcome(seed: int) -> Outcome:
    """Simulate and diagnose one session."""
    robots, shoes = config_dir() / "robots", config_dir() / "shoes"
    shoe = load_shoe(shoes / "wren_shoe.yaml")
    robot = load_robot(robots / "wren.yaml", shoe)
    settings = PlannerSettings()
    supports = draw_supports(robot, shoe, settings, len(MOTIONS), seed)
    world = draw_world(np.random.default_rng([seed, 7]))
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        plan = SimulationPlan(
            robot=robot,
            shoe=shoe,
            reality=write_reality(folder / "clean.yaml", world),
            settings=settings,
            runs=[
                PlannedRun(support, motion, hint)
                for support, (motion, hint) in zip(supports, MOTIONS, strict=True)
            ],
            rate=RATE_HZ,
            seed=seed,
            robot_seed=seed,
        )
        session = simulate_session(plan, folder / "session", lambda _text, _share: None)
        told = diagnose(session)
    return Outcome(
        seed,
        told.verdict,
        told.gap.cop_mae_mm / told.gap.cop_floor_mm,
        told.gap.grf_mae_n / told.gap.grf_floor_n,
    )


def section(outcomes: list[Outcome], seeds: int) -> str:
    """The part of the page."""
    alarms = [one for one in outcomes if one.verdict != "no_gap"]
    low, high = clopper_pearson(len(alarms), len(outcomes))
    rows = [["verdict", "sessions", "CoP gap over its floor", "GRF gap over its floor"]]
    for verdict in sorted({one.verdict for one in outcomes}):
        those = [one for one in outcomes if one.verdict == verdict]
        cop, grf = ([getattr(one, name) for one in those] for name in ("cop", "grf"))
        rows.append(
            [
                verdict,
                str(len(those)),
                f"{np.median(cop):.2f} ({min(cop):.2f} to {max(cop):.2f})",
                f"{np.median(grf):.2f} ({min(grf):.2f} to {max(grf):.2f})",
            ]
        )
    return f"""\
## Clean sessions of another robot

`make clean-sessions ARGS="--seeds {seeds}"`: the made-up robot Wren with three cells per foot,
{len(MOTIONS)} runs at {RATE_HZ:.0f} Hz other than the standard set, no fault. False alarms:
{len(alarms)} of {len(outcomes)} (95 % interval {low:.0%} to {high:.0%}).

{table(rows)}
"""


def main() -> None:
    """Simulate, diagnose, write."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seeds", type=int, default=20)
    parser.add_argument("--jobs", type=int, default=os.cpu_count() or 1)
    args = parser.parse_args()
    outcomes = []
    with ProcessPoolExecutor(args.jobs) as pool:
        for one in pool.map(outcome, range(1, args.seeds + 1)):
            outcomes.append(one)
            print(one, flush=True)
    figures = {
        "sessions": len(outcomes),
        "alarms": sum(one.verdict != "no_gap" for one in outcomes),
        "outcomes": [vars(one) for one in outcomes],
    }
    record("clean_sessions", figures)
    page = EVIDENCE / "diagnosis.md"
    write_section("clean-sessions", section(outcomes, args.seeds), page, "# Diagnosis\n")


if __name__ == "__main__":
    main()
