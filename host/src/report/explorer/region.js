// The accuracy-throughput region: an operating point that is dragged along a boundary or chosen by weights, and its slot plan.

function regionPanel() {
  const figure = plotOf("region");
  const cases = [...new Set(run.region.map((point) => point.case))];
  const series = cases.map((number) =>
    run.region
      .filter((point) => point.case === number)
      .map((point) => ({ ...point, x: point.accuracy, y: point.throughput_bit / run.operating_point.period_s / 1e6 })),
  );
  // results of every optimum hold its point; where they do not, the nearest is shown
  const find = (number, slots) => {
    const s = cases.indexOf(number);
    const far = (k) => Math.abs(series[s][k].sensing_slots - slots);
    return { s, k: series[s].reduce((best, _, k) => (far(k) < far(best) ? k : best), 0) };
  };
  const own = run.operating_point;
  const say = (point) => [
    ["case", String(point.case)],
    ["N_s", String(point.sensing_slots)],
    ["N_c", point.communication_slots.join(" + ") || "–"],
    ["accuracy", digits(point.accuracy, 4)],
    ["95 % band", `${digits(point.accuracy_low, 3)}–${digits(point.accuracy_high, 3)}`],
    ["throughput", megabit(point.throughput_bit)],
    ["rate", megabitPerSecond(point.throughput_bit)],
    ["curve", point.extrapolated ? "extrapolated" : "measured range"],
    ["zone", words(point.zone)],
  ];
  const plan = html("div", { class: "plan", role: "group", "aria-label": "slot plan of the chosen point" });
  const weights = weightControl((number, slots) => cursor.go(find(number, slots)));
  const choose = (point) => {
    fillPlan(plan, point);
    weights.show(point);
  };
  const start = find(own.case, own.sensing_slots);
  const label = "operating point on the boundary";
  const cursor = walk(figure, { label, series, say, choose, start });
  const back = html("button", { type: "button", onclick: () => cursor.go(start) }, "the run's own point");
  figure.append(html("div", { class: "controls" }, weights.element, back), plan);
  choose(cursor.chosen());
}

/** A slider over the weights w_A for which the results hold the optimum, and the user placement they are of. */
function weightControl(go) {
  const of = (number) => figures.weighted.filter((point) => point.case === number);
  let placement = run.operating_point.case;
  const output = html("output", { for: "weight" });
  const steps = of(placement).length;
  const slider = html("input", { type: "range", id: "weight", min: 0, max: steps - 1, value: (steps - 1) / 2 });
  const optimum = () => of(placement)[Number(slider.value)];
  slider.addEventListener("input", () => go(placement, optimum().sensing_slots));
  const radio = (number) => {
    const pick = () => {
      placement = number;
      go(number, optimum().sensing_slots);
    };
    const input = html("input", { type: "radio", name: "placement", value: number, onchange: pick });
    return html("label", {}, input, `case ${number}`);
  };
  const radios = [...new Set(figures.weighted.map((point) => point.case))].map(radio);
  const element = html(
    "fieldset",
    {},
    html("legend", {}, "largest w_A A + w_R R"),
    ...radios,
    html("label", { class: "control", for: "weight" }, "w_A", slider),
    output,
  );
  const show = (point) => {
    placement = point.case;
    for (const input of element.querySelectorAll("input[type=radio]")) input.checked = Number(input.value) === placement;
    const same = of(placement).filter((best) => best.sensing_slots === point.sensing_slots);
    const at = optimum();
    const best = same.includes(at) ? at : same[0];
    if (best) slider.value = of(placement).indexOf(best);
    const text = best ? `w_A = ${digits(best.weight, 2)}, w_R = ${digits(1 - best.weight, 2)}` : "chosen by hand";
    output.textContent = text;
    slider.setAttribute("aria-valuetext", text);
  };
  return { element, show };
}

/** Slots, bits and waits of every user, and the period as the core's scheduler plays it. */
function fillPlan(element, point) {
  const { period_slots: period, spacing_slots: spacing } = run.operating_point;
  const ofCase = figures.cases.find((one) => one.case === point.case);
  const same = (plan) => plan.case === point.case && plan.sensing_slots === point.sensing_slots;
  const plan = figures.plans.find(same);
  const cell = (value, name) => html("td", { "data-value": name }, value);
  const row = (name, sensing, values) =>
    html(
      "tr",
      {},
      html("th", { scope: "row" }, name),
      cell(sensing, name),
      ...point.communication_slots.map((_, k) => cell(values?.[k] ?? "–", `${name} ${k + 1}`)),
    );
  const bits = ofCase?.slot_bit.map((bit) => grouped(Math.round(bit)));
  const symbols = ofCase?.links?.map((link) => digits(link.subcarrier_bit, 3));
  const share = ({ full_share, subcarriers }) =>
    full_share === undefined ? "–" : `${Math.round(full_share * subcarriers)} of ${subcarriers}`;
  const full = ofCase?.links?.map(share);
  const head = ["", "sensing", ...point.communication_slots.map((_, k) => useName(k))];
  const table = html(
    "table",
    {},
    html("caption", {}, `N = ${period} slots a period, N_m = ${spacing} between two sensing slots`),
    html("tr", {}, ...head.map((name) => html("th", { scope: "col" }, name))),
    row("slots", String(point.sensing_slots), point.communication_slots.map(String)),
    row("bit a slot", "–", bits),
    row("bit a symbol and sub-carrier", "–", symbols),
    row("sub-carriers at the modulation's limit", "–", full),
    row("longest wait", "–", plan?.longest_wait_slots.map(String)),
  );
  element.replaceChildren(html("div", { class: "scroll" }, table));
  if (plan) element.append(planStrips(plan, period));
}

if (run.region.length) regionPanel();

