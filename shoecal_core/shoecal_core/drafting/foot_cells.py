"""Force cells that a URDF places in the feet: links such as `LFsrFL_frame`."""

from __future__ import annotations

import re
from dataclasses import dataclass

import numpy as np
import pinocchio as pin

from shoecal_core.arrays import FloatArray
from shoecal_core.drafting.body import Body
from shoecal_core.drafting.legs import LegChains
from shoecal_core.drafting.soles import Sole

NAME = re.compile(r"fsr|load_?cell", re.IGNORECASE)
LEAST = 3
"""Fewer cells in a foot give no CoP."""


@dataclass(frozen=True)
class FootCells:
    """The cells of one foot.

    Attributes:
        names: of their links.
        places: (k, 2) in the sole frame [m].
    """

    names: tuple[str, ...]
    places: FloatArray


def find_cells(body: Body, legs: LegChains, soles: tuple[Sole, Sole]) -> list[FootCells] | None:
    """Left and right; None where a foot has fewer than three."""
    found = [
        _on_foot(body, chain[-1], sole) for chain, sole in zip(legs.chains, soles, strict=True)
    ]
    return found if all(len(one.names) >= LEAST for one in found) else None


def _on_foot(body: Body, joint: int, sole: Sole) -> FootCells:
    frames = [
        frame
        for frame in body.model.frames
        if frame.type == pin.FrameType.BODY
        and frame.parentJoint == joint
        and NAME.search(frame.name)
    ]
    in_base = [body.placements[joint] * frame.placement for frame in frames]
    places = [sole.in_base.actInv(pose).translation[:2] for pose in in_base]
    return FootCells(tuple(str(frame.name) for frame in frames), np.reshape(places, (-1, 2)))
