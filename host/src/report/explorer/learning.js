// Learning: accuracy over N_s with the best curve's band, any other model's curve, and the training losses.

function curvePanel() {
  const figure = plotOf("learning-curve");
  const { slots, models, band } = figures.prediction;
  const tested = run.accuracy.map((one) => ({ ...one, x: one.sensing_slots, y: one.int8 }));
  const low = Number(figure.querySelector("svg").dataset.y.split(" ")[0]);
  const fitted = slots
    .map((n, k) => ({ x: n, y: models[0].accuracy[k], band: band?.points[k] }))
    .filter((point) => point.y >= low);
  const say = (point) =>
    known(point.tested)
      ? [
          ["N_s", String(point.sensing_slots)],
          ["int8", digits(point.int8, 4)],
          ["float", digits(point.float, 4)],
          ["recordings", String(point.tested)],
        ]
      : [
          ["N_s", digits(point.x, 0)],
          [models[0].name, digits(point.y, 4)],
          ["95 % band", `${digits(point.band?.low, 3)}–${digits(point.band?.high, 3)}`],
        ];
  const series = [tested, fitted].filter((points) => points.length);
  walk(figure, { label: "accuracy over sensing slots", series, say, start: { s: 0, k: 0 } });
  modelTable(figure, slots, models);
}

/** Names of the models become buttons that draw their curve. */
function modelTable(figure, slots, models) {
  const picture = figure.querySelector("svg");
  const line = mark("path", { class: "compared" });
  picture.querySelector(".cursor").before(line);
  const scale = scaleOf(picture);
  const buttons = models.map((model) => {
    const button = html("button", { type: "button", "aria-pressed": false, title: "draw its curve" }, model.name);
    button.addEventListener("click", () => {
      const drawn = button.getAttribute("aria-pressed") === "true";
      buttons.forEach((other) => other.setAttribute("aria-pressed", false));
      button.setAttribute("aria-pressed", !drawn);
      line.setAttribute("d", drawn ? "" : pathOf(scale, slots.map((n, k) => [n, model.accuracy[k]])));
    });
    document.querySelector(`#models tr[data-model="${CSS.escape(model.name)}"] th`).replaceChildren(button);
    return button;
  });
}

function lossPanel() {
  const series = figures.training.map((training) =>
    training.epochs.map((epoch, k) => ({ ...epoch, x: k + 1, y: epoch.loss, slots: training.sensing_slots })),
  );
  const say = (point) => [
    ["N_s", String(point.slots)],
    ["epoch", String(point.x)],
    ["loss", digits(point.loss, 4)],
    ["trained right", percent(point.accuracy)],
    ...(known(point.validation_loss) ? [["validation loss", digits(point.validation_loss, 4)]] : []),
  ];
  walk(plotOf("training-loss"), { label: "training loss over epochs", series, say, start: { s: 0, k: 0 } });
}

if (run.accuracy.length && figures.prediction.slots.length) curvePanel();
if (figures.training.length && figures.training.every((training) => training.epochs.length)) lossPanel();

