"""Robot, shoe, reality, driver and settings files that were tampered with.

Each mutant is one of the files of config/ with bits flipped, cut, spliced, with numbers at their
extremes, values of another kind, lists in lists, keys gone or renamed, or with a text that a
careless reader of YAML would run, fetch or unfold. It is refused with one line that names the file,
or loaded as it says; within 2 GiB and 10 s of the processor's time, and nothing of it
runs.
"""

from __future__ import annotations

import shutil
from collections.abc import Callable
from functools import partial
from pathlib import Path

import numpy as np

from reliability import originals
from reliability.loading import PLAIN, WrongLoadError, make_trap, try_mutants
from reliability.row import Row
from reliability.tree_mutations import mutate_yaml
from shoecal_core.calibration.settings import CalibrationSettings
from shoecal_core.model.robot_file import load_robot
from shoecal_core.planning.settings import PlannerSettings
from shoecal_core.sensing.shoe import load_shoe
from shoecal_core.settings import Settings, load_settings
from shoecal_core.simulation.reality_file import load_reality
from shoecal_ros.serial.config import load_driver_config

FILES = (
    "robots/nao.yaml", "robots/wren.yaml", "shoes/nao_shoe.yaml", "shoes/wren_shoe.yaml",
    "realities/default.yaml", "nodes/shoe_driver.yaml", "nodes/planner.yaml",
    "nodes/calibrator.yaml",
)  # fmt: skip


def target(folder: Path) -> YamlFiles:
    """The files of config/, in a folder of their own."""
    return YamlFiles(folder)


class YamlFiles:
    """Copies of the configuration, one of them a mutant."""

    codes = PLAIN | {"field", "version", "urdf"}  # a robot file may name another file as its URDF

    def __init__(self, folder: Path) -> None:
        self._config = folder / "config"
        shutil.copytree(originals.CONFIG, self._config, dirs_exist_ok=True)
        make_trap(folder)
        self._folder = folder
        self._whole = {name: (self._config / name).read_bytes() for name in FILES}
        self._name = FILES[0]

    def mutate(self, rng: np.random.Generator) -> str:
        (self._config / self._name).write_bytes(self._whole[self._name])
        self._name = FILES[int(rng.integers(len(FILES)))]
        what, mutant = mutate_yaml(self._whole[self._name], rng, self._folder)
        (self._config / self._name).write_bytes(mutant)
        return f"{self._name}: {what}"

    def load(self) -> None:
        _LOADERS[self._name](self._config / self._name)


def _robot(path: Path) -> None:
    robot = load_robot(path)
    numbers = (robot.mass, robot.mass_std, *robot.posture, *robot.support_range.step)
    places = [foot.placement.homogeneous for foot in robot.feet]
    shapes = [each for one in robot.capsules for each in (one.start, one.end)]
    _finite("robot", np.array(numbers), *places, *shapes)
    if abs(sum(inertia.mass for inertia in robot.model.inertias) - robot.mass) > 1e-6 * robot.mass:
        raise WrongLoadError(f"the model's masses are not the robot's {robot.mass:g} kg")


def _shoe(path: Path) -> None:
    shoe = load_shoe(path)
    _finite("shoe", shoe.columns, shoe.positions, np.array([shoe.height, shoe.mass]))
    gains = [one.nominal_gain for one in shoe.channels if one.nominal_gain is not None]
    _finite("nominal gains", np.array(gains))


def _settings(kind: type[Settings], node: str, section: str, path: Path) -> None:
    load_settings(kind, path, node, section)


def _finite(name: str, *numbers: np.ndarray[tuple[int, ...], np.dtype[np.float64]]) -> None:
    if not all(np.isfinite(one).all() for one in numbers):
        raise WrongLoadError(f"{name}: a number that is not finite")


def _reality(path: Path) -> None:
    load_reality(path)


def _driver(path: Path) -> None:
    load_driver_config(path)


_LOADERS: dict[str, Callable[[Path], None]] = {
    "robots/nao.yaml": _robot,
    "robots/wren.yaml": _robot,
    "shoes/nao_shoe.yaml": _shoe,
    "shoes/wren_shoe.yaml": _shoe,
    "realities/default.yaml": _reality,
    "nodes/shoe_driver.yaml": _driver,
    "nodes/planner.yaml": partial(_settings, PlannerSettings, "planner", "planning"),
    "nodes/calibrator.yaml": partial(_settings, CalibrationSettings, "calibrator", "calibration"),
}

ROW = Row(
    key="mutants-yaml",
    fault="mutated YAML: robot, shoe, reality, driver, settings",
    holds="refused with one line that names the file, or loaded as it says; at most 2 GiB and "
    "10 s of the processor; nothing of it runs",
    tries=10_000,
    step=500,
    run=partial(try_mutants, "mutated_yaml"),
)
