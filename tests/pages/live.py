"""Uses the program in a run's page: live.py SDP3 OUT RECORDING... [--shots FOLDER] [--first].

RECORDING are the files of one recording of raw slots. The page's JSON must be the command's, byte for byte; a console error or a
request fails the check, and so does a page of more than 2 MiB. With --first it ends at the first thing that is wrong.
"""

import argparse
import contextlib
import json
import pathlib
import re
import shlex
import shutil
import subprocess
import sys
import tempfile
import time

from playwright.sync_api import sync_playwright

import panels
from findings import Findings

LARGEST = 2 << 20


class Visit(panels.Visit):
    """A page, and what the commands say of the same files."""

    def __init__(self, page, given, findings):
        super().__init__(page, None, findings)
        self.given = given

    def command(self, *arguments):
        """What the command prints, or what it says and exit code 2."""
        done = subprocess.run([self.given.sdp3, "-q", *map(str, arguments)], capture_output=True, text=True)
        return done.stdout if done.returncode == 0 else done.stderr.strip().removeprefix("sdp3: ")

    def answer(self, selector):
        self.page.wait_for_selector(f"{selector}[data-json]")
        return self.page.locator(selector).get_attribute("data-json")

    def status(self, section):
        return self.until(section, lambda text: text and not text.endswith("computing"))

    def until(self, section, holds):
        """The status line once it holds. The page's policy allows no test that is made of text within the page."""
        line = self.page.locator(f"{section} .status")
        for _ in range(2400):
            text = line.text_content()
            if holds(text):
                return text
            self.page.wait_for_timeout(50)
        raise TimeoutError(f"{section}: the status stays {text!r}")


def recording(visit, models):
    """A recording that is chosen, by some of the models: as `sdp3 classify` has it."""
    page, files = visit.page, visit.given.recording
    described = next((file for file in files if file.suffix == ".sigmf-meta"), files[0])
    with tempfile.TemporaryDirectory() as folder:
        rate_hz = json.loads(visit.command("inspect", described, "--json", "--out", folder))["rate_hz"]
    page.locator("#recording input[type=file]").set_input_files(files)
    visit.answer("#found")
    for model in models:
        slots = model.stem.removeprefix("dsn-")
        page.locator("#recording select").select_option(slots)
        for step, least in [("", "0"), ("100", "0.9")]:
            page.locator("input[name=step]").fill(step)
            page.locator("input[name=least-confidence]").fill(least)
            page.locator("input[name=least-confidence]").press("Enter")
            page.locator("input[name=least-confidence]").blur()
            visit.status("#recording")
            options = (["--step", step] if step else []) + ["--least-confidence", least]
            printed = visit.command("classify", model, described, *options, "--json")
            expected = json.loads(printed)
            # the command has the paths of this machine, the page has names
            expected["model"], expected["recordings"][0]["file"] = model.name, described.name
            found = json.loads(visit.answer("#found"))
            visit.same(f"classes by {model.name}, step {step or 'N_s'}, least confidence {least}", found, expected)
            windows = expected["recordings"][0]["windows"]
            shown = page.locator("#found td").all_text_contents()
            rows = [[f"{w['start_s']:.3f}", w["class"].replace("-", " "), f"{w['confidence']:.4f}"] for w in windows]
            visit.same(f"table of {model.name}", shown, sum(rows, []))
            end = windows[-1]["start_s"] + expected["sensing_slots"] / rate_hz
            ticks = [float(text) for text in page.locator("#found svg text").all_text_contents() if text[0].isdigit()]
            visit.same(f"end of the time axis of {model.name}", f"{max(ticks):.2f}", f"{end:.2f}")
            visit.same(f"marks of {model.name}", page.locator("#found rect.window").count(), len(windows))


def spectrogram(visit):
    """The picture of the recording has the pixels of the one that `sdp3 inspect` embeds in its SVG."""
    described = next((file for file in visit.given.recording if file.suffix == ".sigmf-meta"), visit.given.recording[0])
    with tempfile.TemporaryDirectory() as folder:
        visit.command("inspect", described, "--scenario", visit.given.out / "scenario.toml", "--out", folder)
        svg = (pathlib.Path(folder) / "doppler-time.svg").read_text()
    address = max(re.findall(r'"(data:image/png;base64,[^"]+)"', svg), key=len)
    script = """async (address) => {
        const image = new Image();
        image.src = address;
        await image.decode();
        const pixels = (width, height, paint) => {
            const context = Object.assign(document.createElement("canvas"), { width, height }).getContext("2d");
            paint(context);
            return context.getImageData(0, 0, width, height).data;
        };
        const own = document.querySelector("#doppler canvas");
        const found = own.getContext("2d").getImageData(0, 0, own.width, own.height).data;
        const other = pixels(image.width, image.height, (context) => context.drawImage(image, 0, 0));
        const differs = found.length === other.length ? found.filter((byte, k) => byte !== other[k]).length : -1;
        return [own.width, own.height, image.width, image.height, differs, new Set(found).size > 20];
    }"""
    width, height, *size, differs, drawn = visit.page.evaluate(script, address)
    visit.same("size of the spectrogram", [width, height], size)
    visit.same("pixels of the spectrogram that differ", differs, 0)
    visit.same("a spectrogram with something in it", drawn, True)


