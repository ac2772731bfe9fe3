// What the page shows: the run's own JSON, embedded; and how its numbers are written.

const read = (name) => JSON.parse(document.getElementById(`data-${name}`).textContent);
const run = read("run");
const figures = read("figures");

const known = (x) => x !== null && x !== undefined;
const digits = (x, n) => (known(x) ? x.toFixed(n) : "–");
const percent = (x) => `${digits(100 * x, 1)} %`;
const megabit = (bit) => `${digits(bit / 1e6, 3)} Mbit per period`;
const megabitPerSecond = (bit) => `${digits(bit / run.operating_point.period_s / 1e6, 3)} Mbit/s`;
const grouped = (n) => String(n).replace(/\B(?=(\d{3})+$)/g, "\u202f");
const words = (name) => name.replaceAll("-", " ");

/** Name of a use of a slot: -2 idle, -1 sensing, else the user's index. */
const useName = (code) => (code === -2 ? "idle" : code === -1 ? "sensing" : `user ${code + 1}`);

/** Its colour; the eighth user's is the ninth of the palette's. */
const useColour = (code) => {
  if (code === -2) return "#e6e6e6";
  if (code === -1) return "var(--ink)";
  return code < 7 ? `var(--series-${code})` : "#f0e442";
};

