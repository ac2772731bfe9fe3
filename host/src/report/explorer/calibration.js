// Calibration: the KL curve and the intensities, read point by point.

function klPanel() {
  const curve = figures.calibration.curve;
  const seen = (value) => Math.max(value, 1e-5);
  const series = ["kl", "kl_without_black"].map((name) => curve.map((point) => ({ ...point, x: point.rho, y: seen(point[name]) })));
  const least = curve.reduce((best, point, k) => (point.kl < curve[best].kl ? k : best), 0);
  const say = (point) => [
    ["rho", String(point.rho)],
    ["KL", digits(point.kl, 4)],
    ["KL without black", digits(point.kl_without_black, 4)],
  ];
  walk(plotOf("kl-curve"), { label: "channel correlation", series, say, start: { s: 0, k: least } });
}

function greyPanel() {
  const { measured_pmf: measured, simulated_pmf: simulated } = figures.calibration;
  const series = [measured, simulated].map((shares) => shares.map((share, level) => ({ x: level, y: share })).slice(1));
  const say = (point) => [
    ["intensity", String(point.x)],
    ["measured", percent(measured[point.x])],
    ["simulated", percent(simulated[point.x])],
  ];
  walk(plotOf("grey-levels"), { label: "intensity", series, say, start: { s: 0, k: Math.floor(series[0].length / 4) } });
}

if (figures.calibration.curve.length) klPanel();
if (figures.calibration.measured_pmf.length > 1) greyPanel();

