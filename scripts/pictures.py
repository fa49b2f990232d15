"""Draw docs/images: the robot as it moves in a self-calibration, planned and rendered here.

`make pictures`. What is seen is a plan: joint angles from the planner, limbs as thick as their
mass tells, the force at the ground projection of the CoM. Nothing in it was measured.
"""

from __future__ import annotations

import argparse
import io
from pathlib import Path

import numpy as np
from PIL import Image

from shoecal_core.planning.checking.check import check_motion
from shoecal_core.planning.planner import Planner
from shoecal_core.planning.settings import PlannerSettings
from shoecal_core.planning.supports.draw import draw_supports
from shoecal_core.report.plan_content import PlannedMotion
from shoecal_core.report.plan_strip import instant_of
from shoecal_core.report.scene.offscreen import draw
from shoecal_core.report.scene.stills import StillInstant, views
from shoecal_core.robot.robot_file import load_robot, shoe_file_of
from shoecal_core.shoe.shoe import Shoe, load_shoe

HERE = Path(__file__).resolve().parent.parent
ROBOT = HERE / "config" / "robots" / "nao.yaml"
OUT = HERE / "docs" / "images"
STILLS = (0.0, 0.3, 0.55, 0.8)
"""Shares of the motion shown beside each other."""
STILL_SIZE = (420, 560)
FRAMES, FRAME_MS, FRAME_SIZE = 48, 100, (300, 400)


def planned(robot_file: Path, seed: int) -> tuple[PlannedMotion, Shoe]:
    """One motion of the robot in a double support that the seed draws."""
    shoe = load_shoe(shoe_file_of(robot_file))
    robot, settings = load_robot(robot_file, shoe), PlannerSettings()
    (support,) = draw_supports(robot, shoe, settings, 1, seed)
    planner = Planner(robot, settings)
    motion = planner.plan(support)
    report = check_motion(planner.legs, motion, settings)
    return PlannedMotion("motion", robot, motion, report, settings), shoe


def at(
    motion: PlannedMotion, shares: np.ndarray[tuple[int], np.dtype[np.float64]]
) -> list[StillInstant]:
    """Instants at shares of the motion's time."""
    last = len(motion.motion.time) - 1
    return [instant_of(motion, round(share * last)) for share in shares.tolist()]


def images(
    motion: PlannedMotion, shoe: Shoe, shown: list[StillInstant], size: tuple[int, int]
) -> list[Image.Image]:
    """Each instant as a picture on a clear ground."""
    files = draw(views(motion.robot, shoe, shown, size), "png")
    return [Image.open(io.BytesIO(file)) for file in files]


def main() -> None:
    """Draw all pictures."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seed", type=int, default=1, help="draws the double support")
    parser.add_argument("--out", type=Path, default=OUT, help="folder for the pictures")
    args = parser.parse_args()
    args.out.mkdir(parents=True, exist_ok=True)
    motion, shoe = planned(ROBOT, args.seed)
    row = images(motion, shoe, at(motion, np.array(STILLS)), STILL_SIZE)
    width, height = STILL_SIZE
    sheet = Image.new("RGBA", (width * len(row), height))
    for index, image in enumerate(row):
        sheet.paste(image, (index * width, 0))
    sheet.crop(sheet.getbbox()).save(args.out / "robot.png", optimize=True)
    frames = images(motion, shoe, at(motion, np.linspace(0.0, 1.0, FRAMES)), FRAME_SIZE)
    frames[0].save(
        args.out / "motion.webp",
        save_all=True,
        append_images=frames[1:],
        duration=FRAME_MS,
        loop=0,
        quality=80,
        method=4,
    )
    print(
        *(f"{file}: {file.stat().st_size / 1e3:.0f} kB" for file in sorted(args.out.iterdir())),
        sep="\n",
    )


if __name__ == "__main__":
    main()
