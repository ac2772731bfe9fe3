// Elements of the page and of its pictures, and the scale of a plot.

const SVG = "http://www.w3.org/2000/svg";

function filled(element, attributes, children) {
  for (const [name, value] of Object.entries(attributes)) {
    if (name.startsWith("on")) element.addEventListener(name.slice(2), value);
    else if (value === true) element.setAttribute(name, "");
    else if (value !== false && known(value)) element.setAttribute(name, value);
  }
  element.append(...children.filter(known));
  return element;
}

const html = (name, attributes = {}, ...children) => filled(document.createElement(name), attributes, children);
const mark = (name, attributes = {}, ...children) => filled(document.createElementNS(SVG, name), attributes, children);

/** Pairs of a name and a value, side by side as the page's width allows. */
function fillReadout(readout, pairs) {
  readout.replaceChildren(
    ...pairs.map(([name, value]) => html("div", {}, html("dt", {}, name), html("dd", { "data-value": name }, value))),
  );
}

const readoutOf = () => html("dl", { class: "readout" });

/** Where values lie in a plot, in the units of its view box. */
function scaleOf(picture) {
  const axis = (text, log) => {
    const [low, high, from, to] = text.split(" ").map(Number);
    const map = (value) => (log ? Math.log10(Math.max(value, 1e-300)) : value);
    const at = (value) => from + ((to - from) * (map(value) - map(low))) / (map(high) - map(low));
    return Object.assign(at, { low, high, from, to });
  };
  return { x: axis(picture.dataset.x, picture.dataset.logX === "true"), y: axis(picture.dataset.y, picture.dataset.log === "true") };
}

/** A pointer's place in the units of a picture's view box. */
function placeOf(picture, event) {
  const place = new DOMPoint(event.clientX, event.clientY).matrixTransform(picture.getScreenCTM().inverse());
  return [place.x, place.y];
}

const plotOf = (name) => document.querySelector(`figure[data-figure="${name}"]`);

/** A path through points `[x, y]` of a scale, without those below or above its picture. */
function pathOf(scale, points) {
  const inside = points.filter(([, y]) => y >= scale.y.low && y <= scale.y.high);
  return inside.map(([x, y], k) => `${k ? "L" : "M"}${scale.x(x).toFixed(1)} ${scale.y(y).toFixed(1)}`).join("");
}

