"""Mutants of configuration files, robot descriptions and calibrations."""

from __future__ import annotations

import shutil
from collections.abc import Callable, Mapping
from functools import partial
from pathlib import Path

import numpy as np

from reliability import originals
from reliability.loading import Draw, Load, WrongLoadError
from reliability.mutations import Rng, mutate_yaml, pick
from reliability.same import same
from shoecal_core.errors import FieldError, FileError
from shoecal_core.estimation.calibration import load_calibration, save_calibration
from shoecal_core.parameter_file import load_settings
from shoecal_core.planning.settings import PlannerSettings
from shoecal_core.robot.robot_file import load_robot
from shoecal_core.robot.urdf import UrdfError, read_urdf
from shoecal_core.screening.settings import CalibrationSettings
from shoecal_core.shoe.shoe_file import load_shoe
from shoecal_core.simulation.reality_file import load_reality
from shoecal_ros.serial.config import load_driver_config

Loader = Callable[[Path], object]
Mutate = Callable[[bytes, Rng, Path], bytes]


def lay_config(loaders: Mapping[str, Loader], mutate: Mutate, folder: Path) -> Draw:
    """A copy of config/ of which one file is a mutant.

    Args:
        loaders: of the files that are mutated, by their paths in config/.
        mutate: makes a mutant of a file's content; texts in it may name files of the folder.
        folder: of the copy.
    """
    config = folder / "config"
    shutil.copytree(originals.CONFIG, config)
    for name, load in loaders.items():
        load(config / name)

    def draw(rng: Rng) -> Load:
        for name in loaders:
            shutil.copy(originals.CONFIG / name, config / name)
        name = pick(rng, list(loaders))
        path = config / name
        path.write_bytes(mutate(path.read_bytes(), rng, folder))
        return partial(loaders[name], path)

    return draw


def lay_calibration(folder: Path) -> Draw:
    """One calibration; what loads is saved and loaded again."""
    path, again = folder / "calibration.yaml", folder / "again.yaml"
    save_calibration(originals.calibration(), path)
    whole = path.read_bytes()

    def load() -> None:
        loaded = load_calibration(path)
        _finite(loaded.parameters.gain, loaded.parameters.offset, loaded.weight)
        save_calibration(loaded, again)
        try:
            reloaded = load_calibration(again)
        except FileError as error:
            raise WrongLoadError(f"saved again it is refused: {error}") from error
        if not same(loaded, reloaded):
            raise WrongLoadError("saved again it is another")

    def draw(rng: Rng) -> Load:
        path.write_bytes(mutate_yaml(whole, rng, folder))
        return load

    load()
    return draw


def _finite(*numbers: object) -> None:
    if not all(np.isfinite(np.asarray(one, float)).all() for one in numbers):
        raise WrongLoadError("a number that is not finite")


def _robot(path: Path) -> None:
    robot = load_robot(path)
    _finite(robot.mass, robot.mass_std, robot.posture, robot.support_range.step)
    _finite(*(foot.placement.homogeneous for foot in robot.feet))
    _finite(*(end for capsule in robot.capsules for end in (capsule.start, capsule.end)))
    if abs(sum(inertia.mass for inertia in robot.model.inertias) - robot.mass) > 1e-6 * robot.mass:
        raise WrongLoadError(f"the model's masses are not the robot's {robot.mass:g} kg")


def _shoe(path: Path) -> None:
    shoe = load_shoe(path)
    gains = [one.nominal_gain for one in shoe.channels if one.nominal_gain is not None]
    _finite(shoe.columns, shoe.positions, shoe.height, shoe.mass, gains)


def _urdf(path: Path) -> None:
    model = read_urdf(path).model
    _finite(*(inertia.matrix() for inertia in model.inertias))
    _finite(*(placement.homogeneous for placement in model.jointPlacements))
    try:
        _robot(path.with_suffix(".yaml"))
    except (FieldError, UrdfError):
        return  # the robot file names links and joints that have become others


CONFIGURATION: Mapping[str, Loader] = {
    "robots/nao.yaml": _robot,
    "robots/wren.yaml": _robot,
    "shoes/nao_shoe.yaml": _shoe,
    "shoes/wren_shoe.yaml": _shoe,
    "realities/default.yaml": load_reality,
    "nodes/shoe_driver.yaml": load_driver_config,
    "nodes/planner.yaml": partial(
        load_settings, PlannerSettings, node_name="planner", section="planning"
    ),
    "nodes/calibrator.yaml": partial(
        load_settings, CalibrationSettings, node_name="calibrator", section="calibration"
    ),
}
URDFS: Mapping[str, Loader] = {"robots/nao.urdf": _urdf, "robots/wren.urdf": _urdf}
