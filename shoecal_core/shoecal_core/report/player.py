"""An animation within a page: a script draws shapes through points that move in time.

Python says where points are and which shapes go through them; all drawing is the script's.
"""

from __future__ import annotations

import base64
import hashlib
import json
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]

SPEEDS = (1, 2, 4, 8)
USUAL_SPEED = 4

Shape = tuple[str, str, Sequence[int], float | str | None]
"""CSS class; kind; indices of points; what else the kind needs.

Kinds: `line` through pairs of points (width in mm or None: that of the class), `area` within
points (the foot of which it is the sole, `l` or `r`, or None), `way` of a point over the whole
motion, `trace` of it until now, `ring` about a point (radius in mm), `text` at a point (words).
"""


@dataclass(frozen=True)
class PlayerView:
    """A side from which the points are seen.

    Attributes:
        title: above it.
        right, down: axis (0, 1 or 2) and sign (1 or -1) of what is to the right and downwards.
        box: left, upper edge, width and height of what is shown [mm].
        shapes: the first is drawn first.
    """

    title: str
    right: tuple[int, int]
    down: tuple[int, int]
    box: tuple[float, float, float, float]
    shapes: tuple[Shape, ...]


@dataclass(frozen=True)
class Player:
    """An animation.

    Attributes:
        title, caption: above and below it.
        views: of it.
        points: see PlayerPoints.
        duration: of the motion [s].
        lifted: one letter a frame: the foot in the air, `l`, `r`, or `-` for none.
    """

    title: str
    views: tuple[PlayerView, ...]
    points: PlayerPoints
    duration: float
    lifted: str
    caption: str = ""

    @property
    def data(self) -> str:
        """JSON for the script."""
        views = [{"right": one.right, "down": one.down, "shapes": one.shapes} for one in self.views]
        rest = {"duration": self.duration, "lifted": self.lifted, "views": views}
        # A name that closes the script element must not be able to.
        return f'{{"points":{self.points.data},{_json(rest)[1:]}'.replace("<", "\\u003c")


class PlayerPoints:
    """Where points are in each frame; those that move alike are kept once.

    Args:
        frames: how many, at equal distances in time.
    """

    def __init__(self, frames: int) -> None:
        self._frames = frames
        self._tracks: dict[str, int] = {}

    def add(self, places: FloatArray, decimals: int = 0) -> list[int]:
        """Indices of points (F, k, 3), or (k, 3) that never move [m].

        Args:
            places: of the points.
            decimals: of millimetres that are kept.
        """
        moving = np.broadcast_to(places, (self._frames, *places.shape[-2:]))
        tracks = np.round(1e3 * moving, decimals).transpose(1, 2, 0).tolist()
        return [
            self._tracks.setdefault(_json([_track(axis) for axis in point]), len(self._tracks))
            for point in tracks
        ]

    @property
    def data(self) -> str:
        """JSON: of each point three lists over the frames [mm], a number where one is constant."""
        return f"[{','.join(self._tracks)}]"


def _track(values: list[float]) -> float | list[float]:
    numbers = [int(value) if value.is_integer() else value for value in values]
    return numbers[0] if len(set(numbers)) == 1 else numbers


def _json(value: object) -> str:
    return json.dumps(value, separators=(",", ":"), allow_nan=False)


