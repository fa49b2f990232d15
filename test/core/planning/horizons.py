"""Problems of one horizon each, from the ways of planned motions."""

from __future__ import annotations

import numpy as np

from core.planning.bodies import Body
from core.planning.motions import SETTINGS, SUPPORTS, motion_of
from shoecal_core.arrays import FloatArray
from shoecal_core.planning.horizon.problem import Aim, HorizonProblem, Scene
from shoecal_core.planning.landmarks import Contour, sensing_hull
from shoecal_core.planning.legs import FootPose


def problems(body: Body) -> list[tuple[HorizonProblem, FloatArray]]:
    """From several places on the way of a planned motion; the guess is standing still."""
    found = []
    for index, support in enumerate(SUPPORTS):
        robot, path = body.robot, motion_of(body.robot.name, index).path
        hull = sensing_hull(robot, support)
        scene = Scene.of(hull, SETTINGS.stability_margin, FootPose.of(support), robot.posture)
        for step in (7, len(path.states) // 2, len(path.states) - 9):
            start, previous = path.states[step], path.states[step] - path.states[step - 1]
            target = Contour.of(robot, support).corners[step % 4]
            problem = HorizonProblem(start, previous, Aim.at(target, SETTINGS), scene)
            found.append((problem, np.tile(start, (SETTINGS.horizon, 1))))
    return found


def lifting(body: Body) -> tuple[HorizonProblem, FloatArray]:
    """The right foot rises while the left one carries: poses and polygons differ by state."""
    robot, support = body.robot, SUPPORTS[0]
    path = motion_of(robot.name).path
    start = path.states[0]
    poses = [
        FootPose(FootPose.of(support).rotation, np.array([support.dx, support.dy, 1e-3 * rise]))
        for rise in range(1, SETTINGS.horizon + 1)
    ]
    scene = Scene.row(
        [
            Scene.of(sensing_hull(robot, support), SETTINGS.stability_margin, pose, robot.posture)
            for pose in poses
        ]
    )
    tasks = np.zeros((1, 5))
    tasks[0, :2] = sensing_hull(robot, support).centroid.coords[0]
    problem = HorizonProblem(
        start, np.zeros_like(start), Aim(tasks, np.array([1e4, 1e4, 1e3, 1e3, 0.0])), scene
    )
    return problem, np.tile(start, (SETTINGS.horizon, 1))
