"""The process that draws: views as JSON on standard input, pictures as JSON on standard output.

`python -m shoecal_core.report.scene.painter`, with MUJOCO_GL in its environment.
"""

from __future__ import annotations

import base64
import io
import json
import sys
from typing import Any

import mujoco
import numpy as np
from numpy.typing import NDArray
from PIL import Image

from shoecal_core.report.scene.offscreen import PAINTER_FAILED

FINER = 3
"""Pixels drawn for each pixel of the picture, along each side."""
MOST = 6
"""Groups of shapes that MuJoCo shows or hides."""
BEHIND = [0.85] * 3
"""Colour of what shines through."""
_BALL = 8
"""Corners around half a ball that a hull is grown by."""


def model_of(views: list[dict[str, Any]], fovy: float) -> mujoco.MjModel:
    """A world that holds the shapes of some views, each view a group, and light."""
    spec = mujoco.MjSpec()
    visual, head = getattr(spec.visual, "global"), spec.visual.headlight
    visual.fovy = fovy
    visual.offwidth, visual.offheight = (
        FINER * max(view[side] for view in views) for side in ("width", "height")
    )
    spec.visual.quality.shadowsize = 2048
    spec.visual.quality.offsamples = 0
    head.ambient, head.diffuse, head.specular = [0.42] * 3, [0.32] * 3, [0.0] * 3
    spec.worldbody.add_light(
        type=mujoco.mjtLightType.mjLIGHT_DIRECTIONAL, pos=[1.0, 1.0, 3.0], dir=[-0.35, -0.25, -1.0],
        diffuse=[0.5] * 3, specular=[0.15] * 3, castshadow=True,
    )  # fmt: skip
    # Behind what can be seen through; what nothing stands before stays clear.
    spec.add_texture(
        name="behind", type=mujoco.mjtTexture.mjTEXTURE_SKYBOX, width=8, height=48,
        builtin=mujoco.mjtBuiltin.mjBUILTIN_FLAT, rgb1=BEHIND, rgb2=BEHIND,
    )  # fmt: skip
    for group, view in enumerate(views):
        for shape in view["shapes"]:
            _add(spec, group, np.array(shape["points"]), float(shape["radius"]), shape["rgba"])
    return spec.compile()


def _add(
    spec: mujoco.MjSpec, group: int, points: NDArray[np.float64], radius: float, rgba: list[float]
) -> None:
    geom = spec.worldbody.add_geom(group=group, rgba=rgba)
    if np.ptp(points, axis=0).max() == 0.0:
        geom.type, geom.pos = mujoco.mjtGeom.mjGEOM_SPHERE, points[0]
        geom.size[0] = radius
    elif len(points) == 2:
        geom.type, geom.fromto = mujoco.mjtGeom.mjGEOM_CAPSULE, points.ravel()
        geom.size[0] = radius
    else:
        corners = points if radius == 0.0 else (points[:, None] + radius * _ball()).reshape(-1, 3)
        geom.type, geom.meshname = mujoco.mjtGeom.mjGEOM_MESH, f"hull{len(spec.meshes)}"
        spec.add_mesh(name=geom.meshname, uservert=corners.ravel())


def _ball() -> NDArray[np.float64]:
    around, height = np.meshgrid(
        np.linspace(0.0, 2.0 * np.pi, 2 * _BALL, endpoint=False),
        np.linspace(-np.pi / 2.0, np.pi / 2.0, _BALL + 1),
    )
    ball: NDArray[np.float64] = np.stack(
        (np.cos(height) * np.cos(around), np.cos(height) * np.sin(around), np.sin(height)), axis=-1
    ).reshape(-1, 3)
    return ball


def paint(views: list[dict[str, Any]], fovy: float) -> list[Image.Image]:
    """Views of one size, at most MOST of them, each on a clear ground."""
    model = model_of(views, fovy)
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    width, height = views[0]["width"], views[0]["height"]
    far = 0.98 * model.vis.map.zfar * model.stat.extent
    pictures = []
    with mujoco.Renderer(model, FINER * height, FINER * width) as renderer:
        for group, view in enumerate(views):
            option = mujoco.MjvOption()
            option.geomgroup[:] = np.arange(len(option.geomgroup)) == group
            renderer.update_scene(data, _camera(view["camera"]), option)
            colour = renderer.render().astype(np.float64)
            renderer.enable_depth_rendering()
            filled = (renderer.render() < far).astype(np.float64)
            renderer.disable_depth_rendering()
            pictures.append(Image.fromarray(_smaller(colour, filled), "RGBA"))
    return pictures


def _camera(view: dict[str, Any]) -> mujoco.MjvCamera:
    camera = mujoco.MjvCamera()
    camera.type = mujoco.mjtCamera.mjCAMERA_FREE
    camera.lookat[:] = view["target"]
    for name in ("distance", "azimuth", "elevation"):
        setattr(camera, name, view[name])
    return camera


def _smaller(colour: NDArray[np.float64], filled: NDArray[np.float64]) -> NDArray[np.uint8]:
    """Means of blocks of pixels; colour only of what is filled."""
    height, width = (side // FINER for side in filled.shape)
    blocks = (height, FINER, width, FINER)
    share = filled.reshape(blocks).mean(axis=(1, 3))
    total = (colour * filled[..., None]).reshape(*blocks, 3).mean(axis=(1, 3))
    mean = total / np.maximum(share, 1e-9)[..., None]
    return np.round(np.dstack((mean, 255.0 * share))).clip(0, 255).astype(np.uint8)


def main() -> None:
    """Draw what is asked for."""
    asked = json.load(sys.stdin)
    mujoco.GLContext(8, 8).free()  # whatever ends here ends for want of a driver
    try:
        pictures = _files(asked)
    except Exception as error:  # noqa: BLE001 - reported to the process that asked
        print(" ".join(str(error).split()), file=sys.stderr)
        sys.exit(PAINTER_FAILED)
    json.dump(pictures, sys.stdout)


def _files(asked: dict[str, Any]) -> list[str]:
    views, drawn = asked["views"], []
    for begin in range(0, len(views), MOST):
        drawn += paint(views[begin : begin + MOST], asked["fovy"])
    pictures = []
    for picture in drawn:
        file = io.BytesIO()
        picture.save(file, asked["kind"], quality=86, optimize=True)
        pictures.append(base64.b64encode(file.getvalue()).decode())
    return pictures


if __name__ == "__main__":
    main()
