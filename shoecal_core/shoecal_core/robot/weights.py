"""Weights of one robot from several sources, held against each other."""

from __future__ import annotations

from dataclasses import dataclass

from shoecal_core.errors import FieldError
from shoecal_core.files import Fields

APART, APART_STDS = 0.1, 5.0
"""Weights agree that are no further apart than this share of the robot file's, or so many of its
standard deviations."""
UNITS = {1000.0: "grams", 9.80665: "newtons", 2.20462: "pounds", 0.001: "tonnes"}
"""What a weight in kg is taken for, by how many times too large it then is."""
ALIKE = 0.15
"""Share by which a ratio of two weights may be off that of two units."""


@dataclass(frozen=True)
class RobotWeights:
    """Of one robot without shoes [kg].

    Attributes:
        urdf: sum of the URDF's masses.
        file, file_std: the robot file's, with its standard uncertainty.
        given: in place of the robot file's; None: nothing was.
        shoes: of both, which `given` was said to include.
    """

    urdf: float
    file: float
    file_std: float
    given: float | None = None
    shoes: float = 0.0

    def check(self, fields: Fields) -> None:
        """Refuse weights that contradict each other.

        Args:
            fields: `weight` of the robot file.

        Raises:
            FieldError: with all of them, and the unit that one of them looks like.
        """
        limit = max(APART * self.file, APART_STDS * self.file_std)
        weights = f"{self.file:.4g} kg by this file and {self.urdf:.4g} kg by the URDF's masses"
        if self.given is not None and abs(self.given - self.file) > limit:
            raise FieldError(
                "--weight-kg",
                f"{self.given + self.shoes:.4g} kg with shoes contradicts {fields.path}: the robot "
                f"weighs {weights}, its shoes {self.shoes:.4g} kg; weigh it with its shoes"
                f"{_unit(self.given / self.file)}",
            )
        if abs(self.file - self.urdf) > limit:
            raise fields.error(
                "mass_kg",
                f"{weights}; weigh the robot, and correct the one that is wrong, or give a std_kg "
                f"that holds both{_unit(self.file / self.urdf)}",
            )


def _unit(ratio: float) -> str:
    """What a weight looks like that is so many times another."""
    for factor, unit in UNITS.items():
        if abs(ratio / factor - 1.0) < ALIKE:
            return f" (it looks like {unit}: give kg)"
    return ""
