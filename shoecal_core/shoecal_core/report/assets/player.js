"use strict";
// Draws shapes through points that move in time: see `Player`. Nothing starts by itself; where
// less motion is wished for, playing shows a still a second.
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
      } else if (kind === "ring") {
        path(`M${place(points[0], 0)}m${more} 0a${more} ${more} 0 1 0 ${-2 * more} 0` +
          `a${more} ${more} 0 1 0 ${2 * more} 0`);
      } else if (kind === "way") {
        path(until(points[0], last));
      } else if (kind === "trace") {
        updates.push(frame => path(until(points[0], frame)));
      } else if (kind === "area") {
        updates.push(frame => {
          path("M" + points.map(point => place(point, frame)).join("L") + "Z");
          shape.classList.toggle("lifted", more === data.lifted[Math.floor(frame)]);
        });
      } else {
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
  const set = on => {
    playing = on;
    before = null;
    button.textContent = on ? "Pause" : "Play";
    if (on) requestAnimationFrame(step);
  };
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
