"""The generator: draws a round, seals its answers, and makes the sets.

It knows the simulated robot and nothing of the diagnosis.
"""

from __future__ import annotations

import dataclasses
import json
from functools import partial

import numpy as np

from blind.answers import Answer, read_answers, seal
from blind.catalogue import item
from blind.composition import Mix, compose
from blind.gap import measure_gap
from blind.layout import Round
from blind.motions import fill, planned_set
from blind.processes import over
from blind.recorder import Recorded, record
from blind.unknowns import KINDS
from blind.world import write_world
from population import RATE_HZ
from shoecal_core.errors import ShoecalError
from shoecal_core.files import atomic_write
from shoecal_core.recording.session import Session

SETS_A_MOTION = 20
"""So many sets of a round share their motions."""


def draw_round(place: Round, seed: int, mix: Mix, jobs: int) -> str:
    """Draw a round and seal its answers, unless that is done; their SHA-256."""
    count = max(2, round(sum(dataclasses.astuple(mix)) / SETS_A_MOTION))
    motions = fill([100 * seed + index for index in range(1, count + 1)], jobs)
    planned = {one: [each.trajectory.duration for each in planned_set(one)] for one in motions}
    return seal(place, compose(seed, mix, planned))


def make_sets(place: Round, jobs: int) -> None:
    """Make the sets that are missing."""
    missing = [one for one in read_answers(place) if not place.made(one.number).is_file()]
    for done, told in enumerate(over(partial(_make, place), missing, jobs), start=1):
        print(f"made {done} of {len(missing)}: {told}", flush=True)


def _make(place: Round, answer: Answer) -> str:
    """One set; what it came to is kept with the answers."""
    folder = place.recorded(answer.number)
    came: dict[str, object]
    try:
        recorded = make_set(place, answer)
        once = [truth.run for truth in answer.truths if truth.run is not None]
        gap = measure_gap(Session.open(folder), recorded.noise, once)
        came = {
            "starts": recorded.starts, "sizes": recorded.sizes, **dataclasses.asdict(gap),
        }  # fmt: skip
    except ShoecalError as error:
        came = {"failed": str(error)}
    atomic_write(place.made(answer.number), json.dumps(came).encode(), 0o600)
    # What should have been made, and why it could not, belongs to the answers.
    return f"{folder.name}{' could not be made' if 'failed' in came else ''}"


def make_set(place: Round, answer: Answer, rate: float = RATE_HZ) -> Recorded:
    """Simulate and record one set.

    Args:
        place: to put it into.
        answer: what it is.
        rate: samples a second [Hz].
    """
    items = []
    for truth in answer.truths:
        if truth.seed is not None:
            continue
        listed = item(truth.effect, truth.location, truth.size)
        items.append(listed if truth.run is None else {**listed, "run": truth.run})
    foreign = None
    if (told := answer.foreign) is not None and told.kind in KINDS:
        foreign = KINDS[told.kind](told.size, np.random.default_rng(told.seed))
    reality = write_world(place.world(answer.number), answer, items)
    planned = planned_set(answer.motions)
    own = [planned[index].paced(answer.pace) for index in answer.order]
    return record(place.recorded(answer.number), answer, reality, own, foreign, rate)
