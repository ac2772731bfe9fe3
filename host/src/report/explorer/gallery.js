// The gallery: the classification at every early exit of a recording, and where it stops at a threshold.

/** The picture's box in a spectrogram: left edge, width, top, bottom. */
const PICTURE = { left: 56, width: 204, top: 8, bottom: 204 };

/** The exit at which a recording stops: the first that is sure enough, or the last in use. */
function stopOf(recording, threshold) {
  const last = recording.exits.findIndex((exit) => exit.sensing_slots === figures.early_exits.most_sensing_slots);
  const sure = recording.exits.findIndex((exit) => exit.confidence >= Math.fround(threshold));
  return sure >= 0 && sure < last ? sure : last;
}

/** A bar for every class. */
function probabilityBars(exit, truth) {
  return figures.classes.map((name, k) => {
    const fill = html("i");
    fill.style.width = `${100 * exit.probabilities[k]}%`;
    const own = name === truth ? "own" : "";
    const says = percent(exit.probabilities[k]);
    return html("li", { class: own }, html("span", {}, name), html("b", {}, fill), html("span", { "data-value": name }, says));
  });
}

/** The controls of one recording; `stop(threshold)` moves its mark. */
function exhibit(figure, recording, spectrogram) {
  const line = mark("path", { class: "stop" });
  figure.querySelector("svg").append(line);
  const verdict = html("p", { class: "verdict" });
  const bars = html("ul", { class: "bars", "aria-label": `class probabilities of ${recording.truth}` });
  const select = (k) => {
    bars.replaceChildren(...probabilityBars(recording.exits[k], recording.truth));
    buttons.forEach((button, own) => button.setAttribute("aria-pressed", own === k));
  };
  const buttons = recording.exits.map((exit, k) =>
    html("button", { type: "button", onclick: () => select(k), "aria-label": `after ${exit.sensing_slots} slots` }, String(exit.sensing_slots)),
  );
  const group = html("div", { class: "exits", role: "group", "aria-label": "sensing slots used" }, ...buttons);
  figure.append(verdict, group, bars);
  return (threshold) => {
    const k = stopOf(recording, threshold);
    const exit = recording.exits[k];
    const x = PICTURE.left + (PICTURE.width * exit.frames) / spectrogram.frames;
    line.setAttribute("d", `M${x.toFixed(1)} ${PICTURE.top}V${PICTURE.bottom}`);
    buttons.forEach((button, own) => button.classList.toggle("stops", own === k));
    const right = exit.class === recording.truth;
    verdict.className = right ? "verdict yes" : "verdict no";
    const stops = html("b", { "data-value": "stops after" }, String(exit.sensing_slots));
    const word = right ? "right" : "wrong";
    verdict.replaceChildren("stops after ", stops, ` slots: ${exit.class}, ${percent(exit.confidence)} (${word})`);
    select(k);
  };
}

function galleryPanel() {
  const row = document.querySelector("#spectrograms .row");
  const shown = [...row.querySelectorAll("figure")];
  const all = figures.early_exits.recordings.map((recording, k) => exhibit(shown[k], recording, figures.spectrograms[k]));
  const output = html("output", { for: "threshold" });
  const chosen = figures.early_exits.threshold;
  const slider = html("input", { type: "range", id: "threshold", min: 0.3, max: 1.005, step: 0.005, value: chosen });
  const show = (threshold) => {
    output.textContent = threshold > 1 ? "never before the last" : digits(threshold, 3);
    slider.setAttribute("aria-valuetext", output.textContent);
    all.forEach((stop) => stop(threshold));
  };
  slider.addEventListener("input", () => show(Number(slider.value)));
  const back = () => {
    slider.value = chosen;
    show(chosen);
  };
  row.before(
    html(
      "div",
      { class: "controls" },
      html("label", { class: "control", for: "threshold" }, "confidence that stops", slider),
      output,
      html("button", { type: "button", onclick: back }, "the run's own threshold"),
    ),
  );
  show(chosen);
}

if (figures.early_exits) galleryPanel();

