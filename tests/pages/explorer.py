"""Opens a run's page in headless Chromium and uses it: explorer.py OUT [--shots FOLDER] [--first].

Everything read in the page is compared with run.json and figures.json of OUT. A console error or a request fails the check. With --first
it ends at the first thing that is wrong.
"""

import argparse
import contextlib
import pathlib
import shutil
import sys

from playwright.sync_api import sync_playwright

import layout
from findings import Findings
from panels import PANELS, Visit, lonely
from results import Results


def opened(browser, address, findings, **how):
    """The page in a context of its own."""
    page = browser.new_context(**how).new_page()
    page.set_default_timeout(10_000)
    findings.listen(page, address)
    return page


def touch(visit):
    """A finger drags the operating point."""
    case = visit.results.run["operating_point"]["case"]
    point = visit.results.run["operating_point"]
    start = visit.scale("region")(point["accuracy"], point["throughput_bit"] / 1e6)
    end, wanted = lonely(visit, case, 1)[0]  # a finger has fractions of a pixel, a mouse has none
    client = visit.page.context.new_cdp_session(visit.page)
    send = lambda kind, points: client.send("Input.dispatchTouchEvent", {"type": kind, "touchPoints": points})
    finger = lambda share: [{"x": a + (b - a) * share, "y": c + (d - c) * share} for (a, c), (b, d) in [(start, end)]]
    send("touchStart", finger(0))
    for step in range(1, 11):
        send("touchMove", finger(step / 10))
    send("touchEnd", [])
    visit.same("region dragged by a finger", visit.readout("#region"), visit.results.say_region(wanted))


def without_script(browser, address, visit):
    """The figures and tables are there without the script."""
    page = browser.new_context(java_script_enabled=False).new_page()
    page.goto(address)
    shown = [f"figure[data-figure={name}] svg" for name in ["region", "learning-curve", "training-loss", "intensities", "timeline"]]
    for selector in shown + ["#spectrograms svg image", "#targets tr.head", "#confusion td", "#models td"]:
        visit.same(f"without script: {selector}", page.locator(selector).first.is_visible(), True)
    visit.same("without script: controls", page.locator("main button, main input").count(), 0)


def look(browser, results, address, shots, findings):
    """Every panel, without the script, and in other sizes and colours."""
    size = {"width": 1280, "height": 900}
    visit = Visit(opened(browser, address, findings, viewport=size, reduced_motion="reduce"), results, findings)
    for panel in PANELS:
        panel(visit)
    moving = visit.page.locator(".bars i").first.evaluate("e => getComputedStyle(e).transitionDuration")
    visit.same("reduced motion", moving, "0s")
    without_script(browser, address, visit)
    for name, width, scheme in [("light", 1280, "light"), ("dark", 1280, "dark"), ("narrow", 390, "light"), ("narrow-dark", 360, "dark")]:
        size = {"width": width, "height": 900}
        page = opened(browser, address, findings, viewport=size, color_scheme=scheme, has_touch=width < 600)
        visit = Visit(page, results, findings)
        layout.check(visit, width, name)
        if shots and name != "narrow-dark":
            layout.shots(page, shots, name)
        touch(visit) if width < 600 else layout.keyboard(visit)


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("out", type=pathlib.Path)
    parser.add_argument("--shots", type=pathlib.Path)
    parser.add_argument("--first", action="store_true")
    given = parser.parse_args()
    findings = Findings(given.first)
    with sync_playwright() as playwright, contextlib.suppress(Findings.Stop):
        browser = playwright.chromium.launch(executable_path=shutil.which("chromium"))
        look(browser, Results(given.out), (given.out / "report.html").resolve().as_uri(), given.shots, findings)
        browser.close()
    sys.exit(findings.report())


main()
