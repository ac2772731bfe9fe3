// Calibration: the KL curve and the intensities, read point by point.

function klPanel() {
  const curve = figures.calibration.curve;
  const seen = (value) => Math.max(value, 1e-5);
  // rho = 1 stands at the left edge of an axis of 1 - rho
  const least = Math.min(0.1, ...curve.map((point) => 1 - point.rho).filter((x) => x > 1e-12)) / 3;
  const at = (rho) => Math.max(1 - rho, least);
  const series = ["kl", "kl_without_floor"].map((name) => curve.map((point) => ({ ...point, x: at(point.rho), y: seen(point[name]) })));
  const start = curve.reduce((best, point, k) => (point.kl < curve[best].kl ? k : best), 0);
  const say = (point) => [
    ["rho", String(point.rho)],
    ["KL", digits(point.kl, 4)],
    ["KL without the floor", digits(point.kl_without_floor, 4)],
  ];
  walk(plotOf("kl-curve"), { label: "channel correlation", series, say, start: { s: 0, k: start } });
}

function greyPanel() {
  const { measured_pmf: measured, simulated_pmf: simulated } = figures.calibration;
  const series = [measured, simulated].map((shares) => shares.map((share, level) => ({ x: level, y: 100 * share })).slice(1));
  const say = (point) => [
    ["intensity", String(point.x)],
    [figures.calibration.measured ? "measured" : "surrogate", percent(measured[point.x])],
    ["simulated", percent(simulated[point.x])],
  ];
  walk(plotOf("intensities"), { label: "intensity", series, say, start: { s: 0, k: Math.floor(series[0].length / 4) } });
}

if (figures.calibration.curve.length) klPanel();
if (figures.calibration.measured_pmf.length > 1) greyPanel();

