// The program of the commands in the page, which draws and classifies recordings of the reader's own.

const live = document.getElementById("data-live") && read("live");
const encoded = (value) => new TextEncoder().encode(typeof value === "string" ? value : JSON.stringify(value));
const bytesOf = (base64) => Uint8Array.from(atob(base64), (c) => c.charCodeAt(0));

async function compiled() {
  const packed = new Blob([bytesOf(live.program)]).stream();
  return WebAssembly.compile(await new Response(packed.pipeThrough(new DecompressionStream("gzip"))).arrayBuffer());
}

let program;
/** What a program that has ended printed; what it says on standard error is thrown. */
function printed({ exit, output, errors }) {
  if (exit !== 0) throw new Error(errors.trim() || `exit code ${exit}`);
  return output;
}

let last = (async () => null)();

/** Asks the program, one request after the other: the text it prints. */
function ask(request, files) {
  const answered = last.then(async () => {
    program ??= compiled();
    return printed(await execute(await program, encoded(request), files));
  });
  last = answered.catch(() => null);
  return answered;
}

const statusLine = () => html("p", { class: "status", role: "status" });
const labelled = (text, input) => html("label", { class: "control" }, text, input);

/** What a text field states, or nothing. */
const stated = (input) => (input.value.trim() === "" ? null : Number(input.value));

/** Classes over time: a row for each class, a block for each window of so many slots, the surer the darker. */
function classesOverTime(classes, windows, slots) {
  const [left, row, width, seconds] = [175, 28, 800, slots * live.interval_s];
  const names = windows.some((w) => w.class === "unknown") ? [...classes, "unknown"] : classes;
  const end = windows.at(-1).start_s + seconds;
  const x = (s) => left + ((width - left - 12) * s) / end;
  const height = row * names.length;
  const picture = mark("svg", { viewBox: `0 0 ${width} ${height + 46}`, role: "img", "aria-label": "class of every window over time" });
  names.forEach((name, k) => {
    picture.append(mark("text", { x: left - 8, y: row * k + 20, "text-anchor": "end", "font-size": 14 }, words(name)));
    picture.append(mark("path", { class: "axis", d: `M${left} ${row * (k + 1)}H${width - 12}` }));
  });
  for (const w of windows) {
    const k = names.indexOf(w.class);
    const text = `${w.start_s.toFixed(2)} s: ${words(w.class)}, ${percent(w.confidence)}`;
    const at = { x: x(w.start_s), y: row * k + 3, width: Math.max(1, x(w.start_s + seconds) - x(w.start_s) - 1), height: row - 6 };
    picture.append(mark("rect", { ...at, class: "window", opacity: Math.max(0.15, w.confidence) }, mark("title", {}, text)));
  }
  const tick = (s, anchor) => mark("text", { x: x(s), y: height + 17, "text-anchor": anchor, "font-size": 14 }, s.toFixed(2));
  picture.append(tick(0, "start"), tick(end / 2, "middle"), tick(end, "end"));
  picture.append(mark("text", { x: x(end / 2), y: height + 38, "text-anchor": "middle", "font-size": 14 }, "time (s)"));
  return html("figure", { class: "drawn" }, picture, html("figcaption", {}, `windows of ${slots} slots; the darker, the more confident`));
}

/** Doppler over time, the highest frequency on top. */
function spectrogramFigure({ rows, frames, first_row_hz, row_hz, frame_s, range_db, intensities }) {
  const canvas = html("canvas", { width: frames, height: rows, role: "img", "aria-label": "Doppler over time" });
  const image = new ImageData(frames, rows);
  for (let row = 0; row < rows; row++) {
    for (let frame = 0; frame < frames; frame++) {
      const at = 4 * ((rows - 1 - row) * frames + frame);
      image.data.set([...live.colours[intensities[row * frames + frame]], 255], at);
    }
  }
  canvas.getContext("2d").putImageData(image, 0, 0);
  const [low, high] = [first_row_hz, first_row_hz + (rows - 1) * row_hz].map((hz) => hz.toFixed(0));
  const text = `Doppler, ${low} to ${high} Hz upwards, over ${(frames * frame_s).toFixed(2)} s; black is ${digits(range_db, 0)} dB below the maximum`;
  return html("figure", { class: "drawn" }, canvas, html("figcaption", {}, text));
}

/** Most bytes of a file, and most windows in the table. */
const LARGEST = 2 ** 30;
const ROWS = 200;

