"""An animation within a page: shapes of an SVG that follow points in time.

The figure as it stands is a still. The script below moves it: every element inside a `data-view`
group names the points it is drawn through, and the frames hold where these are.
"""

from __future__ import annotations

import base64
import hashlib
import json
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from shoecal_core.errors import ShapeError

FloatArray = NDArray[np.float64]

SPEEDS = (1, 2, 4, 8)
USUAL_SPEED = 4


@dataclass(frozen=True)
class PlayerView:
    """How points are projected into a figure: u = au + su p[axis_u], v = av + sv p[axis_v].

    Attributes:
        axes: two of 0, 1, 2: what goes to the right, and what goes along the vertical.
        scales: units a metre; negative where an axis points to the left or upwards.
        offsets: of the origin, in units.
    """

    axes: tuple[int, int]
    scales: tuple[float, float]
    offsets: tuple[float, float]

    def project(self, points: FloatArray) -> FloatArray:
        """Points (..., 3) [m] to units (..., 2)."""
        seen: FloatArray = points[..., list(self.axes)] * self.scales + np.array(self.offsets)
        return seen

    @property
    def attribute(self) -> str:
        """For the script, for points in millimetres."""
        numbers = (
            (axis, scale / 1e3, offset)
            for axis, scale, offset in zip(self.axes, self.scales, self.offsets, strict=True)
        )
        return " ".join(f"{axis} {scale:.5g} {offset:.6g}" for axis, scale, offset in numbers)


@dataclass(frozen=True)
class PlayerFrames:
    """Where points are over time.

    Attributes:
        duration: from the first to the last frame [s].
        points: (F, P, 3) at equal distances in time [m].
        lifted: one letter a frame: the foot in the air, `l`, `r`, or `-` for none.
        decimals: of millimetres, a point.
    """

    duration: float
    points: FloatArray
    lifted: str
    decimals: tuple[int, ...]

    def __post_init__(self) -> None:
        wanted = (len(self.lifted), len(self.decimals), 3)
        if self.points.shape != wanted:
            raise ShapeError("frames", str(wanted), self.points.shape)

    def to_json(self) -> str:
        """For the script: of each point three lists [mm], a number where one never changes."""
        tracks = [
            [_track(1e3 * self.points[:, point, axis], decimals) for axis in range(3)]
            for point, decimals in enumerate(self.decimals)
        ]
        frames = {"duration": round(self.duration, 3), "lifted": self.lifted, "points": tracks}
        # A name that closes the script element must not be able to.
        return json.dumps(frames, separators=(",", ":"), allow_nan=False).replace("<", "\\u003c")


def _track(values: FloatArray, decimals: int) -> float | list[float]:
    rounded = np.round(values, decimals) + 0.0
    numbers = [int(value) if decimals == 0 else float(value) for value in rounded]
    return numbers[0] if len(set(numbers)) == 1 else numbers


