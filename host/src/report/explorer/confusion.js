// Confusion matrices, float beside int8, for any N_s; every cell says its counts.

function matrix(own, other, read) {
  const cells = own.counts.map((row, truth) => {
    const total = row.reduce((sum, n) => sum + n, 0);
    return row.map((n, answer) => {
      const differs = n !== other?.counts[truth][answer];
      const cell = html("td", { class: `${truth === answer ? "right" : "wrong"}${differs ? " differs" : ""}`, tabindex: -1 }, String(n));
      cell.style.setProperty("--share", total ? n / total : 0);
      const report = () => read({ truth, answer, total });
      cell.addEventListener("pointerenter", report);
      cell.addEventListener("focus", report);
      cell.addEventListener("keydown", (event) => {
        const [down, right] = { ArrowUp: [-1, 0], ArrowDown: [1, 0], ArrowLeft: [0, -1], ArrowRight: [0, 1] }[event.key] ?? [0, 0];
        const next = cells[truth + down]?.[answer + right];
        if (!next || next === cell) return;
        [cell.tabIndex, next.tabIndex] = [-1, 0];
        next.focus();
        event.preventDefault();
      });
      return cell;
    });
  });
  cells[0][0].tabIndex = 0;
  const names = figures.classes.map((name) => html("th", { scope: "col" }, name));
  const head = html("tr", {}, html("th", { scope: "col" }, "truth \\ answer"), ...names);
  const rows = cells.map((row, truth) => html("tr", {}, html("th", { scope: "row" }, figures.classes[truth]), ...row));
  const caption = html("caption", {}, `${own.arithmetic}, N_s = ${own.sensing_slots}: truth down, answer across`);
  return html("figure", {}, html("table", { class: "confusion", "data-arithmetic": own.arithmetic }, caption, head, ...rows));
}

function confusionPanel() {
  const place = document.getElementById("confusion");
  const slots = [...new Set(figures.confusion.map((one) => one.sensing_slots))].sort((a, b) => a - b);
  const options = slots.map((n) => html("option", { value: n }, String(n)));
  const select = html("select", { id: "confusion-slots" }, ...options);
  const readout = readoutOf();
  const draw = () => {
    const own = figures.confusion.filter((one) => one.sensing_slots === Number(select.value));
    const pair = ["float", "int8"].map((name) => own.find((one) => one.arithmetic === name)).filter(known);
    const read = ({ truth, answer, total }) =>
      fillReadout(readout, [
        ["truth", figures.classes[truth]],
        ["answer", figures.classes[answer]],
        ...pair.map((one) => [one.arithmetic, `${one.counts[truth][answer]} of ${total}`]),
      ]);
    place.replaceChildren(...pair.map((one, k) => matrix(one, pair[1 - k], read)));
    read({ truth: 0, answer: 0, total: pair[0].counts[0].reduce((sum, n) => sum + n, 0) });
  };
  select.value = slots[slots.length - 1];
  select.addEventListener("change", draw);
  const label = html("label", { class: "control", for: "confusion-slots" }, "confusion at N_s =", select);
  place.before(html("div", { class: "controls" }, label));
  place.after(readout);
  draw();
}

if (figures.confusion.length) confusionPanel();

