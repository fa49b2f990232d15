"""An effect of your own in the simulation: a cable from the ceiling to the robot's torso.

    .venv/bin/python examples/simulate_effect.py --out out/examples

The cable lifts the robot by 20 N for each metre that its torso is further forward.
"""

import argparse
from dataclasses import replace
from pathlib import Path

import shoecal_core as sc
from shoecal_core.cli.progress import shown_progress
from shoecal_core.planning.motion_sets import listed_runs
from shoecal_core.planning.settings import PlannerSettings
from shoecal_core.simulation.disturbances import MovingRobot
from shoecal_core.simulation.effects.effect import Effect
from shoecal_core.simulation.reality_file import load_reality
from shoecal_core.workflows.simulated_session import SimulationPlan, simulate_session
from shoecal_core.workspace import config_dir

STIFFNESS = 20.0
"""N/m."""
SUPPORTS = [(-0.02, -0.12, -0.26), (0.03, -0.16, 0.21), (-0.01, -0.104, 0.21), (0.05, -0.11, -0.3)]
"""Right foot in the left foot's frame: x forward, y to the left [m], yaw [rad]."""


class Cable(Effect):
    """A disturbance of the physics: it may push any link of MuJoCo's model."""

    def disturbances(self) -> tuple["Cable"]:
        """What acts on the robot while it moves."""
        return (self,)

    def act(self, sim: MovingRobot, time: float) -> None:  # noqa: ARG002
        """Called in every step of the physics, in which the left foot stands at the origin."""
        torso = sim.physics.model.body("base_link").id
        sim.data.xfrc_applied[torso, 2] += STIFFNESS * sim.data.xipos[torso, 0]


def simulated(folder: Path) -> sc.Session:
    """A session of four runs of a NAO that hangs on the cable; made once."""
    if folder.exists():
        return sc.Session.open(folder)
    shoe = sc.load_shoe(config_dir() / "shoes/nao_shoe.yaml")
    robot = sc.load_robot(config_dir() / "robots/nao.yaml", shoe)
    reality = replace(load_reality(config_dir() / "realities/default.yaml"), effects=(Cable(),))
    runs = listed_runs([sc.DoubleSupport(*one) for one in SUPPORTS], ["landmarks"] * len(SUPPORTS))
    plan = SimulationPlan(
        robot, shoe, reality, PlannerSettings(), runs, rate=100.0, seed=1, robot_seed=1
    )
    with shown_progress() as progress:
        return simulate_session(plan, folder, progress)


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--out", type=Path, default=Path("out/examples"), help="folder of results")
    session = simulated(parser.parse_args().out / "tether")
    print(f"{session.folder}: {len(session.runs)} runs")
