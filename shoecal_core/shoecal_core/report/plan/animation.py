"""A planned motion for the page's player: stick figures from two sides, and the feet from above."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from shoecal_core.arrays import FloatArray, IntArray
from shoecal_core.report.figures.motion import BODY, LEFT_SIDE, RIGHT_SIDE
from shoecal_core.report.plan.content import BOTH, PlannedMotion
from shoecal_core.report.plan.figures import moved
from shoecal_core.report.player import Player, PlayerPoints, PlayerView, Shape

RATE = 10.0
"""Frames a second: motions are slow, and between frames the page interpolates."""
ROOM = 0.02
"""Around what is shown [m]."""
LABEL = 0.01
"""From a landmark's ring to the middle of its number [m]."""
LOOKS = {BODY: "body", RIGHT_SIDE: "right", LEFT_SIDE: "left"}
"""Classes of the parts of the body, in the order in which they are drawn."""
FEET = "lr"
"""As frames name the foot in the air."""
CAPTION = (
    "Computed from the model: nothing was measured. The robot moves slowly; 4× is a good speed to "
    "look at."
)
IN_THE_AIR = "Soles with a dashed outline are in the air."


def animation(planned: PlannedMotion) -> Player:
    """The motion for the page's player."""
    count = max(2, int(np.ceil(planned.motion.duration * RATE)) + 1)
    samples = np.round(np.linspace(0, len(planned.motion.time) - 1, count)).astype(np.int64)
    points, letters = PlayerPoints(count), lifted(planned, samples)
    soles: list[Shape] = []
    for side, foot in enumerate(planned.robot.feet):
        outline = on_foot(planned, samples, side, foot.outline)
        soles.append((f"sole {LOOKS[side]}", "area", points.add(outline), FEET[side]))
    return Player(
        title="The motion",
        views=(
            *_from_the_side(planned, samples, points, soles),
            _from_above(planned, samples, points, soles),
        ),
        points=points,
        duration=round(planned.motion.duration, 1),
        lifted=letters,
        caption=f"{CAPTION} {IN_THE_AIR}" if letters.strip("-") else CAPTION,
    )


def lifted(planned: PlannedMotion, samples: IntArray) -> str:
    """A letter for each of the samples (F,): the foot in the air, `-` for none."""
    letters = np.full(len(planned.motion.time), "-")
    for stand in planned.stands:
        if stand.feet != BOTH:
            letters[stand.begin : stand.end] = "r" if stand.feet == "left" else "l"
    return "".join(letters[samples])


def on_foot(
    planned: PlannedMotion, samples: IntArray, side: int, corners: FloatArray
) -> FloatArray:
    """(F, k, 3) points (k, 2) of a sole in the world, at samples (F,) [m]."""
    turns, places = (pose[samples, side] for pose in planned.soles)
    placed: FloatArray = _on_floor(corners) @ turns.transpose(0, 2, 1) + places[:, None]
    return placed


def _from_the_side(
    planned: PlannedMotion, samples: IntArray, points: PlayerPoints, soles: Sequence[Shape]
) -> list[PlayerView]:
    """The whole body from its right, and from its front."""
    bodies = [moved(planned, int(sample)) for sample in samples]
    bones, capsules = (
        np.stack([getattr(body, part) for body in bodies]) for part in ("bones", "capsules")
    )
    radii = [capsule.radius for capsule in planned.robot.capsules]
    outlines = [outline for body in bodies for outline in body.soles]
    drawn = np.vstack([*outlines, bones.reshape(-1, 3), capsules.reshape(-1, 3)])
    extent = _extent(drawn, ROOM + max(radii, default=0.0))
    (com,), (cop,) = points.add(planned.com[samples, None], 1), _cop(planned, samples, points)
    shapes: list[Shape] = [
        ("floor", "line", points.add(extent * (1.0, 1.0, 0.0)), None),
        *(("capsule", "line", points.add(capsules[:, index]), round(2e3 * radius, 1))
          for index, radius in enumerate(radii)),
        *soles,
        *((look, "line", points.add(bones[:, bodies[0].side == side].reshape(len(bones), -1, 3)),
           None) for side, look in LOOKS.items()),
        ("plumb", "line", [com, cop], None),
        ("com", "line", [com, com], None),
        ("cop", "line", [cop, cop], None),
    ]  # fmt: skip
    return [
        _view(title, (across, 1), (2, -1), extent, shapes)
        for across, title in enumerate(("from the right", "from the front"))
    ]


def _from_above(
    planned: PlannedMotion, samples: IntArray, points: PlayerPoints, soles: Sequence[Shape]
) -> PlayerView:
    """Feet, sensing polygons and hulls, landmarks and the CoP's way; the robot faces upwards."""
    outlines = [
        on_foot(planned, samples, side, foot.outline).reshape(-1, 3)
        for side, foot in enumerate(planned.robot.feet)
    ]
    places = np.array([mark.place for mark in planned.marks]).reshape(-1, 2)
    extent = _extent(np.vstack([*outlines, _on_floor(planned.cop), _on_floor(places)]), ROOM)
    (cop,) = _cop(planned, samples, points)
    shapes: list[Shape] = [
        *soles,
        *(("polygon", "area", points.add(on_foot(planned, samples, side, foot.sensing_polygon)),
           None) for side, foot in enumerate(planned.robot.feet)),
        *(("hull", "area", points.add(_on_floor(hull)), None) for hull in planned.hulls),
        ("way", "way", [cop], None),
    ]  # fmt: skip
    radius = planned.settings.landmark_radius
    for mark, place in zip(planned.marks, places, strict=True):
        away = place - places.mean(axis=0)
        length = float(np.linalg.norm(away))
        outwards = away / length if length > 1e-3 else np.array([1.0, 0.0])
        ring, label = points.add(_on_floor(np.array([place, place + (radius + LABEL) * outwards])))
        look = "mark missed" if mark.missing else "mark"
        shapes += [
            (look, "ring", [ring], round(1e3 * radius, 1)),
            (look, "text", [label], mark.numbers),
        ]
    shapes += [("trace", "trace", [cop], None), ("cop", "line", [cop, cop], None)]
    return _view("from above, facing upwards", (1, -1), (0, -1), extent, shapes)


def _cop(planned: PlannedMotion, samples: IntArray, points: PlayerPoints) -> list[int]:
    return points.add(_on_floor(planned.cop[samples])[:, None], 1)


def _on_floor(points: FloatArray) -> FloatArray:
    """Points (k, 2) as points (k, 3) at height 0."""
    return np.column_stack((points, np.zeros(len(points))))


def _extent(points: FloatArray, room: float) -> FloatArray:
    """(2, 3) lowest and highest coordinates of points (k, 3), with room around, to 1 mm [m]."""
    return np.round([points.min(axis=0) - room, points.max(axis=0) + room], 3)


def _view(
    title: str,
    right: tuple[int, int],
    down: tuple[int, int],
    extent: FloatArray,
    shapes: Sequence[Shape],
) -> PlayerView:
    left, top = (
        float((1e3 * sign * extent[:, axis]).min().round()) for axis, sign in (right, down)
    )
    width, height = (float((1e3 * np.ptp(extent[:, axis])).round()) for axis, _ in (right, down))
    return PlayerView(title, right, down, (left, top, width, height), tuple(shapes))
