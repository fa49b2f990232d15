"""Shapes to a picture, by MuJoCo's renderer in a process of its own.

Graphics drivers are chosen by environment before they are loaded, and some end the process when
there is no screen. So the picture is drawn elsewhere, and where none can be drawn this is reported.
"""

from __future__ import annotations

import base64
import json
import os
import subprocess
import sys
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TypeVar

import numpy as np

from shoecal_core.errors import ShoecalError
from shoecal_core.report.scene.shapes import FloatArray, LinkShape

Made = TypeVar("Made")

BACKENDS = ("egl", "osmesa")
"""Of MuJoCo that need no screen, in the order they are tried."""
FOVY = 24.0
"""deg; vertical angle of view: narrow, so that sizes can be compared."""
PATIENCE = 60.0
"""s; for all pictures of one call."""
PAINTER_FAILED = 70
"""Exit code of the process that draws when it has a driver, yet cannot draw (EX_SOFTWARE)."""
SWITCH = "SHOECAL_PICTURES"
"""Environment variable: 0 leaves pictures out."""


class NoPictureError(ShoecalError):
    """Nothing here can draw in three dimensions."""


@dataclass(frozen=True)
class Camera:
    """From where it is seen.

    Attributes:
        target: (3,) in the middle of the picture [m].
        distance: of the eye from it [m].
        azimuth, elevation: direction of sight [deg]; 180 looks a robot in the face, and a
            negative elevation looks down.
    """

    target: tuple[float, float, float]
    distance: float
    azimuth: float
    elevation: float


@dataclass(frozen=True)
class Viewpoint:
    """One picture to draw.

    Attributes:
        shapes: what is to be seen.
        camera: from where.
        width, height: of the picture [pixels].
    """

    shapes: Sequence[LinkShape]
    camera: Camera
    width: int
    height: int


def draw(views: Sequence[Viewpoint], kind: str = "webp") -> list[bytes]:
    """Pictures on a clear ground, as files of a kind: `webp` or `png`.

    Raises:
        NoPictureError: where there is no OpenGL without a screen.
    """
    if os.environ.get(SWITCH) == "0":
        raise NoPictureError(f"pictures of the robot are switched off ({SWITCH}=0)")
    request = json.dumps({"kind": kind, "fovy": FOVY, "views": [_to_json(view) for view in views]})
    asked = os.environ.get("MUJOCO_GL")
    for backend in (asked,) if asked in BACKENDS else BACKENDS:
        done = _ask(request, backend)
        if done.returncode == 0:
            return [base64.b64decode(one) for one in json.loads(done.stdout)]
        if done.returncode == PAINTER_FAILED:
            last = (done.stderr.strip().splitlines() or ["no reason was given"])[-1]
            raise NoPictureError(f"no picture of the robot: {last}")
    raise NoPictureError(
        "no picture of the robot: OpenGL without a screen was not found; install it "
        "(sudo apt install libegl1 libgl1-mesa-dri)"
    )


def tried(make: Callable[[], Made]) -> Made | str:
    """What `make` draws, or, where nothing can be drawn, the sentence that says so."""
    try:
        return make()
    except NoPictureError as error:
        text = str(error)
        return f"{text[0].upper()}{text[1:]}."


def _ask(request: str, backend: str) -> subprocess.CompletedProcess[str]:
    """One try; what has no driver ends in all kinds of ways, but never with PAINTER_FAILED."""
    environment = {**os.environ, "MUJOCO_GL": backend, "PYOPENGL_PLATFORM": backend}
    command = [sys.executable, "-m", "shoecal_core.report.scene.painter"]
    try:
        return subprocess.run(
            command, input=request, capture_output=True, text=True, env=environment,
            timeout=PATIENCE, check=False,
        )  # fmt: skip
    except subprocess.TimeoutExpired:
        reason = f"it took longer than {PATIENCE:g} s"
        return subprocess.CompletedProcess(command, PAINTER_FAILED, "", reason)


def _to_json(view: Viewpoint) -> dict[str, object]:
    return {
        "width": view.width,
        "height": view.height,
        "camera": vars(view.camera),
        "shapes": [
            {"points": np.round(shape.points, 5).tolist(), "radius": round(shape.radius, 5),
             "rgba": shape.rgba}
            for shape in view.shapes
        ],
    }  # fmt: skip


def framed(shapes: Sequence[LinkShape], azimuth: float, elevation: float, aspect: float) -> Camera:
    """A camera that has all shapes in view.

    Args:
        shapes: to be seen.
        azimuth, elevation: as in Camera [deg].
        aspect: width over height of the picture.
    """
    points = np.vstack([shape.points for shape in shapes])
    spread = np.concatenate([np.full(len(shape.points), shape.radius) for shape in shapes])
    right, up, sight = _axes(np.radians(azimuth), np.radians(elevation))
    across, along = points @ right, points @ up
    middle = [
        ((one - spread).min() + (one + spread).max()) / 2.0 for one in (across, along)
    ]  # fmt: skip
    depth = points @ sight
    centre = (depth.min() + depth.max()) / 2.0
    tangent = np.tan(np.radians(FOVY) / 2.0)
    needed = np.maximum(
        (np.abs(along - middle[1]) + spread) / tangent,
        (np.abs(across - middle[0]) + spread) / (tangent * aspect),
    ) - (depth - centre)
    target = right * middle[0] + up * middle[1] + sight * centre
    x, y, z = target.tolist()
    return Camera((x, y, z), 1.04 * float(needed.max()), azimuth, elevation)


def _axes(azimuth: float, elevation: float) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Right, up, and the direction of sight, of a camera."""
    sight = np.array([np.cos(elevation) * np.cos(azimuth), np.cos(elevation) * np.sin(azimuth),
                      np.sin(elevation)])  # fmt: skip
    right = np.array([np.sin(azimuth), -np.cos(azimuth), 0.0])
    return right, np.cross(right, sight), sight
