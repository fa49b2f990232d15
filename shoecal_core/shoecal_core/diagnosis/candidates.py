"""What could be done next: the menu of motions, and what needs a person or time."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass

from shoecal_core.diagnosis.forecast import PossibleRun
from shoecal_core.error_sources.effects.contact import TURNED
from shoecal_core.error_sources.scene import Scene
from shoecal_core.errors import ShoecalError
from shoecal_core.model.double_support import DoubleSupport
from shoecal_core.planning.motion import Motion
from shoecal_core.planning.motion_catalogue import MOTION_KINDS
from shoecal_core.planning.planner import Planner
from shoecal_core.planning.settings import PlannerSettings
from shoecal_core.planning.supports.feasible import Feasible
from shoecal_core.planning.supports.named import named_support
from shoecal_core.samples.known_weight import KNOWN_MASS, WEIGHTED

Progress = Callable[[str, float], None]

WARM, YAWED = "warm_up", "yawed_stance"
STANCES: Mapping[str, tuple[str, ...]] = {
    YAWED: ("toes_in", "toes_out"),
    "wide_stance": ("wide",),
    "left_foot_ahead": ("left_ahead",),
    "right_foot_ahead": ("right_ahead",),
}
"""STANCE_MOTION in a double support of such a name (`planning.supports.named`), the one of several
that is farther in yaw from those so far."""
STANCE_MOTION = "landmarks"
"""What the robot does there."""


@dataclass(frozen=True)
class ByHand:
    """A motion of the menu that needs more than the robot.

    Attributes:
        motion: on the menu.
        later: time that passes before [s].
        mass: that a person adds [kg].
        warmer: by then [K].
    """

    motion: str
    later: float = 1.0
    mass: float = 0.0
    warmer: float = 0.0


BY_HAND: Mapping[str, ByHand] = {
    TURNED: ByHand("landmarks"),
    WARM: ByHand("hold", later=600.0, warmer=3.0),
    WEIGHTED: ByHand("landmarks", mass=KNOWN_MASS),
}
"""Beside the menu; see docs/reference/nodes.md for what a person does."""


def possible_runs(
    scene: Scene, settings: PlannerSettings, progress: Progress | None = None
) -> tuple[PossibleRun, ...]:
    """Every motion that this robot can do, planned and checked, in the session's first support.

    That is where the nodes run it too; STANCES are elsewhere. What cannot be planned is left out.
    """
    planner = Planner(scene.samples.robot, settings)
    so_far = [
        support
        for segment, support in enumerate(scene.supports)
        if scene.samples.loaded[scene.samples.segment == segment].all()
    ]
    neutral = DoubleSupport(*map(float, scene.samples.robot.support_range.neutral))
    usual = so_far[0] if so_far else neutral
    planned: dict[str, Motion] = {}
    names = (*MOTION_KINDS, *STANCES)
    for index, name in enumerate(names):
        if progress is not None:
            progress(f"planning {name}", index / len(names))
        for motion in _planned(planner, name, usual, so_far):
            planned[name] = motion
    runs = [PossibleRun(name, motion) for name, motion in planned.items()]
    for name, hand in BY_HAND.items():
        if hand.motion in planned:
            runs.append(PossibleRun(name, planned[hand.motion], hand.later, hand.mass, hand.warmer))
    return tuple(runs)


def _planned(
    planner: Planner, name: str, usual: DoubleSupport, so_far: list[DoubleSupport]
) -> Iterator[Motion]:
    """The motion, or none where the robot cannot do it."""
    try:
        if name in STANCES:
            feasible = Feasible(planner.legs.robot, planner.settings)
            yield planner.plan(stance(name, feasible, so_far), STANCE_MOTION)
        else:
            yield planner.plan(usual, name)
    except ShoecalError:
        return


def stance(name: str, feasible: Feasible, so_far: Sequence[DoubleSupport]) -> DoubleSupport:
    """The double support of one of STANCES, for a session that has been in some so far."""
    return max(
        (named_support(one, feasible) for one in STANCES[name]),
        key=lambda one: min((abs(one.dtheta - other.dtheta) for other in so_far), default=0.0),
    )
