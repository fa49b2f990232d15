"""No false alarm on another robot: clean sessions of Wren, another shoe and other motions.

    .venv/bin/python benchmarks/clean_sessions.py [--seeds 20] [--jobs 2]

Wren is a made-up robot, its shoe has three cells a foot: nothing of the diagnosis was tried on it
while it was made. Every seed draws supports, gains, offsets, noise and an engine; nothing else
differs from the model. Writes a table of docs/evidence/diagnosis.md and the key `clean_sessions`
of out/bench.json.
"""

from __future__ import annotations

import argparse
import os
import tempfile
from collections.abc import Sequence
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path
from typing import NamedTuple

import numpy as np

from blind.intervals import clopper_pearson
from blind.world import draw_sections, write_reality
from pages import EVIDENCE, Row, markdown, record, write_section
from shoecal_core.diagnosis.diagnose import diagnose
from shoecal_core.planning.motion_sets import PlannedRun
from shoecal_core.planning.settings import PlannerSettings
from shoecal_core.planning.supports.draw import draw_supports
from shoecal_core.robot.robot_file import load_robot
from shoecal_core.shoe.shoe_file import load_shoe
from shoecal_core.workflows.simulated_session import SimulationPlan, simulate_session
from shoecal_core.workspace import config_dir

MOTIONS = (
    ("landmarks", "train"), ("reversed", "train"), ("hold", "train"), ("torso_tilt", "train"),
    ("unload_right", "train"), ("landmarks", "test"), ("torso_height", "test"),
)  # fmt: skip
"""Not the thorough set."""
RATE_HZ = 80.0


class Outcome(NamedTuple):
    """What was said of one clean session; gaps over their floors."""

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
    world = draw_sections(np.random.default_rng([seed, 7]))
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
        told.verdict,
        told.gap.cop_mae_mm / told.gap.cop_floor_mm,
        told.gap.grf_mae_n / told.gap.grf_floor_n,
    )


def verdicts(outcomes: Sequence[Outcome]) -> list[Row]:
    """How often each verdict was given, and the gaps then: median (least to most)."""
    rows: list[Row] = []
    for verdict in sorted({one.verdict for one in outcomes}):
        those = [one for one in outcomes if one.verdict == verdict]
        low, high = clopper_pearson(len(those), len(outcomes))
        rows.append(
            {
                "verdict": verdict,
                "sessions": f"{len(those)} of {len(outcomes)}",
                "95 % interval": f"{low:.0%} to {high:.0%}",
                "CoP gap over its floor": _spread([one.cop for one in those]),
                "GRF gap over its floor": _spread([one.grf for one in those]),
            }
        )
    return rows


def _spread(values: Sequence[float]) -> str:
    return f"{np.median(values):.2f} ({min(values):.2f} to {max(values):.2f})"


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
    rows = verdicts(outcomes)
    record("clean_sessions", rows)
    write_section("clean-sessions", markdown(rows), EVIDENCE / "diagnosis.md")


if __name__ == "__main__":
    main()
