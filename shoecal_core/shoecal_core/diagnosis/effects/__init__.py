"""The library of effects; each is a small plug-in, see `base`."""

from shoecal_core.diagnosis.effects.base import ALL, Component, Effect, Place, Shape, stds
from shoecal_core.diagnosis.effects.library import EFFECTS, effects_from

__all__ = ["ALL", "EFFECTS", "Component", "Effect", "Place", "Shape", "effects_from", "stds"]