def dropped(visit):
    """Files that are dropped give what files that are chosen give; a file that is no recording gives the command's own words."""
    page = visit.page
    before = visit.answer("#found")
    page.evaluate("document.getElementById('found').removeAttribute('data-json')")
    with tempfile.TemporaryDirectory() as folder:
        for file in visit.given.recording:
            shutil.copy(file, folder)
        drop(page, sorted(pathlib.Path(folder).iterdir()))
        visit.same("dropped", visit.answer("#found"), before)
        broken = pathlib.Path(folder) / "broken.wav"
        broken.write_bytes(b"RIFF\x10\x00\x00\x00WAVEfmt ")
        model = f"dsn-{page.locator('#recording select').input_value()}.sdp3"
        drop(page, [broken])
        visit.until("#recording", lambda text: "broken.wav" in text)
        said = visit.command("classify", visit.given.out / "models" / model, broken).replace(f"{folder}/", "")
        visit.same("a broken file", visit.status("#recording"), said)
        visit.same("a broken file leaves nothing", page.locator("#found *").count(), 0)


def drop(page, files):
    contents = [{"name": file.name, "bytes": list(file.read_bytes())} for file in files]
    script = """(files) => {
        const moved = new DataTransfer();
        for (const file of files) moved.items.add(new File([new Uint8Array(file.bytes)], file.name));
        document.querySelector("#recording .drop").dispatchEvent(new DragEvent("drop", { dataTransfer: moved, bubbles: true, cancelable: true }));
    }"""
    page.evaluate(script, contents)


def links(visit):
    """Each control is moved by keys: the region is the one of the command that the page names."""
    page = visit.page
    with tempfile.TemporaryDirectory() as folder:
        out = pathlib.Path(folder) / "out"
        shutil.copytree(visit.given.out, out)
        moves = [("power", "ArrowLeft", 7), ("noise", "ArrowRight", 3), ("users", "ArrowLeft", 1), ("rho", "ArrowLeft", 2), ("rho", "End", 1)]
        for name, key, times in moves:
            slider = page.locator(f"#links input[name={name}]")
            page.evaluate("document.querySelectorAll('#region .readout').forEach((e) => e.removeAttribute('data-json'))")
            slider.focus()
            begun = time.monotonic()
            for _ in range(times):
                page.keyboard.press(key)
            if name == "rho":
                visit.until("#region", lambda text: "test recordings simulated" in text)
            visit.until("#region", lambda text: text.startswith("computed"))
            print(f"{name}: {time.monotonic() - begun:.1f} s")
            page.wait_for_selector("#region .readout[data-json]")
            command = shlex.split(page.locator("#region .command").text_content())
            field = "channel.rho=" if name == "rho" else "communication."
            visit.same(f"the command names {name}", any(part.startswith(field) for part in command), True)
            printed = visit.command(*command[1:], "--out", out, "--json")
            visit.same(f"region after {name}", page.locator("#region .readout[data-json]").get_attribute("data-json"), printed)
            computed = json.loads(page.locator("#region .readout[data-json]").get_attribute("data-json"))
            shown = page.locator("#region .readout[data-json] dd[data-value=N_s]").text_content()
            visit.same(f"N_s after {name}", shown, str(computed["operating_point"]["sensing_slots"]))
            retested = computed.get("retested", {"accuracy": []})
            for one in retested["accuracy"]:
                cell = page.locator(f"#region .retested [data-value='accuracy {one['sensing_slots']}']")
                visit.same(f"accuracy of N_s = {one['sensing_slots']} after {name}", cell.text_content(), f"{one['int8']:.4f}")
            if name == "rho":
                said = f"at rho = {retested['rho']:g}: no new training"
                visit.same(f"the status says rho: {said}", said in visit.status("#region"), True)
            visit.same(f"boundaries after {name}", page.locator("#region .drawn path.compared").count(), len(computed["cases"]))


def look(browser, given, findings):
    """The page in two widths, used in every way."""
    address = (given.out / "report.html").resolve().as_uri()
    models = sorted((given.out / "models").glob("*.sdp3"))
    for name, width, used in [("wide", 1280, models), ("narrow", 390, models[-1:])]:
        context = browser.new_context(viewport={"width": width, "height": 900}, has_touch=width < 600, offline=True)
        page = context.new_page()
        page.set_default_timeout(30_000)
        findings.listen(page, address, ("data:", "blob:"))
        visit = Visit(page, given, findings)
        recording(visit, used)
        spectrogram(visit)
        links(visit)
        visit.same("wider than the window", page.evaluate("document.documentElement.scrollWidth <= innerWidth"), True)
        if given.shots:
            for section in ["recording", "region"]:
                page.locator(f"#{section}").screenshot(path=given.shots / f"live-{section}-{name}.png")
        dropped(visit)


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("sdp3", type=pathlib.Path)
    parser.add_argument("out", type=pathlib.Path)
    parser.add_argument("recording", type=pathlib.Path, nargs="+")
    parser.add_argument("--shots", type=pathlib.Path)
    parser.add_argument("--first", action="store_true")
    given = parser.parse_args()
    findings = Findings(given.first)
    size = (given.out / "report.html").stat().st_size
    print(f"{size} bytes")
    if size > LARGEST:
        findings.wrong.append(f"the page has {size} bytes, more than {LARGEST}")
    with sync_playwright() as playwright, contextlib.suppress(Findings.Stop):
        browser = playwright.chromium.launch(executable_path=shutil.which("chromium"))
        look(browser, given, findings)
        browser.close()
    sys.exit(findings.report())


main()