SCRIPT = """\
"use strict";
const calm = matchMedia("(prefers-reduced-motion: reduce)");
for (const figure of document.querySelectorAll("figure.player")) {
const find = name => figure.querySelector(name);
const data = JSON.parse(find("script").textContent), last = data.lifted.length - 1;
const button = find("button"), slider = find("input"), shown = find("output");
const speed = find("select");
const at = (track, frame) => typeof track === "number" ? track :
 track[Math.floor(frame)] * (1 - frame % 1) + track[Math.ceil(frame)] * (frame % 1);
const updates = [];
figure.querySelectorAll("svg").forEach((svg, index) => {
const {right: [a, right], down: [b, down], shapes} = data.views[index];
const place = (point, frame) => [right * at(data.points[point][a], frame),
 down * at(data.points[point][b], frame)].map(value => value.toFixed(1)).join(" ");
const until = (point, frame) => "M" + Array.from({length: Math.floor(frame) + 1},
 (_, before) => place(point, before)).concat(place(point, frame)).join("L");
for (const [look, kind, points, more] of shapes) {
const tag = kind === "text" ? "text" : "path";
const shape = svg.appendChild(document.createElementNS(svg.namespaceURI, tag));
const path = d => shape.setAttribute("d", d);
shape.setAttribute("class", look);
if (kind === "text") {
shape.textContent = more;
const [x, y] = place(points[0], 0).split(" ");
shape.setAttribute("x", x); shape.setAttribute("y", y);
} else if (kind === "ring")
path(`M${place(points[0], 0)}m${more} 0a${more} ${more} 0 1 0 ${-2 * more} 0` +
 `a${more} ${more} 0 1 0 ${2 * more} 0`);
else if (kind === "way") path(until(points[0], last));
else if (kind === "trace") updates.push(frame => path(until(points[0], frame)));
else if (kind === "area") updates.push(frame => {
path("M" + points.map(point => place(point, frame)).join("L") + "Z");
shape.classList.toggle("lifted", more === data.lifted[Math.floor(frame)]);
}); else {
if (more) shape.setAttribute("stroke-width", more);
updates.push(frame => path(points.map(
 (point, end) => (end % 2 ? "L" : "M") + place(point, frame)).join("")));
}
}
});
let time = Number(slider.value), run = time, before = null, playing = false;
const show = () => {
const frame = Math.min(time / data.duration, 1) * last, text = time.toFixed(1) + " s";
for (const update of updates) update(frame);
shown.textContent = text;
slider.value = time;
slider.setAttribute("aria-valuetext", text);
};
const set = on => { playing = on; before = null; button.textContent = on ? "Pause" : "Play";
 if (on) requestAnimationFrame(step); };
const step = now => {
if (!playing) return;
const factor = Number(speed.value);
if (before !== null) run += (now - before) / 1000 * factor;
before = now;
time = Math.min(calm.matches ? Math.floor(run / factor) * factor : run, data.duration);
if (run >= data.duration) { time = data.duration; set(false); }
show();
if (playing) requestAnimationFrame(step);
};
button.addEventListener("click", () => {
if (!playing) { if (time >= data.duration - 0.05) time = 0; run = time; }
set(!playing);
});
slider.addEventListener("input", () => { time = run = Number(slider.value); show(); });
figure.hidden = false;
show();
}
"""
"""Nothing starts by itself; where less motion is wished for, playing shows a still a second."""


STYLE = """\
figure.player{margin-top:10px}
.views{display:grid;grid-template-columns:repeat(auto-fit,minmax(min(100%,260px),1fr));gap:14px;
 align-items:start}
.views p,.marks{font-size:13px;color:var(--muted)}
.views svg{max-width:560px;max-height:420px}
.views text{fill:var(--ink);text-anchor:middle;dominant-baseline:central}
.views .scale text{fill:var(--muted);text-anchor:end}
.views path{fill:none}
.views path:where(:not(.capsule)){stroke-width:1;vector-effect:non-scaling-stroke}
.views .capsule{stroke:var(--muted);stroke-opacity:.22;stroke-linecap:round}
.views .left,.views .right,.views .body{stroke-width:3;stroke-linecap:round}
.left{stroke:var(--blue);color:var(--blue)}
.right{stroke:var(--red);color:var(--red)}
.body{stroke:var(--slate);color:var(--slate)}
.com{stroke:var(--muted);color:var(--muted)}
.cop{stroke:var(--fail);color:var(--fail)}
.views .com,.views .cop{stroke-width:9;stroke-linecap:round}
.views .plumb,.views .floor,.views .scale path,.views .way,.views .polygon{stroke:var(--muted)}
.views .plumb{stroke-dasharray:3 2}
.views .sole{fill:var(--sole);stroke-width:2;stroke-linecap:butt}
.views .lifted{fill-opacity:0;stroke:var(--muted);stroke-dasharray:2 2}
.views .hull{stroke:var(--slate);stroke-dasharray:4 2}
.views .trace{stroke:var(--blue);stroke-width:2.5;stroke-linecap:round}
.views .mark{stroke:var(--ink);stroke-width:1.3}
.views .missed{stroke:var(--fail);stroke-dasharray:2.5 1.5}
.views text.mark{stroke:none;font-weight:600}
.views text.missed{fill:var(--fail)}
.marks{display:flex;flex-wrap:wrap;gap:2px 16px;margin-top:8px}
.marks span::before{content:"";display:inline-block;width:16px;height:3px;margin-right:6px;
 vertical-align:middle;background:currentColor}
.marks .com::before,.marks .cop::before{width:9px;height:9px;border-radius:50%}
.controls{display:flex;flex-wrap:wrap;align-items:center;gap:8px 14px;margin-top:10px}
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
