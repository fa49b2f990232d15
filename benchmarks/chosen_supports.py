"""Double supports chosen by what they promise against random ones, over many robots.

    make chosen-supports   (ARGS="--seeds 24")

Every robot of the population calibrates itself in three double supports, chosen in each way, and
each calibration is measured against the truth of the robot's own session in the population: the
same runs for all ways, none of them fitted. What is random is drawn as in the paper; all other
ways are the planner's. Writes its part of docs/evidence/trust.md and of out/trust.json. A session
that stands already is not made again.
"""

from __future__ import annotations

import argparse
import itertools
from collections.abc import Callable, Iterator, Mapping
from concurrent.futures import ProcessPoolExecutor
from dataclasses import asdict, dataclass
from functools import partial
from pathlib import Path

import numpy as np

from chosen_supports_page import page_body, summarise
from chosen_supports_results import Examination, Floor, Result, examine
from pages import write_trust
from population import ROOT, different_robots, make_session, nao, paper_runs, sessions
from shoecal_core.model.double_support import DoubleSupport
from shoecal_core.planning.settings import CHOICES, PlannerSettings
from shoecal_core.planning.supports.draw import draw_supports
from shoecal_core.planning.supports.feasible import Feasible
from shoecal_core.recording.session import Session
from shoecal_core.sensing.sensing import Sensing

OUT = ROOT / "out" / "chosen"
SUPPORTS = 3
NOISE = 5000
"""Added to a robot's seed, so that its sessions here are none of the population's."""


def random_supports(seed: int) -> list[DoubleSupport]:
    """As the paper draws them: whatever passes the checks of one double support."""
    generator = np.random.default_rng([seed, 11])
    return list(itertools.islice(Feasible(nao()[0], PlannerSettings()).draw(generator), SUPPORTS))


def planned_supports(choice: str, seed: int) -> list[DoubleSupport]:
    """As the planner chooses them."""
    robot, shoe = nao()
    settings = PlannerSettings(support_choice=choice)
    return draw_supports(robot, shoe, settings, SUPPORTS, NOISE + seed)


WAYS: Mapping[str, Callable[[int], list[DoubleSupport]]] = {
    "random": random_supports,
    **{choice: partial(planned_supports, choice) for choice in CHOICES},
}


@dataclass(frozen=True)
class Trial:
    """The training runs of one robot in double supports chosen in one way."""

    seed: int
    way: str
    folder: Path


def trials(seeds: int, out: Path) -> Iterator[Trial]:
    """Each robot in each way."""
    for seed in range(1, seeds + 1):
        for way in WAYS:
            yield Trial(seed, way, out / f"seed_{seed:03d}" / way)


def make(trial: Trial) -> Trial:
    """Simulate the session of a trial."""
    supports = WAYS[trial.way](trial.seed)
    make_session(trial.folder, paper_runs(supports), seed=NOISE + trial.seed, robot_seed=trial.seed)
    return trial


def measured(seeds: int, out: Path) -> tuple[list[Result], Floor]:
    """Results of all trials, and what no choice can change."""
    results, floor, sharing = [], [], []
    everything = list(trials(seeds, out))
    for member, session in sessions(different_robots(seeds)):
        examination = Examination.of(member.robot_seed, session)
        floor.append(examination.errors(Sensing(nao()[1], examination.true)))
        sharing.append(examination.sharing())
        results += [
            examine(Session.open(trial.folder), trial.way, examination)
            for trial in everything
            if trial.seed == member.seed
        ]
        print(f"robot {member.seed}: {len(results)} of {len(everything)} measured", flush=True)
    return results, Floor(tuple(floor), np.array(sharing))


def main() -> None:
    """Simulate what is missing, calibrate, write."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seeds", type=int, default=40)
    parser.add_argument("--out", type=Path, default=OUT)
    parser.add_argument("--workers", type=int, default=2)
    args = parser.parse_args()
    missing = [trial for trial in trials(args.seeds, args.out) if not trial.folder.is_dir()]
    with ProcessPoolExecutor(args.workers) as pool:
        for done, trial in enumerate(pool.map(make, missing), start=1):
            print(f"{trial.folder}: {done} of {len(missing)}", flush=True)
    results, floor = measured(args.seeds, args.out)
    summary = summarise(results, floor, list(WAYS))
    write_trust("supports", page_body(summary), asdict(summary))


if __name__ == "__main__":
    main()