function windowTable(windows) {
  const row = (w) => html("tr", {}, html("td", {}, w.start_s.toFixed(3)), html("td", {}, words(w.class)), html("td", {}, w.confidence.toFixed(4)));
  const head = ["start (s)", "class", "confidence"].map((name) => html("th", { scope: "col" }, name));
  const more = windows.length > ROWS ? html("p", {}, `the first ${ROWS} of ${windows.length} windows`) : null;
  return html("details", { open: true }, html("summary", {}, "windows"), html("div", { class: "scroll" }, html("table", {}, html("tr", {}, ...head), ...windows.slice(0, ROWS).map(row))), more);
}

function recordingPanel() {
  const section = document.getElementById("recording");
  let files = {};
  const number = (attributes) => html("input", { type: "number", onchange: () => classify(), ...attributes });
  const models = Object.keys(live.models).sort((a, b) => a - b);
  const option = (slots) => html("option", { value: slots, selected: slots === models.at(-1) }, slots);
  const model = html("select", { name: "model", onchange: () => classify() }, ...models.map(option));
  const step = number({ name: "step", min: 1, placeholder: "N_s" });
  const least = number({ name: "least-confidence", min: 0, max: 1, step: 0.05, value: 0 });
  const changed = () => named() && draw().then(classify);
  const carrier = number({ name: "carrier", placeholder: "of the file", onchange: changed });
  const rate = number({ name: "rate", placeholder: "of the file", onchange: changed });
  const antenna = number({ name: "antenna", min: 1, placeholder: "of a module", onchange: changed });
  const chirp = number({ name: "chirp", min: 1, placeholder: "of a frame", onchange: changed });
  const status = statusLine();
  const found = html("div", { id: "found" });
  const doppler = html("div", { id: "doppler" });
  /** The file that is read; what describes it is found beside it. */
  const named = () => {
    const names = Object.keys(files);
    return names.find((name) => !/\.(sigmf-data|json|cfg)$/i.test(name)) ?? names[0];
  };
  const recording = () => ({ file: named(), carrier_hz: stated(carrier), rate_hz: stated(rate), antenna: stated(antenna), chirp: stated(chirp) });

  async function draw() {
    try {
      const request = { recording: recording(), scenario: "scenario.toml" };
      const output = await ask({ spectrogram: request }, { ...files, "scenario.toml": new TextEncoder().encode(live.scenario) });
      doppler.replaceChildren(spectrogramFigure(JSON.parse(output)));
    } catch {
      // what classifies the recording says why it cannot be read
      doppler.replaceChildren();
    }
  }

  async function classify() {
    const [name, slots] = [named(), model.value];
    if (!name) return;
    const request = { model: `dsn-${slots}.sdp3`, recording: recording(), step: stated(step), least_confidence: stated(least) ?? 0 };
    status.textContent = `${name}: computing`;
    try {
      const output = await ask({ classify: request }, { ...files, [request.model]: bytesOf(live.models[slots]) });
      const { classes, recordings, sensing_slots } = JSON.parse(output);
      const [{ windows, format, slots: held }] = recordings;
      status.textContent = `${name}: ${format}, ${held} slots, windows: ${windows.length}`;
      found.replaceChildren(classesOverTime(classes, windows, sensing_slots), windowTable(windows));
      found.dataset.json = output;
    } catch (problem) {
      clear(problem.message);
    }
  }
  function clear(message) {
    status.textContent = message;
    found.replaceChildren();
    delete found.dataset.json;
  }
  async function take(list) {
    files = {};
    const large = [...list].find((file) => file.size > LARGEST);
    if (large) {
      doppler.replaceChildren();
      return clear(`${large.name}: ${large.size} bytes, must be at most ${LARGEST} in a page`);
    }
    for (const file of list) files[file.name] = new Uint8Array(await file.arrayBuffer());
    await draw();
    await classify();
  }
  const input = html("input", { type: "file", multiple: true, onchange: () => take(input.files) });
  const stop = (event) => event.preventDefault();
  const drop = (event) => {
    event.preventDefault();
    take(event.dataTransfer.files);
  };
  const zone = html("label", { class: "drop", ondragover: stop, ondrop: drop }, "Drop a recording here, or choose its files: ", input);
  const controls = [["model, N_s ", model], ["slots from window to window ", step], ["least confidence ", least], ["carrier (Hz) ", carrier], ["slots a second (Hz) ", rate], ["antenna ", antenna], ["chirp ", chirp]];
  section.append(zone, html("div", { class: "controls" }, ...controls.map(([text, input]) => labelled(text, input))), status, doppler, found);
}
