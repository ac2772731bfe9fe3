// Conformance: the stages of a target are shown when asked for.

function targetsPanel() {
  const table = document.getElementById("targets");
  for (const head of table.querySelectorAll("tr.head")) {
    const stages = [];
    for (let row = head.nextElementSibling; row && !row.classList.contains("head"); row = row.nextElementSibling) stages.push(row);
    const name = head.querySelector("th");
    const button = html("button", { type: "button", "aria-expanded": false }, name.textContent);
    const show = (shown) => {
      button.setAttribute("aria-expanded", shown);
      stages.forEach((row) => (row.hidden = !shown));
    };
    button.addEventListener("click", () => show(button.getAttribute("aria-expanded") !== "true"));
    name.replaceChildren(button);
    show(false);
  }
}

targetsPanel();
