"""What all effects on the way of a channel's signal share."""

from __future__ import annotations

import dataclasses
from abc import abstractmethod

from shoecal_core.simulation.effects.effect import Effect
from shoecal_core.simulation.sampled_parts import SampledShoes
from shoecal_core.simulation.stage import AnyStage


class SensorEffect(Effect):
    """An effect that is one stage on the way from a channel to its converter."""

    @abstractmethod
    def stage(self, shoes: SampledShoes) -> AnyStage:
        """The stage in a pair of shoes.

        Raises:
            FileError: when these shoes lack what it names, or it makes no sense in them.
        """

    def on_shoes(self, shoes: SampledShoes) -> SampledShoes:
        """The shoes with this stage added."""
        return dataclasses.replace(shoes, stages=(*shoes.stages, self.stage(shoes)))
