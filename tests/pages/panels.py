"""What a visitor does in every panel, and what must then be read there."""

from results import digits, grouped, percent, stop_of, use_colour, use_name


class Visit:
    """A page, its results, and what was found in it."""

    def __init__(self, page, results, findings):
        self.page, self.results, self.findings = page, results, findings

    def same(self, what, found, wanted):
        self.findings.compared += 1
        if found != wanted:
            self.findings.wrong.append(f"{what}: the page says {found!r}, the results {wanted!r}")
        self.findings.check()

    def readout(self, within):
        pairs = "list => Object.fromEntries([...list.children].map(d => [...d.children].map(e => e.textContent)))"
        return self.page.locator(f"{within} .readout").first.evaluate(pairs)

    def scale(self, figure):
        """Client positions of a plot's values, by the scale it states."""
        plot = self.page.locator(f"figure[data-figure={figure}] svg").first
        plot.scroll_into_view_if_needed()
        box = plot.bounding_box()
        view = [float(part) for part in plot.get_attribute("viewBox").split()]
        axis = lambda name: [float(part) for part in plot.get_attribute(name).split()]
        map_to = lambda value, low, high, start, end: start + (end - start) * (value - low) / (high - low)
        across, up = axis("data-x"), axis("data-y")
        wide, tall = box["width"] / view[2], box["height"] / view[3]
        return lambda x, y: (box["x"] + map_to(x, *across) * wide, box["y"] + map_to(y, *up) * tall)

    def set_range(self, selector, value):
        """Moves a slider as its user would: the browser snaps it and notifies the page."""
        move = "(slider, value) => { slider.value = value; slider.dispatchEvent(new Event('input', { bubbles: true })); }"
        self.page.locator(selector).evaluate(move, value)


def lonely(visit, case, pixels=3):
    """Points of a boundary that no other point lies near, so that pointing at them is unambiguous."""
    at = visit.scale("region")
    period_s = visit.results.run["operating_point"]["period_s"]
    places = [(at(p["accuracy"], p["throughput_bit"] / period_s / 1e6), p) for p in visit.results.run["region"]]
    far = lambda a, b: ((a[0] - b[0]) ** 2 + (a[1] - b[1]) ** 2) ** 0.5
    apart = lambda own, place: all(far(place, there) > pixels for there, p in places if p is not own)
    return [(place, p) for place, p in places if p["case"] == case and apart(p, place)]


def plan(visit, point):
    """The slot plan beside the region is that of this point."""
    page, figures, plan = visit.page, visit.results.figures, visit.results.plan(point)
    cell = lambda name: page.locator(f'#region .plan [data-value="{name}"]').text_content()
    visit.same("plan N_s", cell("slots"), str(point["sensing_slots"]))
    slot_bits = next(c for c in figures["cases"] if c["case"] == point["case"])["slot_bit"]
    for k, (slots, bit, wait) in enumerate(zip(point["communication_slots"], slot_bits, plan["longest_wait_slots"]), 1):
        visit.same(f"plan N_c,{k}", cell(f"slots {k}"), str(slots))
        visit.same(f"plan bits {k}", cell(f"bit a slot {k}"), grouped(int(bit + 0.5)))
        visit.same(f"plan wait {k}", cell(f"longest wait {k}"), str(wait))
    caption = page.locator("#region .plan caption").text_content()
    own = visit.results.run["operating_point"]
    wanted = f"N = {own['period_slots']} slots a period, N_m = {own['spacing_slots']} between two sensing slots"
    visit.same("plan N and N_m", caption, wanted)
    fills = page.locator("#region .plan svg rect").evaluate_all("all => all.map(r => r.getAttribute('fill'))")
    visit.same("plan first slots", fills[-len(plan["first"]):], [use_colour(code) for code in plan["first"]])


