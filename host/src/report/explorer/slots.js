// Slots as strips: a period in columns, slots one by one, and the panel that walks along a period.

const WINDOW = 80;

const block = (x, y, width, height, code) =>
  mark("rect", { x: x.toFixed(2), y: y.toFixed(2), width: width.toFixed(2), height: height.toFixed(2), fill: useColour(code) });

/** Slots one by one in a box `[x, y, width, height]`. */
function oneByOne([x, y, width, height], codes) {
  const each = width / codes.length;
  return codes.map((code, k) => block(x + k * each, y, each, height, code));
}

/** Columns of a period: slots of `[sensing, user 0, ..]` in each. */
function inColumns([x, y, width, height], columns) {
  const each = width / columns.length;
  return columns.flatMap((uses, column) => {
    const total = uses.reduce((sum, n) => sum + n, 0);
    let top = y;
    return uses.map((n, use) => {
      const part = block(x + column * each, top, each, (height * n) / total, use - 1);
      top += (height * n) / total;
      return part;
    });
  });
}

/** Ticks below a box, from one slot to another. */
function ticks([x, y, width, height], from, to) {
  return [0, 1, 2, 3, 4].flatMap((k) => {
    const at = x + (width * k) / 4;
    const slot = Math.round(from + ((to - from) * k) / 4);
    return [
      mark("path", { d: `M${at} ${y + height}v5`, stroke: "var(--ink)" }),
      mark("text", { x: at, y: y + height + 18, "text-anchor": k === 4 ? "end" : "middle" }, String(slot)),
    ];
  });
}

/** The strips of a plan that is not played: the whole period in columns, its first slots one by one. */
function planStrips(plan, period) {
  const boxes = [[20, 26, 600, 34], [20, 112, 600, 34]];
  const title = (text, y) => mark("text", { x: 20, y }, text);
  return mark(
    "svg",
    { viewBox: "0 0 640 170", role: "img", "aria-label": "slots of the plan", "font-size": 12, fill: "var(--ink)" },
    title(`share of each use over the slot number, 0 to ${period}`, 20),
    ...inColumns(boxes[0], plan.columns),
    ...ticks(boxes[0], 0, period),
    title("its first slots, one by one (slot number)", 106),
    ...oneByOne(boxes[1], plan.first),
    ...ticks(boxes[1], 0, plan.first.length),
  );
}

/** The run's period: a window of slots one by one that walks along it. */
function timelinePanel() {
  const figure = plotOf("timeline");
  const slots = run.schedule.timeline.flatMap(([code, n]) => Array(n).fill(code));
  if (slots.length <= WINDOW) return;
  const picture = figure.querySelector("svg");
  const [whole, first] = ["whole", "first"].map((name) => picture.querySelector(`[data-strip="${name}"]`));
  const boxOf = (strip) => strip.dataset.box.split(" ").map(Number);
  const [wide, near] = [boxOf(whole), boxOf(first)];
  const frame = mark("rect", { class: "frame", y: wide[1] - 2, height: wide[3] + 4, width: (wide[2] * WINDOW) / slots.length });
  picture.append(frame);
  const readout = readoutOf();
  const slider = html("input", { type: "range", min: 0, max: slots.length - WINDOW, value: 0, id: "first-slot" });
  const shown = () => Number(slider.value);
  const say = () => {
    const own = slots.slice(shown(), shown() + WINDOW);
    const uses = [...new Set(slots)].sort((a, b) => a - b);
    const count = (code) => [useName(code), String(own.filter((slot) => slot === code).length)];
    fillReadout(readout, [["slots", `${shown()}–${shown() + WINDOW - 1}`], ...uses.map(count)]);
  };
  const draw = () => {
    const own = slots.slice(shown(), shown() + WINDOW);
    const title = mark("text", { x: near[0], y: near[1] - 6 }, "slots one by one (slot number)");
    first.replaceChildren(...oneByOne(near, own), title, ...ticks(near, shown(), shown() + WINDOW));
    frame.setAttribute("x", wide[0] + (wide[2] * shown()) / slots.length);
    say();
  };
  const slotAt = (event, box, from, count) => {
    const share = (placeOf(picture, event)[0] - box[0]) / box[2];
    return from + Math.min(Math.max(Math.floor(share * count), 0), count - 1);
  };
  slider.addEventListener("input", draw);
  whole.addEventListener("pointerdown", (event) => {
    slider.value = slotAt(event, wide, 0, slots.length) - WINDOW / 2;
    draw();
  });
  first.addEventListener("pointermove", (event) => {
    const slot = slotAt(event, near, shown(), WINDOW);
    fillReadout(readout, [["slot", String(slot)], ["use", useName(slots[slot])]]);
  });
  first.addEventListener("pointerleave", say);
  picture.after(readout, html("label", { class: "control" }, "first slot of the window", slider));
  draw();
}

timelinePanel();