SCRIPT = """\
"use strict";
const calm = matchMedia("(prefers-reduced-motion: reduce)");
for (const figure of document.querySelectorAll("figure.player")) {
const data = JSON.parse(figure.querySelector("script").textContent);
const find = name => figure.querySelector(name);
const button = find("button"), slider = find("input"), shown = find("output");
const speed = find("select"), last = data.lifted.length - 1;
const value = (track, frame, part) => typeof track === "number" ? track :
 track[frame] + (part ? (track[frame + 1] - track[frame]) * part : 0);
const numbers = text => text.split(" ").map(Number);
const shapes = [];
for (const view of figure.querySelectorAll("[data-view]")) {
const [a, sa, oa, b, sb, ob] = numbers(view.dataset.view);
const place = (point, frame, part) => [
 (oa + sa * value(data.points[point][a], frame, part)).toFixed(1),
 (ob + sb * value(data.points[point][b], frame, part)).toFixed(1)];
for (const shape of view.querySelectorAll("[data-through]"))
 shapes.push([shape, numbers(shape.dataset.through), place]);
}
const draw = (shape, points, place, frame, part) => {
const kind = shape.dataset.kind;
if (kind === "dot") {
const [x, y] = place(points[0], frame, part);
shape.setAttribute("cx", x); shape.setAttribute("cy", y);
} else if (kind === "bones") {
let d = "";
points.forEach((point, i) => { d += (i % 2 ? "L" : "M") + place(point, frame, part).join(" "); });
shape.setAttribute("d", d);
} else if (kind === "area") {
shape.setAttribute("d", "M" + points.map(
 point => place(point, frame, part).join(" ")).join("L") + "Z");
} else {
const way = [];
for (let i = 0; i <= frame; i++) way.push(place(points[0], i, 0).join(" "));
way.push(place(points[0], frame, part).join(" "));
shape.setAttribute("d", "M" + way.join("L"));
}
};
let time = Number(slider.value), before = null, playing = false;
const show = () => {
const at = Math.min(time / data.duration, 1) * last;
const frame = Math.min(Math.floor(at), last), part = frame < last ? at - frame : 0;
for (const [shape, points, place] of shapes) draw(shape, points, place, frame, part);
for (const sole of figure.querySelectorAll("[data-foot]"))
 sole.classList.toggle("lifted", sole.dataset.foot === data.lifted[frame]);
const text = time.toFixed(1) + " s";
for (const label of figure.querySelectorAll("[data-time]")) label.textContent = text;
shown.textContent = text;
slider.value = time;
slider.setAttribute("aria-valuetext", text);
};
const set = on => { playing = on; before = null; button.textContent = on ? "Pause" : "Play";
 if (on) requestAnimationFrame(step); };
let run = 0;
const step = now => {
if (!playing) return;
if (before !== null) run += (now - before) / 1000 * Number(speed.value);
before = now;
const still = Number(speed.value);
time = Math.min(calm.matches ? Math.floor(run / still) * still : run, data.duration);
if (run >= data.duration) { time = data.duration; set(false); }
show();
if (playing) requestAnimationFrame(step);
};
button.addEventListener("click", () => {
if (!playing) { if (time >= data.duration - 0.05) time = 0; run = time; }
set(!playing);
});
slider.addEventListener("input", () => { time = run = Number(slider.value); show(); });
find(".controls").hidden = false;
}
"""
"""Nothing starts by itself; where less motion is wished for, playing shows a still a second."""


STYLE = """\
figure.player{margin-top:10px}
.views{display:grid;grid-template-columns:repeat(auto-fit,minmax(min(100%,320px),1fr));gap:14px;
 align-items:start}
.views svg{max-width:560px;font-size:10px}
.views text{fill:var(--ink)}
.views .s{font-size:9px}
.views .m{fill:var(--muted)}
.views .i{text-anchor:middle;font-weight:600}
.views .e{text-anchor:end;font-variant-numeric:tabular-nums}
.views path{fill:none}
.views .b{stroke-width:2.4;stroke-linecap:round}
.views .c{stroke:var(--muted);stroke-opacity:.22;stroke-linecap:round}
.views .d,.views .f,.views .r{stroke:var(--muted);stroke-width:.8}
.views .d{stroke-dasharray:3 2}
.views .k{fill:var(--muted)}
.views .p{fill:var(--fail);stroke:var(--card);stroke-width:1}
.views .o{stroke-width:1.6}
.views .g{fill:var(--sole)}
.views .lifted{fill-opacity:0;stroke:var(--muted);stroke-dasharray:2 2;stroke-width:1.2}
.views .q{stroke:var(--muted);stroke-width:.9}
.views .h{stroke:var(--slate);stroke-dasharray:4 2}
.views .w{stroke:var(--muted);stroke-width:.8}
.views .t{stroke:var(--blue);stroke-width:2.4;stroke-linecap:round}
.views .l{fill:none;stroke:var(--ink);stroke-width:1.2}
.views circle.n{stroke:var(--fail);stroke-dasharray:2.5 1.5}
.views text.n{fill:var(--fail)}
.controls{display:flex;flex-wrap:wrap;align-items:center;gap:8px 14px;margin-top:10px}
.controls[hidden]{display:none}
.controls button,.controls select{font:inherit;color:inherit;background:var(--paper);
 border:1px solid var(--muted);border-radius:6px;padding:5px 12px;min-height:36px}
.controls button{min-width:76px;cursor:pointer}
.controls input{flex:1 1 160px;min-width:120px;height:36px;accent-color:var(--blue)}
.controls output{min-width:52px;text-align:right;font-variant-numeric:tabular-nums}
.controls label{color:var(--muted);font-size:13px}
.controls :focus-visible{outline:2px solid var(--blue);outline-offset:2px}
@media print{.controls{display:none}}
"""


def script_hash() -> str:
    """Source expression that lets this script run in a page, and nothing else."""
    digest = hashlib.sha256(SCRIPT.encode()).digest()
    return f"'sha256-{base64.b64encode(digest).decode()}'"
