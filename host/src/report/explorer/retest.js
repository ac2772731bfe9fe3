// The run's int8 networks on test recordings that the program simulates at another rho.

/** Values of rho to choose from; the run's own comes to them. */
const RHOS = [0.9, 0.95, 0.97, 0.98, 0.985, 0.99, 0.993, 0.995, 0.997, 0.998, 0.999, 0.9995, 0.9999, 1];
/** Most test recordings of each class, and recordings in one request. */
const TESTED = 60;
const PART = 10;

/** Parts of the tests that were made, by the fields of their rooms. */
const tests = new Map();

/** Fields of the scenario at another rho: those that decide which recordings are simulated. */
function roomAt(rho) {
  const fewer = live.test_per_class > TESTED ? [`learning.test_per_class=${TESTED}`] : [];
  return [`channel.rho=${rho}`, ...fewer];
}

/** Tests the networks in a room with these fields: the parts of the test, or nothing if it is no longer wanted. */
async function retest(set, wanted, progress) {
  const key = set.join();
  if (tests.has(key)) return tests.get(key);
  const all = figures.classes.length * Math.min(live.test_per_class, TESTED);
  const slots = Object.keys(live.models);
  const models = slots.map((n) => `dsn-${n}.sdp3`);
  const files = { "scenario.toml": encoded(live.scenario) };
  slots.forEach((n, k) => (files[models[k]] = bytesOf(live.models[n])));
  const parts = [];
  let [next, done] = [0, 0];
  const work = async () => {
    while (next < all && wanted()) {
      const first = next;
      next += PART;
      const request = { models, scenario: "scenario.toml", set, seed: run.seed, first, count: PART };
      parts[first / PART] = await askBeside({ retest: request }, files);
      done = Math.min(all, done + PART);
      if (wanted()) progress(done, all);
    }
  };
  progress(0, all);
  await Promise.all(Array.from({ length: WORKERS }, work));
  if (!wanted()) return null;
  tests.set(key, parts);
  return parts;
}

/** Accuracies of the run's networks at both values of rho. */
function retestTable({ rho, accuracy }) {
  const head = ["N_s", `accuracy at rho = ${run.rho}`, `at rho = ${rho}`].map((name) => html("th", { scope: "col" }, name));
  const own = (slots) => run.accuracy.find((one) => one.sensing_slots === slots)?.int8;
  const row = ({ sensing_slots: n, int8 }) =>
    html("tr", {}, html("th", { scope: "row" }, n), html("td", {}, digits(own(n), 4)), html("td", { "data-value": `accuracy ${n}` }, digits(int8, 4)));
  return html("div", { class: "scroll retested" }, html("table", {}, html("tr", {}, ...head), ...accuracy.map(row)));
}
