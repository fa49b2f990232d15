"""How far the simulated reality is from its model, by seed and by cause.

    python benchmarks/reality_gap.py                    # the default reality, seeds 1 to 5
    python benchmarks/reality_gap.py --causes           # each cause alone, and each left out

Plans the main job's motions, lets the simulated robot follow them, and compares with the truth
what the nominal model makes of the encoders: CoP in the left sole's frame, and weight.
"""

from __future__ import annotations

import argparse
import dataclasses
import time
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from shoecal_core.model.joint_trajectory import JointTrajectory
from shoecal_core.model.kinematics import Kinematics
from shoecal_core.model.robot import Robot
from shoecal_core.model.robot_file import load_robot
from shoecal_core.planning.motion import Motion
from shoecal_core.planning.planner import Planner
from shoecal_core.planning.settings import PlannerSettings
from shoecal_core.planning.supports.draw import draw_supports
from shoecal_core.sensing.shoe import Shoe, load_shoe
from shoecal_core.simulation.drawn import draw
from shoecal_core.simulation.reality import Reality
from shoecal_core.simulation.reality_file import load_reality
from shoecal_core.simulation.robot import SimulatedRobot
from shoecal_core.simulation.samples import run
from shoecal_core.workspace import config_dir

CAUSES: Mapping[str, tuple[str, ...]] = {
    "scale": ("body.weight_error_n",),
    "masses of links": ("body.mass_error_std_fraction", "body.mass_error_fraction"),
    "CoM of links": ("body.com_error_std_m", "body.com_error_m"),
    "encoder zeros": ("joints.encoder_error_std_rad", "joints.encoder_error_rad"),
    "encoder steps": ("joints.encoder_resolution_rad",),
    "play of gears": ("joints.play_rad",),
    "compliance of gears": ("joints.compliance_rad_per_nm",),
    "friction of motors": ("servo.friction_fraction",),
    "cells that give way": ("cells.stiffness_n_per_m", "shoes.clamp_share"),
}


@dataclass(frozen=True)
class Gap:
    """Of one motion: CoP [mm], GRF [N] as MAE and its standard deviation; times real time."""

    cop: float
    cop_std: float
    grf: float
    grf_std: float
    foot_slip: float
    speed: float


def measure(robot: Robot, shoe: Shoe, rules: Reality, seed: int, motion: Motion) -> Gap:
    """Let the robot that the seed draws follow one motion."""
    sim = SimulatedRobot(robot, shoe, draw(rules, robot, shoe, seed), np.random.default_rng(seed))
    sim.place(motion.positions[0])
    before = sim.snapshot().sole_position
    trajectory = JointTrajectory(motion.joint_names, motion.time, motion.positions)
    begin = time.process_time()
    samples = run(sim, trajectory, 100.0)
    spent = time.process_time() - begin
    modelled = Kinematics(robot).states(samples.joints.angles).cop[:, 0]
    cop = 1e3 * np.linalg.norm(samples.truth.cop - modelled, axis=1)
    grf = np.abs(samples.truth.grf - robot.weight)
    slip = 1e3 * np.linalg.norm((sim.snapshot().sole_position - before)[:, :2], axis=1).max()
    return Gap(
        float(cop.mean()), float(cop.std()), float(grf.mean()), float(grf.std()), float(slip),
        (samples.time[-1] - samples.time[0]) / spent,
    )  # fmt: skip


def mean(gaps: Iterable[Gap]) -> Gap:
    return Gap(*np.mean([dataclasses.astuple(gap) for gap in gaps], axis=0))


def show(name: str, gap: Gap) -> None:
    print(
        f"{name:32} CoP {gap.cop:5.2f} ± {gap.cop_std:4.2f} mm   GRF {gap.grf:5.3f} ± "
        f"{gap.grf_std:5.3f} N   feet move {gap.foot_slip:4.1f} mm   {gap.speed:5.1f} x real time",
        flush=True,
    )


def with_causes(rules: Reality, source: Reality, keys: Iterable[str]) -> Reality:
    """Rules with some keys as they are in another reality."""
    for key in keys:
        section, name = key.split(".")
        value = getattr(getattr(source, section), name)
        changed = dataclasses.replace(getattr(rules, section), **{name: value})
        rules = dataclasses.replace(rules, **{section: changed})
    return rules


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--seeds", type=int, nargs="+", default=[1, 2, 3, 4, 5])
    parser.add_argument("--reality", type=Path, help="changes to the default reality")
    parser.add_argument("--causes", action="store_true", help="each cause alone and left out")
    arguments = parser.parse_args()
    config = config_dir()
    shoe = load_shoe(config / "shoes" / "nao_shoe.yaml")
    robot = load_robot(config / "robots" / "nao.yaml", shoe)
    default = config / "realities" / "default.yaml"
    rules = load_reality(default, arguments.reality)
    settings = PlannerSettings()
    planner = Planner(robot, settings)
    plans = [
        [planner.plan(support) for support in draw_supports(robot, shoe, settings, 5, seed)]
        for seed in arguments.seeds
    ]

    def gap(reality: Reality) -> Gap:
        return mean(
            measure(robot, shoe, reality, seed, motion)
            for seed, motions in zip(arguments.seeds, plans, strict=True)
            for motion in motions
        )

    if arguments.causes:
        perfect = load_reality(default, config / "realities" / "perfect.yaml")
        show("the motion alone", gap(perfect))
        for name, keys in CAUSES.items():
            show(f"{name} alone", gap(with_causes(perfect, rules, keys)))
        for name, keys in CAUSES.items():
            show(f"without {name}", gap(with_causes(rules, perfect, keys)))
        return
    for seed, motions in zip(arguments.seeds, plans, strict=True):
        gaps = [measure(robot, shoe, rules, seed, motion) for motion in motions]
        for number, one in enumerate(gaps, start=1):
            show(f"seed {seed} run {number}", one)
        show(f"seed {seed}", mean(gaps))


if __name__ == "__main__":
    main()
