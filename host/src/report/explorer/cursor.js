// A cursor that moves along the series of a plot: by mouse, by touch, by keyboard.

const BY_KEY = { ArrowRight: 1, ArrowLeft: -1, PageUp: 10, PageDown: -10, Home: -Infinity, End: Infinity };

/**
 * Puts a ring on the point chosen, which can be focused and dragged: left and right go along the series, Page by ten, Home and
 * End to its ends, up and down to another series. Pointing without pressing only reads. `series` are lists of `{x, y, ...}`;
 * `say(point)` are the pairs of the readout; `choose(point)` is called with every choice. Returns a function that chooses.
 */
function walk(figure, { label, series, say, choose = () => {}, start }) {
  const picture = figure.querySelector("svg");
  const scale = scaleOf(picture);
  const readout = readoutOf();
  picture.after(readout);
  const hair = mark("path", { class: "hair" });
  const ghost = mark("circle", { class: "ghost", r: 6 });
  const ring = mark("circle", { class: "ring", r: 8 });
  const handle = mark("g", { class: "handle", tabindex: 0, role: "slider", "aria-label": label, "aria-valuemin": 0 });
  handle.append(mark("circle", { class: "grip", r: 22 }), ring);
  picture.append(mark("g", { class: "cursor" }, hair, ghost, handle));
  picture.classList.add("walked");
  picture.setAttribute("role", "group");

  const all = series.flatMap((points, s) => points.map((point, k) => ({ point, s, k })));
  let chosen = start;
  let dragged = false;

  const at = ({ s, k }) => series[s][k];
  const pixels = (point) => [scale.x(point.x), scale.y(point.y)];
  const show = (point) => {
    const [x] = pixels(point);
    hair.setAttribute("d", `M${x.toFixed(1)} ${scale.y.from}V${scale.y.to}`);
    fillReadout(readout, say(point));
  };
  const go = (to, notify = true) => {
    chosen = to;
    const point = at(to);
    const [x, y] = pixels(point);
    handle.setAttribute("transform", `translate(${x.toFixed(1)} ${y.toFixed(1)})`);
    handle.setAttribute("aria-valuemax", series[to.s].length - 1);
    handle.setAttribute("aria-valuenow", to.k);
    handle.setAttribute("aria-valuetext", say(point).map((pair) => pair.join(" ")).join(", "));
    show(point);
    if (notify) choose(point);
  };
  const nearest = (event, own) => {
    const [px, py] = placeOf(picture, event);
    const far = ({ point }) => Math.hypot(scale.x(point.x) - px, scale.y(point.y) - py);
    const candidates = known(own) ? all.filter(({ s }) => s === own) : all;
    return candidates.reduce((best, next) => (far(next) < far(best) ? next : best));
  };
  const point = (to) => {
    const [x, y] = pixels(at(to));
    ghost.setAttribute("cx", x);
    ghost.setAttribute("cy", y);
    ghost.classList.add("seen");
    show(at(to));
  };
  const leave = () => {
    ghost.classList.remove("seen");
    show(at(chosen));
  };

  picture.addEventListener("pointerdown", (event) => {
    if (event.button !== 0) return;
    dragged = true;
    picture.setPointerCapture(event.pointerId);
    ghost.classList.remove("seen");
    go(nearest(event));
    handle.focus({ preventScroll: true });
    event.preventDefault();
  });
  picture.addEventListener("pointermove", (event) => (dragged ? go(nearest(event, chosen.s)) : point(nearest(event))));
  for (const end of ["pointerup", "pointercancel"]) picture.addEventListener(end, () => (dragged = false));
  picture.addEventListener("pointerleave", () => dragged || leave());
  handle.addEventListener("keydown", (event) => {
    const turn = { ArrowUp: 1, ArrowDown: -1 }[event.key];
    const step = BY_KEY[event.key];
    if (known(turn)) {
      const s = (chosen.s + turn + series.length) % series.length;
      go({ s, k: Math.min(chosen.k, series[s].length - 1) });
    } else if (known(step)) {
      go({ s: chosen.s, k: Math.min(Math.max(chosen.k + step, 0), series[chosen.s].length - 1) });
    } else return;
    event.preventDefault();
  });

  go(start, false);
  return { go, chosen: () => at(chosen) };
}

