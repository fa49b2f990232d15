"""The section of docs/evidence/performance.md on motions in many double supports."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence

import numpy as np

import pages
from planner_outcomes import FAILED, PLANNED, REFUSED, Outcome

LANDMARKS = 4
"""Of a double support; before them, the middle of a side of their contour is pursued."""

BODY = """\
## The planner: motions in many double supports

Made by `{command}`.

Random double supports without collision from each robot's range. *Refused*: the robot cannot stand
there, or above too few landmarks. In the others a motion over the landmarks is planned and checked
independently. Times of planning and checking one motion: median (95th percentile), two processes.

{robots}

{failures}

{unreached}

All motions of the menu, in the first double supports of each robot:

{menu}
"""


def supports_body(command: str, drawn: Sequence[Outcome], menu: Sequence[Outcome]) -> str:
    """The section."""
    return BODY.format(
        command=command,
        robots=_robots(drawn),
        failures=_failures([*drawn, *menu]),
        unreached=_unreached(drawn),
        menu=_menu(menu),
    )


def _names(outcomes: Sequence[Outcome]) -> list[str]:
    return list(dict.fromkeys(outcome.job.robot for outcome in outcomes))


def _robots(drawn: Sequence[Outcome]) -> str:
    rows = [
        ["robot", "drawn", "refused", "planned", "failed", "violate a constraint",
         "landmarks reached", "by the clock [s]", "processor [s]", "motion [s]",
         "optimisations", "of them by IPOPT"]
    ]  # fmt: skip
    for robot in _names(drawn):
        own = [outcome for outcome in drawn if outcome.job.robot == robot]
        ends = Counter(outcome.end for outcome in own)
        planned = [outcome for outcome in own if outcome.end == PLANNED]
        landmarks = LANDMARKS * len(planned)
        missed = sum(index > 0 for outcome in planned for index in outcome.unreached)
        rows.append(
            [
                robot,
                str(len(own)),
                *(str(ends[end]) for end in (REFUSED, PLANNED, FAILED)),
                str(sum(bool(outcome.violated) for outcome in planned)),
                f"{landmarks - missed} of {landmarks}",
                *(_spread([getattr(o, of) for o in planned]) for of in ("wall", "cpu", "duration")),
                str(sum(outcome.solves for outcome in planned)),
                str(sum(outcome.rescues for outcome in planned)),
            ]
        )
    return pages.table(rows)


def _spread(values: Sequence[float]) -> str:
    if not values:
        return "-"
    median, most = np.percentile(values, [50, 95])
    return f"{median:.2f} ({most:.2f})"


def _failures(outcomes: Sequence[Outcome]) -> str:
    failed = [outcome for outcome in outcomes if outcome.end == FAILED]
    if not failed:
        return "Nothing failed."
    counts = Counter((o.job.robot, o.job.motion, o.cause[0]) for o in failed)
    said = {(o.job.robot, o.job.motion, o.cause[0]): o.cause[1] for o in reversed(failed)}
    head = ["robot", "motion", "cause", "times", "for example"]
    rows = [[*key, str(count), said[key]] for key, count in counts.most_common()]
    return f"What failed, by cause:\n\n{pages.table([head, *rows])}"


def _unreached(drawn: Sequence[Outcome]) -> str:
    head = ["robot", "dx [m]", "dy [m]", "dtheta [rad]", "landmark", "distance [mm]", "standing"]
    rows = [head]
    for outcome in drawn:
        for index in outcome.unreached:
            place = (f"{value:.3f}" for value in outcome.support)
            away = f"{1e3 * outcome.nearest[index]:.1f}"
            standing = "possible" if index in outcome.standable else "impossible"
            number = str(index) if index else "start"
            rows.append([outcome.job.robot, *place, number, away, standing])
    if len(rows) == 1:
        return "Every landmark was reached."
    return (
        "Landmarks that were not reached, numbered as they are pursued, how far the CoP stayed "
        "away\nfrom each, and whether the robot could stand above it in any posture, maybe far "
        f"from that in which it\ncame there ({len(rows) - 1}):\n\n{pages.table(rows)}"
    )


def _menu(menu: Sequence[Outcome]) -> str:
    rows = [
        ["robot", "motion", "planned", "violate a constraint", "places reached", "processor [s]",
         "motion [s]"]
    ]  # fmt: skip
    for robot in _names(menu):
        own = [outcome for outcome in menu if outcome.job.robot == robot]
        for motion in dict.fromkeys(outcome.job.motion for outcome in own):
            asked = [outcome for outcome in own if outcome.job.motion == motion]
            planned = [outcome for outcome in asked if outcome.end == PLANNED]
            places = sum(len(outcome.nearest) for outcome in planned)
            missed = sum(len(outcome.unreached) for outcome in planned)
            rows.append(
                [
                    robot,
                    motion,
                    f"{len(planned)} of {len(asked)}",
                    str(sum(bool(outcome.violated) for outcome in planned)),
                    f"{places - missed} of {places}",
                    _spread([outcome.cpu for outcome in planned]),
                    _spread([outcome.duration for outcome in planned]),
                ]
            )
    return pages.table(rows)
