"""How the page looks: nothing clipped, overlapping, pale, or out of reach."""

SECTIONS = ["region", "spectrograms", "calibration", "learning", "schedule", "conformance", "configuration"]

CLIPPED = """() => [...document.querySelectorAll('figure svg')].flatMap(svg => {
  const room = svg.getBoundingClientRect();
  return [...svg.querySelectorAll('text')].filter(text => {
    const box = text.getBoundingClientRect();
    return box.width && (box.left < room.left - 1 || box.right > room.right + 1 || box.top < room.top - 1 || box.bottom > room.bottom + 1);
  }).map(text => `${svg.closest('figure').dataset.figure ?? 'picture'}: ${text.textContent}`);
})"""

OVERLAPPING = """() => [...document.querySelectorAll('figure svg')].flatMap(svg => {
  const all = [...svg.querySelectorAll('text')].map(text => [text, text.getBoundingClientRect()]).filter(([, box]) => box.width);
  const clash = (a, b) => Math.min(a.right, b.right) - Math.max(a.left, b.left) > 2 && Math.min(a.bottom, b.bottom) - Math.max(a.top, b.top) > 3;
  return all.flatMap(([a, one], k) => all.slice(k + 1).filter(([, two]) => clash(one, two)).map(([b]) =>
    `${svg.closest('figure').dataset.figure ?? 'picture'}: "${a.textContent}" and "${b.textContent}"`));
})"""

# WCAG 2.1, 1.4.3: text of at least 4.5 to 1 against what is behind it
PALE = """() => {
  const parse = text => (text.match(/[\\d.]+/g) ?? []).map(Number);
  const light = ([r, g, b]) => [r, g, b].map(c => c / 255).map(c => c <= 0.03928 ? c / 12.92 : ((c + 0.055) / 1.055) ** 2.4)
    .reduce((sum, c, k) => sum + c * [0.2126, 0.7152, 0.0722][k], 0);
  const behind = element => {
    const layers = [];
    for (let e = element; e; e = e.parentElement) {
      const [r, g, b, a = 1] = parse(getComputedStyle(e).backgroundColor);
      layers.push([r, g, b, a]);
      if (a === 1) break;
    }
    return layers.reverse().reduce((under, [r, g, b, a]) => [r, g, b].map((c, k) => c * a + (under[k] ?? 255) * (1 - a)), []);
  };
  const texts = [...document.querySelectorAll('body *')].filter(e => !e.closest('script,style,title') && e.checkVisibility()
    && [...e.childNodes].some(n => n.nodeType === 3 && n.textContent.trim()));
  return texts.map(e => {
    const style = getComputedStyle(e);
    const ink = light(parse(e instanceof SVGElement ? style.fill : style.color));
    const paper = light(behind(e));
    return [(Math.max(ink, paper) + 0.05) / (Math.min(ink, paper) + 0.05), e];
  }).filter(([ratio]) => ratio < 4.5).map(([ratio, e]) => `${ratio.toFixed(2)} ${e.tagName} ${e.textContent.slice(0, 40)}`);
}"""

UNNAMED = """() => [...document.querySelectorAll('button,input,select,[role=slider],svg[role]')].filter(e =>
  !(e.textContent.trim() || e.labels?.length || e.ariaLabel || e.querySelector?.('title'))).map(e => e.outerHTML.slice(0, 80))"""


def check(visit, width, what):
    """Fits the width, nothing clipped or on top of another, enough contrast, everything has a name."""
    visit.page.set_viewport_size({"width": width, "height": 900})
    for name, script in [("clipped text", CLIPPED), ("text over text", OVERLAPPING), ("pale text", PALE), ("without a name", UNNAMED)]:
        visit.same(f"{what}, {width} px: {name}", visit.page.evaluate(script), [])
    room = visit.page.evaluate("document.scrollingElement.scrollWidth")
    visit.same(f"{what}, {width} px: the page scrolls sideways", room > width, False)


def keyboard(visit):
    """Tab reaches every control, in the order of the page, and what has the focus shows it."""
    page = visit.page
    page.mouse.click(2, 2)
    page.evaluate("document.activeElement?.blur(); getSelection().removeAllRanges()")
    wanted = page.locator("a[href]:visible,button:visible,input:visible,select:visible,summary:visible,[tabindex='0']:visible").count()
    # of a group of radio buttons one is reached
    wanted -= page.locator("input[type=radio]:visible").count() - 1
    seen = set()
    for _ in range(wanted + 20):
        page.keyboard.press("Tab")
        shown = page.evaluate("""() => {
          const e = document.activeElement;
          if (!e || e === document.body) return null;
          const [style, ring] = [getComputedStyle(e), e.querySelector?.('.ring')];
          const focused = ring ? getComputedStyle(ring).strokeWidth === '5px' : parseFloat(style.outlineWidth) >= 2 && style.outlineStyle !== 'none';
          e.dataset.reached = (window.reached = (window.reached ?? 0) + (e.dataset.reached ? 0 : 1));
          return [e.outerHTML.slice(0, 80), focused];
        }""")
        if shown is None:
            break
        seen.add(shown[0])
        visit.same(f"focus shows on {shown[0]}", shown[1], True)
    reached = page.evaluate("document.querySelectorAll('[data-reached]').length")
    visit.same("controls that Tab reaches", reached, wanted)


def shots(page, folder, name):
    """A picture of every section."""
    folder.mkdir(parents=True, exist_ok=True)
    page.evaluate("document.activeElement?.blur()")
    for section in SECTIONS:
        page.locator(f"#{section}").screenshot(path=folder / f"{section}-{name}.png")
