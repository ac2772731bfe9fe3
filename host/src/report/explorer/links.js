// The region that the program computes at another rho and for other links.

/** Boundaries of the run and of what was computed, on scales that hold both; points are `[accuracy, Mbit/s]`. */
function twoRegions(own, computed) {
  const [left, right, top, bottom, width, height] = [70, 12, 10, 46, 800, 340];
  const all = [...own, ...computed].flat();
  const axis = (k, from, to) => {
    const [low, high] = [Math.min(...all.map((p) => p[k])), Math.max(...all.map((p) => p[k]))];
    return Object.assign((v) => from + ((to - from) * (v - low)) / (high - low || 1), { low, high, from, to });
  };
  const scale = { x: axis(0, left, width - right), y: axis(1, height - bottom, top) };
  const lines = (boundaries, name) => boundaries.map((points) => mark("path", { class: name, d: pathOf(scale, points) }));
  const write = (x, y, anchor, text) => mark("text", { x, y, "text-anchor": anchor, "font-size": 14 }, text);
  const [base, middle] = [height - bottom, (left + width - right) / 2];
  return mark(
    "svg",
    { viewBox: `0 0 ${width} ${height}`, role: "img", "aria-label": "regions of the run and of what was chosen" },
    mark("path", { class: "axis", d: `M${left} ${top}V${base}H${width - right}` }),
    ...lines(own, "own"),
    ...lines(computed, "compared"),
    ...[scale.x.low, (scale.x.low + scale.x.high) / 2, scale.x.high].map((v, k) => write(scale.x(v), base + 18, ["start", "middle", "end"][k], v.toFixed(2))),
    ...[scale.y.low, (scale.y.low + scale.y.high) / 2, scale.y.high].map((v, k) => write(left - 6, scale.y(v) + (k === 2 ? 14 : k ? 5 : 0), "end", v.toFixed(1))),
    write(middle, height - 6, "middle", "recognition accuracy A; upwards: throughput of the worst user (Mbit/s)"),
  );
}

/** The region at another rho and for other links, as `sdp3 optimize` finds it. */
function linkPanel() {
  const { power_w, noise_figure_db, cases, slot_bit } = live.communication;
  // bits of a slot that are stated do not depend on the link
  const computed = !known(slot_bit);
  if (!computed && !live.has_rho) return;
  const figure = plotOf("region");
  const drawn = html("div", { class: "drawn" });
  const most = Math.max(...cases.map((users) => users.length));
  const dbm = (watt) => 10 * Math.log10(watt) + 30;
  const watt = (level) => Number((10 ** ((level - 30) / 10)).toPrecision(6));
  const status = statusLine();
  const readout = readoutOf();
  const command = html("code", { class: "command" });
  const slider = (name, text, shown, attributes) => {
    const output = html("output", {});
    const input = html("input", { type: "range", name, ...attributes, oninput: () => say(), onchange: () => compute() });
    const say = () => {
      output.textContent = shown(Number(input.value));
      input.setAttribute("aria-valuetext", output.textContent);
    };
    say();
    // the browser may have rounded it
    const own = input.value;
    const reset = () => {
      input.value = own;
      say();
    };
    return { input, element: html("label", { class: "control" }, text, input, output), moved: () => input.value !== own, reset };
  };
  const start = Math.round(dbm(power_w));
  const power = slider("power", "power of the base station", (level) => `${level} dBm`, { min: Math.min(-20, start), max: Math.max(50, start), value: start });
  const noise = slider("noise", "receivers' noise figure", (level) => `${level} dB`, { min: 0, max: Math.max(20, noise_figure_db), step: 0.5, value: noise_figure_db });
  const users = slider("users", "receivers", String, { min: 1, max: most, value: most });
  const rhos = [...new Set([...RHOS, run.rho])].sort((a, b) => a - b);
  const place = { min: 0, max: rhos.length - 1, value: rhos.indexOf(run.rho) };
  const rho = slider("rho", "rho, correlation from slot to slot", (k) => String(rhos[k]), place);
  const controls = [...(live.has_rho ? [rho] : []), ...(computed ? [power, noise, users] : [])];
  const room = () => (rho.moved() ? roomAt(rhos[Number(rho.input.value)]) : []);
  const overrides = () => {
    const set = room();
    if (power.moved()) set.push(`communication.power_w=${watt(Number(power.input.value))}`);
    if (noise.moved()) set.push(`communication.noise_figure_db=${noise.input.value}`);
    if (users.moved()) {
      set.push(`communication.cases=${JSON.stringify(cases.map((places) => places.slice(0, Number(users.input.value))))}`);
    }
    return set;
  };
  let turn = 0;
  async function compute() {
    const [own, rooms, set] = [++turn, room(), overrides()];
    const wanted = () => own === turn;
    const moved = rooms.length > 0;
    status.textContent = "computing";
    for (const old of [drawn, readout]) old.classList.add("stale");
    command.textContent = ["sdp3 optimize", ...(moved ? ["--retest"] : []), ...set.map((one) => `--set '${one}'`)].join(" ");
    try {
      const progress = (done, all) => (status.textContent = `${done} of ${all} test recordings simulated and classified at this rho; computing`);
      const parts = moved ? await retest(rooms, wanted, progress) : [];
      if (!wanted()) return;
      const files = { "run.json": encoded(run), "scenario.toml": encoded(live.scenario) };
      const retested = parts.map((part, k) => {
        files[`part-${k}.json`] = encoded(part);
        return `part-${k}.json`;
      });
      const output = await askBeside({ optimize: { points: "run.json", retested, scenario: "scenario.toml", set, seed: run.seed } }, files);
      if (!wanted()) return;
      const found = JSON.parse(output);
      const point = found.operating_point;
      const boundary = (region, number) => region.filter((p) => p.case === number).map((p) => [p.accuracy, p.throughput_bit / point.period_s / 1e6]);
      const boundaries = (region) => found.cases.map((one) => boundary(region, one.case));
      drawn.replaceChildren(twoRegions(boundaries(run.region), boundaries(found.region)), ...(moved ? [retestTable(found.retested)] : []));
      fillReadout(readout, [
        ["case", String(point.case)],
        ["N_s", String(point.sensing_slots)],
        ["N_c", point.communication_slots.join(" + ")],
        ["accuracy", digits(point.accuracy, 4)],
        ["throughput", megabit(point.throughput_bit)],
        ["rate", megabitPerSecond(point.throughput_bit)],
        ["zone", words(point.zone)],
      ]);
      const tested = moved
        ? ` The networks learned at rho = ${run.rho} and were tested on ${found.retested.accuracy[0].tested} recordings at rho = ${found.retested.rho}: no new training.`
        : "";
      status.textContent = `computed: full lines are the boundaries at this rho and of these links, dotted ones those of the run.${tested}`;
      readout.dataset.json = output;
    } catch (problem) {
      if (!wanted()) return;
      status.textContent = problem.message;
      drawn.replaceChildren();
      readout.replaceChildren();
      delete readout.dataset.json;
    }
    for (const old of [drawn, readout]) old.classList.remove("stale");
  }
  const reset = () => {
    controls.forEach((one) => one.reset());
    compute();
  };
  const fields = html("fieldset", { id: "links" }, html("legend", {}, "compute the region at another rho and for other links"), ...controls.map((one) => one.element), html("button", { type: "button", onclick: reset }, "as in the run"));
  figure.append(html("div", { class: "controls" }, fields), status, readout, drawn, command);
}

if (live) {
  recordingPanel();
  linkPanel();
}