def region(visit):
    """Hover, press, drag, keys, weights, placements."""
    page, results = visit.page, visit.results
    point = results.run["operating_point"]
    own = next(p for p in results.boundary(point["case"]) if p["sensing_slots"] == point["sensing_slots"])
    visit.same("region at first", visit.readout("#region"), visit.results.say_region(own))
    plan(visit, own)
    for case in results.cases():
        for place, p in lonely(visit, case)[::7]:
            page.mouse.move(*place)
            visit.same(f"region hovered at N_s = {p['sensing_slots']}", visit.readout("#region"), visit.results.say_region(p))
    plan(visit, own)
    case = results.cases()[-1]
    steps = lonely(visit, case)
    page.mouse.move(*steps[0][0])
    page.mouse.down()
    for place, p in steps[1::5]:
        page.mouse.move(*place, steps=4)
        visit.same(f"region dragged to N_s = {p['sensing_slots']}", visit.readout("#region"), visit.results.say_region(p))
        plan(visit, p)
    page.mouse.up()
    boundary = results.boundary(case)
    handle = page.locator("#region .handle")
    handle.focus()
    for key, p in [("Home", boundary[0]), ("ArrowRight", boundary[1]), ("PageDown", boundary[0]), ("End", boundary[-1]),
                   ("ArrowLeft", boundary[-2]), ("PageUp", boundary[-1])]:
        page.keyboard.press(key)
        visit.same(f"region after {key}", visit.readout("#region"), visit.results.say_region(p))
        plan(visit, p)
    spoken = handle.get_attribute("aria-valuetext")
    visit.same("region spoken", f"N_s {boundary[-1]['sensing_slots']}," in spoken, True)
    page.keyboard.press("ArrowUp")
    visit.same("region after ArrowUp", visit.readout("#region")["case"], str(results.cases()[0]))
    for case in results.cases():
        page.locator(f"#region input[type=radio][value='{case}']").check()
        weighted = [w for w in results.figures["weighted"] if w["case"] == case]
        for k in [0, len(weighted) // 4, len(weighted) // 2, len(weighted) - 1]:
            visit.set_range("#weight", k)
            p = next(p for p in results.boundary(case) if p["sensing_slots"] == weighted[k]["sensing_slots"])
            visit.same(f"region at weight {weighted[k]['weight']}", visit.readout("#region"), visit.results.say_region(p))
            plan(visit, p)
    page.locator("#region button").click()
    visit.same("region back", visit.readout("#region"), visit.results.say_region(own))


def gallery(visit):
    """Where recordings stop, at the run's threshold and others; probabilities at every exit."""
    page, found = visit.page, visit.results.figures["early_exits"]
    classes = visit.results.figures["classes"]
    for k, recording in enumerate(found["recordings"]):
        figure = page.locator("#spectrograms figure").nth(k)
        stops = lambda: figure.locator("[data-value='stops after']").text_content()
        visit.same(f"{recording['truth']} stops", stops(), str(recording["stops_after"]))
        for n, exit in enumerate(recording["exits"]):
            figure.locator(".exits button").nth(n).click()
            for name, share in zip(classes, exit["probabilities"]):
                said = figure.locator(f".bars [data-value='{name}']").text_content()
                visit.same(f"{recording['truth']} after {exit['sensing_slots']}: {name}", said, percent(share))
        for threshold in [0.4, 0.6, 0.8, 0.95, 1.005]:
            visit.set_range("#threshold", threshold)
            exit = stop_of(recording, threshold, found["most_sensing_slots"])
            visit.same(f"{recording['truth']} stops at {threshold}", stops(), str(exit["sensing_slots"]))
        page.locator("#spectrograms .controls button").click()


def calibration(visit):
    """The KL curve by pointer and keys."""
    page, curve = visit.page, visit.results.figures["calibration"]["curve"]
    if not curve:
        return
    say = lambda p: {"rho": f"{p['rho']:g}", "KL": digits(p["kl"], 4), "KL without the floor": digits(p["kl_without_floor"], 4)}
    least = min(curve, key=lambda p: p["kl"])
    within = "figure[data-figure=kl-curve]"
    visit.same("KL at first", visit.readout(within), say(least))
    page.locator(f"{within} .handle").focus()
    for key, p in [("Home", curve[0]), ("ArrowRight", curve[1]), ("End", curve[-1])]:
        page.keyboard.press(key)
        visit.same(f"KL after {key}", visit.readout(within), say(p))
    box = page.locator(f"{within} svg").first.bounding_box()
    page.mouse.move(box["x"] + box["width"] / 2, box["y"] + box["height"] / 2)
    hovered = visit.readout(within)
    visit.same("KL hovered", hovered in [say(p) for p in curve] and hovered != say(curve[-1]), True)


def learning(visit):
    """Accuracies, band, another model's curve, losses, confusion."""
    page, run, figures = visit.page, visit.results.run, visit.results.figures
    within = "figure[data-figure=learning-curve]"
    say = lambda a: {"N_s": str(a["sensing_slots"]), "int8": digits(a["int8"], 4), "float": digits(a["float"], 4),
                     "recordings": str(a["tested"])}
    visit.same("accuracy at first", visit.readout(within), say(run["accuracy"][0]))
    page.locator(f"{within} .handle").focus()
    page.keyboard.press("End")
    visit.same("accuracy after End", visit.readout(within), say(run["accuracy"][-1]))
    page.keyboard.press("ArrowUp")
    page.keyboard.press("End")
    band, best = figures["prediction"]["band"]["points"][-1], figures["prediction"]["models"][0]
    wanted = {"N_s": digits(band["sensing_slots"], 0), best["name"]: digits(best["accuracy"][-1], 4),
              "95 % band": f"{digits(band['low'], 3)}–{digits(band['high'], 3)}"}
    visit.same("band at the end", visit.readout(within), wanted)
    for model in figures["prediction"]["models"]:
        page.locator(f"#models tr[data-model='{model['name']}'] button").click()
        drawn = page.locator(f"{within} .compared").get_attribute("d")
        low = float(page.locator(f"{within} svg").first.get_attribute("data-y").split()[0])
        visit.same(f"{model['name']} drawn", drawn.count("L"), sum(a >= low for a in model["accuracy"]) - 1)
    within = "figure[data-figure=training-loss]"
    page.locator(f"{within} .handle").focus()
    page.keyboard.press("End")
    first = figures["training"][0]
    visit.same("last loss", visit.readout(within)["loss"], digits(first["epochs"][-1]["loss"], 4))
    confusion(visit)


def confusion(visit):
    """Both matrices at every N_s, cell by cell, and a cell read by keys."""
    page, figures = visit.page, visit.results.figures
    for n in sorted({c["sensing_slots"] for c in figures["confusion"]}):
        page.locator("#confusion-slots").select_option(str(n))
        for c in (c for c in figures["confusion"] if c["sensing_slots"] == n):
            table = page.locator(f"#confusion table[data-arithmetic={c['arithmetic']}]")
            cells = table.evaluate("t => [...t.rows].slice(1).map(r => [...r.querySelectorAll('td')].map(c => Number(c.textContent)))")
            visit.same(f"confusion {c['arithmetic']} at {n}", cells, c["counts"])
    page.locator("#confusion table[data-arithmetic=float] td").first.focus()
    page.keyboard.press("ArrowDown")
    page.keyboard.press("ArrowRight")
    page.keyboard.press("ArrowRight")
    said = page.locator("#confusion + .readout").evaluate("e => [...e.querySelectorAll('dd')].map(d => d.textContent)")
    pair = {c["arithmetic"]: c["counts"][1] for c in figures["confusion"] if c["sensing_slots"] == n}
    wanted = [figures["classes"][1], figures["classes"][2]]
    wanted += [f"{pair[name][2]} of {sum(pair['float'])}" for name in ["float", "int8"]]
    visit.same("confusion by keys", said, wanted)


def timeline(visit):
    """A window of slots that walks along the period, by slider, by click, and slot by slot."""
    page, slots = visit.page, visit.results.slots()
    if len(slots) <= 80:
        return
    codes = sorted(set(slots))
    count = lambda own: {use_name(code): str(own.count(code)) for code in codes}
    within = "figure[data-figure=timeline]"
    for start in [0, 333, len(slots) - 80]:
        visit.set_range("#first-slot", start)
        own = slots[start:start + 80]
        visit.same(f"window at {start}", visit.readout(within), {"slots": f"{start}–{start + 79}", **count(own)})
        fills = page.locator("[data-strip=first] rect").evaluate_all("all => all.map(r => r.getAttribute('fill'))")
        visit.same(f"slots at {start}", fills, [use_colour(code) for code in own])
    page.locator("[data-strip=first] rect").nth(17).hover()
    slot = len(slots) - 80 + 17
    visit.same("one slot", visit.readout(within), {"slot": str(slot), "use": use_name(slots[slot])})
    page.locator("[data-strip=whole] rect").nth(0).click()
    page.mouse.move(5, 5)
    visit.same("window after a click at the period's begin", visit.readout(within)["slots"], "0–79")


def conformance(visit):
    """Targets and their stages, and the instruction table."""
    page, verify = visit.page, visit.results.run["verify"]
    for target in verify["targets"]:
        head = page.locator("#targets tr.head", has=page.get_by_role("button", name=target["name"], exact=True))
        cells = head.locator("td").all_text_contents()
        instructions = grouped(target["instructions"]) if target["instructions"] else "–"
        wanted = [grouped(target["compared"]), str(target["mismatches"]), instructions]
        visit.same(f"{target['name']}", cells[:3], wanted)
        visible = lambda: page.locator("#targets tr:not(.head):visible").count() - 1
        visit.same(f"{target['name']} closed", visible(), 0)
        head.get_by_role("button").click()
        visit.same(f"{target['name']} open", visible(), len(target["stages"]))
        head.get_by_role("button").press("Enter")
    counted = [t for t in verify["targets"] if t.get("recognitions")]
    table = "t => [...t.rows].slice(1).map(r => [...r.cells].map(c => c.textContent))"
    rows = page.locator("#instructions").evaluate(table) if counted else []
    for row in rows:
        own = [next((c for c in t["recognitions"] if str(c["sensing_slots"]) == row[0]), None) for t in counted]
        visit.same(f"instructions at N_s = {row[0]}", row[1:], [grouped(c["instructions"]) if c else "–" for c in own])
    visit.same("rows of instructions", len(rows), len({c["sensing_slots"] for t in counted for c in t["recognitions"]}))


PANELS = [region, gallery, calibration, learning, timeline, conformance]
