"""The page in a browser: headless Chromium, as in Debian's packages chromium and chromium-driver.

They run where ROUGHCONTACT_BROWSER=1 asks for them, and then there must be one.
"""

from __future__ import annotations

import csv
import os
import shutil
import threading
from importlib import resources
from pathlib import Path

import numpy as np
import pytest
import roughcontact as rc
from selenium import webdriver
from selenium.common.exceptions import NoSuchElementException, StaleElementReferenceException
from selenium.webdriver.chrome.service import Service
from selenium.webdriver.common.action_chains import ActionChains
from selenium.webdriver.common.by import By
from selenium.webdriver.common.keys import Keys
from selenium.webdriver.support.ui import Select, WebDriverWait

from roughcontact_app import AppServer, Session
from roughcontact_app.command import _shown

if os.environ.get("ROUGHCONTACT_BROWSER") != "1":
    pytest.skip("set ROUGHCONTACT_BROWSER=1, and install chromium and chromium-driver", allow_module_level=True)
CHROMIUM, DRIVER = (shutil.which(name) for name in ("chromium", "chromedriver"))

# What is looked at may be drawn anew meanwhile.
BUSY = [NoSuchElementException, StaleElementReferenceException]
# Seconds; the machine may be busy.
PATIENCE = 180
# A map whose file states everything, in a minute of nothing: 48 x 40 cells.
SIZE = (48e-6, 40e-6)
# What a drop of a file on the page is, to the page.
DROP = """
const [text, name, place] = arguments;
const transfer = new DataTransfer();
transfer.items.add(new File([text], name));
for (const kind of ["dragenter", "dragover", "drop"]) {
  const event = new DragEvent(kind, { dataTransfer: transfer, bubbles: true, cancelable: true });
  document.getElementById(place).dispatchEvent(event);
}
"""
# Whether the page is not scrolled for a fifth of a second.
STANDS = "const [done] = arguments, y = scrollY; setTimeout(() => done(y === scrollY), 200)"


@pytest.fixture(scope="module")
def server():
    session = Session(slots=1)
    with AppServer(session) as started:
        thread = threading.Thread(target=started.serve_forever, daemon=True)
        thread.start()
        yield started
        started.shutdown()
    session.close()


class Page:
    """What a user sees and does."""

    def __init__(self, driver, address, downloads):
        self.driver, self.address, self.downloads = driver, address, downloads

    def open(self, address=None):
        self.driver.get("about:blank")
        self.driver.get(address or self.address)
        self.until(lambda: self.driver.find_elements(By.CSS_SELECTOR, "body[data-ready]"))
        return self

    def until(self, condition):
        return WebDriverWait(self.driver, PATIENCE, poll_frequency=0.1, ignored_exceptions=BUSY).until(
            lambda _: condition()
        )

    def open_example(self):
        """Open the page by a link to the built-in example: nothing is solved before Solve is pressed."""
        return self.open(f"{self.address}#surface=example")

    def reveal(self, element):
        """Open the group of a part of the form."""
        self.driver.execute_script("arguments[0].closest('.group')?.setAttribute('open', '')", element)
        return element

    def find(self, name):
        return self.reveal(self.driver.find_element(By.ID, name))

    def click(self, element):
        # Solve stands before what is at the bottom of the form, or of a small screen.
        self.driver.execute_script("arguments[0].scrollIntoView({ block: 'center' })", element)
        element.click()

    def tick(self, name):
        self.click(self.reveal(self.driver.find_element(By.NAME, name)))

    def is_answered(self):
        return self.driver.find_elements(By.CSS_SELECTOR, "#answer:not([hidden]) .tile")

    def text(self, name):
        return self.find(name).text

    def set(self, name, text):
        element = self.reveal(self.driver.find_element(By.NAME, name))
        if element.tag_name == "select":
            Select(element).select_by_value(text)
        else:
            element.clear()
            element.send_keys(text)

    def value(self, quantity):
        cell = self.driver.find_element(By.CSS_SELECTOR, f"[data-quantity='{quantity}']")
        return float(cell.get_attribute("data-value"))

    def download(self, name):
        link = self.until(lambda: self.driver.find_elements(By.CSS_SELECTOR, f"a[download='{name}']"))
        self.click(link[0])
        return self.until(lambda: next(iter(self.downloads.glob(name)), None))

    def setting(self, name):
        return self.driver.find_element(By.NAME, name).get_attribute("value")

    def has_run_in_address(self):
        return "run=" in self.driver.current_url

    def drop(self, text, name, place="settings"):
        self.driver.execute_script(DROP, text, name, place)

    def until_planned(self):
        self.until(lambda: "for the solve" in self.text("plan"))

    def emulate(self, width, height, scheme="light"):
        size = {"width": width, "height": height, "deviceScaleFactor": 1, "mobile": width < 500}
        self.driver.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", size)
        emulation = {"features": [{"name": "prefers-color-scheme", "value": scheme}]}
        self.driver.execute_cdp_cmd("Emulation.setEmulatedMedia", emulation)

    def bottom(self, name):
        return self.driver.execute_script(f"return document.getElementById('{name}').getBoundingClientRect().bottom")

    def is_wider_than_the_screen(self):
        return self.driver.execute_script("return document.documentElement.scrollWidth > innerWidth")

    def errors(self):
        return [line for line in self.driver.get_log("browser") if " 422 " not in line["message"]]


@pytest.fixture
def page(server, tmp_path):
    options = webdriver.ChromeOptions()
    options.binary_location = CHROMIUM
    downloads = tmp_path / "downloads"
    downloads.mkdir()
    flags = "headless=new no-sandbox disable-gpu disable-quic no-first-run disable-background-networking"
    for flag in (*flags.split(), "disable-component-update", "disable-sync", "window-size=1280,900"):
        options.add_argument(f"--{flag}")
    options.add_argument(f"--user-data-dir={tmp_path / 'profile'}")
    options.add_experimental_option("prefs", {"download.default_directory": str(downloads)})
    options.set_capability("goog:loggingPrefs", {"browser": "ALL"})
    driver = webdriver.Chrome(options=options, service=Service(DRIVER))
    try:
        driver.set_script_timeout(PATIENCE)
        shown = Page(driver, server.address, downloads)
        yield shown
        # Nor has anything broken the policy of the page.
        assert shown.errors() == []
    finally:
        driver.quit()


@pytest.fixture(scope="module")
def surface():
    rough = rc.SelfAffineSurface(hurst=0.8, rms_height=0.1e-6, shortest=8e-6, longest=24e-6, seed=5)
    return rc.HeightMap(rough.heights(rc.Grid((48, 40), SIZE)), size=SIZE)


def write_table(surface):
    return "\n".join(",".join(f"{value:.6f}" for value in row) for row in 1e6 * surface.values)


def test_it_opens_with_an_answer_of_a_known_contact(page):
    page.emulate(1280, 900)
    page.open()
    page.until(page.is_answered)
    hertz = rc.reference.hertz_sphere(5.0, 5e-3, 210e9 / (2 * (1 - 0.3**2)))
    assert page.value("contact area") == pytest.approx(hertz.area, rel=1e-4)
    assert page.value("maximum pressure") == pytest.approx(hertz.p_max, rel=1e-4)
    assert page.value("approach") == pytest.approx(hertz.approach, rel=2e-4)
    assert page.text("verdict").startswith("✓ Certified")
    assert page.text("numbers").count("Hertz") == 3
    assert not page.find("warnings").is_displayed()
    # All of it is on one screen, and the focus is where it was.
    page.until(lambda: page.find("picture").is_displayed() and page.find("picture").size["height"] > 200)
    page.until(lambda: not page.find("progress").is_displayed())
    for name in ("settings", "numbers", "picture", "downloads"):
        assert page.bottom(name) < 900, name
    stops = []
    while not stops or stops[-1] != "solve":
        ActionChains(page.driver).send_keys(Keys.TAB).perform()
        stops.append(page.driver.switch_to.active_element.get_attribute("id"))
        assert len(stops) <= 8, stops
    # Whoever comes again finds the same run.
    before = page.text("run-subject")
    page.open()
    page.until(page.is_answered)
    assert page.text("run-subject") == before
    page.set("loads", "6")
    page.find("solve").click()
    page.until(lambda: page.text("headline") == "At 6 N:")
    # Off the closed form nothing is said of it.
    page.set("boundary", "periodic")
    page.until_planned()
    page.find("solve").click()
    page.until(lambda: "periodic" in page.text("run-subject") and page.is_answered())
    assert "Hertz" not in page.text("numbers") + page.text("verdict")


def test_two_maps_are_chosen_at_once(page, surface, tmp_path):
    paths = [tmp_path / name for name in ("first.npz", "second.npz", "third.npz")]
    for path in paths:
        np.savez(path, heights=surface.values, size=SIZE)
    page.open_example().find("file-input").send_keys("\n".join(map(str, paths)))
    page.until(lambda: "first.npz, 48 x 40 points" in page.text("file-shown"))
    page.until(lambda: "second.npz, 48 x 40 points" in page.text("counterbody_file-shown"))
    assert page.text("note") == "There are two bodies: of these 3 files the first two are read."
    page.until_planned()
    assert (page.text("s-surface"), page.text("s-counterbody")) == ("map first.npz", "map second.npz")
    assert (page.setting("surface"), page.setting("counterbody_surface")) == ("file", "file")
    page.until(lambda: page.find("counterbody-picture").is_displayed())


def test_a_picture_is_fetched_when_its_tab_is_opened(page):
    page.open_example()
    for name, text in {"surface": "wavy", "cells": "48", "side": "50", "loads": "20"}.items():
        page.set(name, text)
    page.until_planned()
    page.find("solve").click()
    fetched = "return performance.getEntriesByType('resource').map(({ name }) => name.split('/').pop())"
    page.until(lambda: page.driver.find_elements(By.ID, "tab-patches"))
    looks = {"gap": "field", "patch-sizes": "bars", "profile": "line"}
    for panel, look in looks.items():
        assert page.find(f"tab-{panel}").find_element(By.TAG_NAME, "svg").get_attribute("data-look") == look
    page.until(lambda: "pressure.png" in page.driver.execute_script(fetched))
    assert "gap.png" not in page.driver.execute_script(fetched)
    image = page.find("picture").find_element(By.TAG_NAME, "img")
    page.find("tab-gap").click()
    page.until(lambda: "gap.png" in page.driver.execute_script(fetched))
    page.until(lambda: int(image.get_attribute("naturalWidth")) > 100 and image.is_displayed())
    assert "gap of this contact" in image.get_attribute("alt")
    # One that does not come is missed in words, and the next one is shown again.
    page.driver.execute_cdp_cmd("Network.enable", {})
    page.driver.execute_cdp_cmd("Network.setBlockedURLs", {"urls": ["*/patches.png"]})
    page.find("tab-patches").click()
    page.until(lambda: "This picture could not be drawn." in page.text("picture"))
    page.find("tab-gap").click()
    page.until(lambda: image.is_displayed() and "could not be drawn" not in page.text("picture"))
    # What the test has blocked is logged.
    page.driver.get_log("browser")


def test_a_curve_is_read_by_keys_and_pointer(page):
    page.open_example()
    for name, text in {"surface": "wavy", "cells": "48", "side": "50", "loads": "40 10 20"}.items():
        page.set(name, text)
    page.until_planned()
    page.find("solve").click()
    page.until(lambda: page.text("headline") == "3 loads solved; at 20 MPa:")
    curve = page.find("curve")
    page.until(lambda: curve.size["height"] > 200)
    curve.send_keys(Keys.END)
    rows = page.driver.find_elements(By.CSS_SELECTOR, "#answer-table tbody tr")
    # In the order of the loads, whatever that of the form.
    for key, row in ((Keys.HOME, rows[1]), (Keys.ARROW_RIGHT, rows[2]), (Keys.END, rows[0])):
        curve.send_keys(key)
        load, area = (
            row.find_element(By.CSS_SELECTOR, f"[data-quantity='{name}']").text
            for name in ("mean pressure", "contact area")
        )
        assert page.text("curve-point").startswith(f"mean pressure {load} MPa: contact area {area}")
    Select(page.find("curve-quantity")).select_by_value("maximum pressure")
    ActionChains(page.driver).move_to_element(curve).perform()
    page.until(lambda: "MPa: maximum pressure " in page.text("curve-point"))


@pytest.mark.parametrize("width", [1280, 390])
@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_it_has_no_fault_of_accessibility(page, scheme, width):
    folder = resources.files(pytest.importorskip("axe_core_python"))
    axe = (folder / "axe.min.js").read_text(encoding="utf-8")

    def check():
        page.until(lambda: page.driver.find_element(By.TAG_NAME, "body").get_attribute("aria-busy") is None)
        page.driver.execute_script(axe)
        found = page.driver.execute_async_script("axe.run().then(arguments[0])")
        return [(fault["id"], fault["nodes"][0]["html"]) for fault in found["violations"]]

    page.emulate(width, 900, scheme)
    page.open()
    page.until(page.is_answered)
    page.until(lambda: not page.find("progress").is_displayed())
    assert check() == []
    # With all that is folded, a wrong value, and a curve.
    page.set("loads", "1 2 4")
    page.until_planned()
    page.find("solve").click()
    page.until(lambda: page.text("headline").startswith("3 loads solved"))
    page.until(lambda: not page.find("progress").is_displayed())
    page.driver.execute_script("for (const one of document.querySelectorAll('details')) one.open = true")
    page.set("young", "-1")
    page.until(lambda: page.driver.find_elements(By.ID, "wrong"))
    assert check() == []


def test_a_map_is_dropped_solved_and_reported(page, surface, tmp_path):
    table = write_table(surface)
    page.open_example().drop(table, "ring <1>.csv")
    page.until(lambda: "not the size of its domain" in page.text("surface-problem"))
    assert "ring <1>.csv, 48 x 40 points" in page.text("file-shown")
    # It is said where the button is, too: the surface may be out of view.
    assert page.text("plan") == page.text("surface-problem")
    # A wrong unit is warned of before the solve.
    for name, text in {"size_x": "48", "size_y": "40", "height_unit": "m"}.items():
        page.set(name, text)
    page.until(lambda: "the unit of heights from a file" in page.text("plan-warnings"))
    assert not page.find("surface-problem").is_displayed()
    page.set("height_unit", "um")
    page.until(lambda: not page.find("plan-warnings").is_displayed())
    for name, text in {"size_x": "48", "size_y": "40", "height_unit": "um", "form": "plane", "loads": "50"}.items():
        page.set(name, text)
    page.until_planned()
    page.find("solve").click()
    page.until(page.is_answered)
    path = tmp_path / "ring.csv"
    path.write_text(table)
    expected = rc.read_surface(path, size=SIZE, unit=1e-6).detrend("plane")
    solution = rc.ContactProblem(rc.Body(expected, rc.Elastic(210e9, 0.3))).solve(pressure=50e6)
    assert page.value("contact area") == solution.area().value
    assert page.value("maximum pressure") == solution.peak_pressure().value
    report = page.download("ring-1-50-MPa-report.html")
    page.driver.switch_to.new_window("tab")
    page.driver.get(report.as_uri())
    assert "ring <1>.csv" in page.driver.find_element(By.TAG_NAME, "body").text
    page.driver.close()
    page.driver.switch_to.window(page.driver.window_handles[0])
    with page.download("ring-1-50-MPa-answers.csv").open(encoding="utf-8-sig", newline="") as file:
        assert float(next(csv.DictReader(file))["contact area, m2"]) == pytest.approx(solution.area().value, rel=1e-8)
    with np.load(page.download("ring-1-50-MPa-solution-1.npz")) as data:
        assert np.array_equal(data["pressure"], solution.pressure)


def test_a_second_map_is_dropped_placed_and_solved(page, surface, tmp_path):
    path = tmp_path / "body.npz"
    np.savez(path, heights=surface.values, size=SIZE)
    page.open_example().find("file-input").send_keys(str(path))
    page.until(lambda: "body.npz" in page.text("file-shown"))
    page.set("counterbody_surface", "file")
    page.until(lambda: "the height map of the counterbody is not here" in page.text("surface-problem"))
    page.drop(write_table(surface), "other.csv", "counterbody_drop")
    page.until(lambda: "other.csv, 48 x 40 points" in page.text("counterbody_file-shown"))
    assert page.text("counterbody_size-help") == "x: 48 lines of the file; y: 40 values in each."
    assert not page.find("size_x").is_displayed()
    for name, text in {"size_x": "48", "size_y": "40", "height_unit": "um"}.items():
        page.set(f"counterbody_{name}", text)
    for name, text in {"offset_x": "-4", "rotation": "180", "mirrored": "yes"}.items():
        page.set(name, text)
    page.until(lambda: "rotated by 180 degrees" in page.text("counterbody-history"))
    page.until(lambda: page.find("counterbody-picture").is_displayed())
    page.until_planned()
    page.find("solve").click()
    page.until(page.is_answered)
    assert "body.npz, on other.csv shifted by -4, 0 µm rotated by 180° mirrored, " in page.text("run-subject")
    other = rc.HeightMap(np.loadtxt(write_table(surface).splitlines(), delimiter=",") * 1e-6, size=SIZE)
    pair = rc.match(surface, other, offset=(-4e-6, 0.0), rotation=np.pi, mirrored=True)
    rigid = rc.Body(pair.counterbody, rc.Rigid())
    problem = rc.ContactProblem(rc.Body(pair.body, rc.Elastic(210e9, 0.3)), rigid, grid=pair.grid)
    assert page.value("contact area") == pytest.approx(problem.solve(pressure=1e8).area().value, rel=1e-9)
    # The address holds both maps while the command runs.
    page.open(page.driver.current_url)
    page.until(lambda: "other.csv, 48 x 40 points" in page.text("counterbody_file-shown"))
    assert page.setting("rotation") == "180"
    page.set("counterbody_surface", "flat")
    page.until(lambda: not page.find("counterbody-shown").is_displayed())


def test_a_file_is_chosen_and_a_bad_one_refused_in_words(page, surface, tmp_path):
    page.open_example()
    bad, good = tmp_path / "bad.csv", tmp_path / "good.npz"
    bad.write_text("1,2,3\n4,5\n")
    np.savez(good, heights=surface.values, size=SIZE)
    page.find("file-input").send_keys(str(bad))
    page.until(lambda: "The file bad.csv cannot be used" in page.text("surface-problem"))
    page.find("file-input").send_keys(str(good))
    page.until(lambda: page.find("surface-picture").is_displayed() and "good.npz" in page.text("file-shown"))
    assert not page.find("surface-problem").is_displayed()
    # The file states its size and unit, so that neither is asked for.
    assert not page.find("size_x").is_displayed()
    page.set("loads", "2,5")
    page.until(lambda: "Write decimals with a point" in page.text("plan"))
    page.find("solve").click()
    page.until(lambda: "Write decimals with a point" in page.text("refusal"))


def test_solve_waits_for_the_file_and_needs_one_that_was_read(page, server, surface, monkeypatch):
    sent, read = threading.Event(), server.session.upload
    monkeypatch.setattr(server.session, "upload", lambda *file: read(*file) if sent.wait(PATIENCE) else None)
    page.open_example().until_planned()
    page.set("boundary", "periodic")
    page.drop(write_table(surface), "ring.csv")
    page.until(lambda: page.text("solve-why") == "Solve waits until ring.csv is read.")
    # Neither the button nor the return key solves what was shown before.
    assert not page.find("solve").is_enabled()
    page.find("loads").send_keys(Keys.ENTER)
    page.until(lambda: page.text("plan") == page.text("surface-history") == "")
    sent.set()
    page.until(lambda: page.text("size-help") == "x: 48 lines of the file; y: 40 values in each.")
    page.set("rows", "y")
    page.until(lambda: page.text("size-help") == "x: 40 values in each; y: 48 lines of the file.")
    page.set("rows", "auto")
    assert page.find("solve").is_enabled()
    # What has changed beside the user's doing is said until he changes it himself.
    assert page.text("boundary-note") == "The border was periodic; for this surface it is now free."
    page.set("boundary", "periodic")
    assert page.text("boundary-note") == ""
    page.set("boundary", "free")
    assert not page.has_run_in_address()
    page.drop("1,2,3\n4,5\n", "bad.csv")
    page.until(lambda: "The file bad.csv cannot be used" in page.text("surface-problem"))
    assert "There is no surface to solve" in page.text("solve-why")
    assert not page.find("solve").is_enabled()
    for place in ("plan", "surface-history", "file-shown"):
        assert page.text(place) == "", place
    assert not page.driver.find_elements(By.CSS_SELECTOR, "#surface-table td")
    page.set("surface", "example")
    page.until_planned()
    assert page.find("solve").is_enabled()
    page.drop(write_table(surface)[:-1], "other.csv")
    page.until(lambda: "other.csv, 48 x 40 points" in page.text("file-shown"))
    # No link has asked for a file.
    assert "of the link" not in page.text("file-shown")


def test_filled_points_are_counted_and_filling_is_of_one_file(page, surface, tmp_path):
    for name, missing in {"one.npz": 3, "two.npz": 4}.items():
        heights = np.array(surface.values)
        heights[5, :missing] = np.nan
        np.savez(tmp_path / name, heights=heights, size=SIZE)
    page.open_example().find("file-input").send_keys(str(tmp_path / "one.npz"))
    page.until(lambda: page.find("non_measured").is_displayed())
    page.set("non_measured", "fill")
    page.until(lambda: "Non-measured points 3 of 1920, filled" in page.text("surface-table"))
    assert "Size of a cell 1 µm x 1 µm" in page.text("surface-table")
    page.find("file-input").send_keys(str(tmp_path / "two.npz"))
    page.until(lambda: "4 points were not measured: choose" in page.text("surface-problem"))
    assert page.setting("non_measured") == "refuse"


def test_what_is_ticked_is_answered_and_reported(page):
    page.open_example()
    for name, text in {"surface": "wavy", "cells": "48", "side": "50", "loads": "20"}.items():
        page.set(name, text)
    for name in ("stiffness", "conductance", "leakage"):
        page.tick(f"ask_{name}")
    page.until(lambda: "Conductivity of body and counterbody (conductance) is missing" in page.text("plan"))
    for name, text in {
        "conductance_conductivity": "50 20",
        "leakage_viscosity": "1",
        "leakage_pressure_drop": "0.1",
    }.items():
        page.set(f"ask_{name}", text)
    page.set("ask_leakage_axis", "y")
    page.until_planned()
    page.find("solve").click()
    page.until(page.is_answered)
    assert page.text("run-subject").endswith("periodic; with conductance, leakage, stiffness.")
    body = rc.Body(rc.WavySurface(0.5e-6, 25e-6), rc.Elastic(210e9, 0.3))
    solution = rc.ContactProblem(body, grid=rc.Grid((48, 48), 50e-6), boundary="periodic").solve(pressure=20e6)
    assert page.value("stiffness") == pytest.approx(solution.stiffness().value, rel=1e-9)
    assert page.value("conductance") == pytest.approx(solution.conductance((50.0, 20.0)).value, rel=1e-9)
    leakage = solution.leakage(axis=1, viscosity=1e-3, pressure_drop=1e5)
    assert page.value("leakage") == pytest.approx(leakage.value, rel=1e-9)
    assert "±" in page.driver.find_element(By.CSS_SELECTOR, "[data-quantity=stiffness]").text
    assert not page.find("places").is_displayed()
    assert "What the contact does" in page.download("wavy-20-MPa-report.html").read_text(encoding="utf-8")
    # The address ticks the same boxes.
    page.open(page.driver.current_url)
    assert page.driver.find_element(By.NAME, "ask_leakage").is_selected()
    assert page.setting("ask_leakage_axis") == "y"
    page.set("load", "fretting")
    assert page.reveal(page.driver.find_element(By.NAME, "ask_leakage")).is_displayed()
    assert "stiffness" in page.text("s-questions")


def test_an_answer_says_how_much_other_places_differ(page):
    page.open_example()
    for name, text in {"surface": "self-affine", "cells": "64", "loads": "50 100"}.items():
        page.set(name, text)
    page.until_planned()
    page.find("solve").click()
    page.until(lambda: page.text("headline").startswith("2 loads solved; at "))
    # Of the last load, in one sentence.
    assert page.text("places").startswith("Other places of the surface, at 100 MPa: contact area ± ")
    assert ", maximum pressure ± " in page.text("places")
    assert "+-" not in page.text("places")


def test_an_answer_says_what_it_answers(page):
    page.open_example()
    for name, text in {"surface": "wavy", "cells": "64", "loads": "20", "hardness": "7"}.items():
        page.set(name, text)
    page.until_planned()

    def solve():
        before = page.text("run-subject")
        page.find("solve").click()
        page.until(lambda: page.text("run-subject") not in ("", before) and page.text("headline"))
        place = page.find("headline").location
        page.until(lambda: page.driver.find_elements(By.LINK_TEXT, "Download the report"))
        page.until(lambda: not page.find("progress").is_displayed())
        # Nothing moves when the progress ends.
        assert page.find("headline").location == place
        return page.text("run-subject")

    first = solve()
    assert first.endswith(": wavy, 20 MPa, E 210 GPa, ν 0.3, hardness 7 GPa, periodic.")
    assert page.has_run_in_address()
    page.set("loads", "30")
    assert page.text("stale") == "The settings have changed since."
    assert not page.has_run_in_address()
    page.set("loads", "20")
    assert not page.find("stale").is_displayed()
    assert page.has_run_in_address()
    second = solve()
    assert first != second
    # Equal runs have numbers, and the one that is shown is marked; a reload loses none of them.
    page.driver.refresh()
    number, of_second = (text.partition(":")[0] for text in (first, second))
    of_first = [By.XPATH, f"//tbody[@id='run-list']//button[.='{number}']"]
    page.until(lambda: page.driver.find_elements(*of_first) and page.text("run-subject") == second)
    for _ in range(2):
        page.driver.find_element(*of_first).click()
        page.until(lambda: page.text("run-subject") == first and page.find("picture").is_displayed())
        marked = page.driver.find_elements(By.CSS_SELECTOR, "#run-list [aria-pressed=true]")
        assert [button.text for button in marked] == [number]
    area = page.driver.find_element(By.CSS_SELECTOR, "[data-quantity='contact area']").text
    row = page.driver.find_element(By.XPATH, f"//tbody[@id='run-list']/tr[th/button[.='{number}']]")
    assert area in row.text
    # Two runs stand side by side.
    page.driver.find_element(By.CSS_SELECTOR, f"[aria-label^='{of_second} beside']").click()
    rows = page.find("beside").find_elements(By.TAG_NAME, "tr")
    assert rows[0].text.split("\n") == [f"{number} {of_second}"]
    assert f"contact area {area} {area}" in [row.text for row in rows]
    # Nor does an old address show a run as that of other settings.
    page.driver.execute_script("location.hash = location.hash.replace('loads=20', 'loads=30')")
    page.until(lambda: page.setting("loads") == "30" and page.find("stale").is_displayed())
    assert page.text("run-subject") == first
    assert not page.has_run_in_address()


def test_what_is_wrong_is_said_under_its_field_and_what_is_old_is_marked(page):
    page.open_example().until_planned()
    page.set("loads", "x")
    # What is on its way has a blank in its place, which says nothing old.
    assert page.driver.find_element(By.TAG_NAME, "body").get_attribute("aria-busy") == "true"
    assert page.find("plan").value_of_css_property("color") == "rgba(0, 0, 0, 0)"
    page.until(lambda: page.text("wrong") == "The load must be a number such as 2.5, but got 'x'.")
    loads = page.find("loads")
    assert loads.get_attribute("aria-invalid") == "true"
    assert page.find("wrong").location["y"] > loads.location["y"]
    assert page.driver.find_element(By.TAG_NAME, "body").get_attribute("aria-busy") is None
    page.set("poisson", "0.7")
    page.until(lambda: "Poisson's ratio" in page.text("wrong"))
    assert page.find("poisson").get_attribute("aria-invalid") == "true"
    assert loads.get_attribute("aria-invalid") is None
    for name, text in {"poisson": "0.3", "loads": "10"}.items():
        page.set(name, text)
    page.until_planned()
    assert not page.driver.find_elements(By.ID, "wrong")
    # A link brings a wrong value of a group that is closed: it opens, and no other does.
    page.open(f"{page.address}#surface=sphere&young=-1")
    page.until(lambda: page.driver.find_elements(By.ID, "wrong"))
    groups = page.driver.find_elements(By.CSS_SELECTOR, ".group[open]")
    assert [group.get_attribute("id") for group in groups] == ["g-materials"]
    assert "Young's modulus of the body must be above 0" in groups[0].find_element(By.ID, "wrong").text


def test_typical_values_and_links_do_what_they_say(page):
    page.open_example()
    preset = Select(page.find("preset"))
    preset.select_by_value("bearing steel")
    assert page.setting("hardness") == "7"
    preset.select_by_value("rubber")
    assert (page.setting("young"), page.setting("hardness")) == ("0.004", "")
    page.set("young", "210")
    assert preset.first_selected_option.text == "choose"
    page.find("link").find_element(By.XPATH, "ancestor::details/summary").click()
    for link, problem in {
        "rubbish": "it has no setting 'rubbish'",
        "http://127.0.0.1/#form=cubic": "its 'form' is 'cubic', which the page does not offer",
    }.items():
        page.find("link").clear()
        page.find("link").send_keys(link, Keys.ENTER)
        page.until(lambda expected=problem: expected in page.text("link-problem"))
        assert page.setting("poisson") == "0.495"
    page.find("link").clear()
    page.find("link").send_keys(f"#surface=file&file={'0' * 64}&file_name=lost.npz&loads=33", Keys.ENTER)
    page.until(lambda: "Choose or drop the file of this link again: lost.npz" in page.text("note"))
    assert (page.setting("loads"), page.setting("poisson")) == ("33", "0.3")
    assert not page.find("link-problem").is_displayed()
    # The return key has started nothing.
    assert not page.find("run").is_displayed()


def test_a_run_is_cancelled(page):
    page.open_example()
    for name, text in {"surface": "self-affine", "cells": "1024", "loads": "60 61 62 63 64 65 66 67 68 69"}.items():
        page.set(name, text)
    page.until_planned()
    page.find("solve").click()
    page.until(lambda: "Solving" in page.text("phase") and " of 10, " in page.text("phase"))
    page.find("cancel").click()
    page.until(lambda: page.text("run-problem") == "The run was cancelled.")
    assert not page.find("progress").is_displayed()


def test_a_reload_in_the_middle_keeps_run_and_settings(page):
    page.open_example()
    for name, text in {
        "surface": "self-affine",
        "cells": "512",
        "shortest": "1",
        "loads": "50 80",
        "poisson": "0.27",
    }.items():
        page.set(name, text)
    page.until_planned()
    page.find("solve").click()
    page.until(lambda: "run=" in page.driver.current_url and page.find("progress").is_displayed())
    page.driver.refresh()
    page.until(lambda: page.text("headline").startswith("2 loads solved; at "))
    assert page.driver.find_element(By.NAME, "poisson").get_attribute("value") == "0.27"
    assert page.driver.find_element(By.NAME, "cells").get_attribute("value") == "512"
    rows = page.driver.find_elements(By.CSS_SELECTOR, "#answer-table tbody tr")
    assert len(rows) == 2
    # Units stand in the head of a column, and its numbers have three digits, but for the load that was given.
    head, cells = (
        [cell.text for cell in page.driver.find_elements(By.CSS_SELECTOR, f"#answer-table {path}")]
        for path in ("thead th", "tbody tr:first-child td")
    )
    assert head[0] == "mean pressure, MPa"
    assert cells[0] == "50"
    assert head[1].startswith("force, ")
    assert len(cells[1].replace(".", "").lstrip("0")) <= 3
    assert "±" in cells[2]
    page.until(lambda: "area load" in page.text("panel-buttons"))


def test_a_link_restores_the_settings_and_asks_for_the_file(page, surface, server):
    link = f"{page.address}#surface=file&file={'0' * 64}&file_name=lost.npz&young=70&boundary=periodic&form=quadratic"
    page.open(link)
    wanted = "Choose or drop the file of this link again: lost.npz, digest 000000000000"
    page.until(lambda: wanted in page.text("file-shown"))
    assert page.driver.find_element(By.NAME, "young").get_attribute("value") == "70"
    assert page.driver.find_element(By.NAME, "form").get_attribute("value") == "quadratic"
    page.drop(write_table(surface), "found.csv")
    page.until(lambda: "It is not the file of the link, lost.npz" in page.text("file-shown"))
    # The file is remembered while the server lives, and the form keeps what the link said.
    assert page.driver.find_element(By.NAME, "boundary").get_attribute("value") == "periodic"
    page.open(page.driver.current_url)
    page.until(lambda: "found.csv, 48 x 40 points" in page.text("file-shown"))


def test_it_fits_390_pixels_in_light_and_dark(page):
    for scheme in ("light", "dark"):
        page.emulate(390, 844, scheme)
        page.open_example()
        page.set("surface", "wavy")
        page.set("loads", "50 80")
        page.until_planned()
        assert not page.is_wider_than_the_screen()
        page.find("solve").click()
        page.until(lambda: page.text("headline").startswith("2 loads solved; at "))
        page.until(lambda: page.find("curves").is_displayed())
        assert not page.is_wider_than_the_screen()
        for group in page.driver.find_elements(By.CLASS_NAME, "group"):
            page.reveal(group)
        assert not page.is_wider_than_the_screen()
        color = page.driver.execute_script("return getComputedStyle(document.body).backgroundColor")
        assert (sum(map(int, color[4:-1].split(", "))) < 200) is (scheme == "dark")


def test_everything_is_done_from_the_keyboard(page):
    page.open_example()
    seen = []

    def tab_to(name):
        for _ in range(80):
            # Not sent to the element: to an input of files keys are paths.
            ActionChains(page.driver).send_keys(Keys.TAB).perform()
            active = page.driver.switch_to.active_element
            seen.append(active.get_attribute("id") or active.get_attribute("name") or active.get_attribute("class"))
            seen[-1] = seen[-1] or active.tag_name
            outline = page.driver.execute_script("return getComputedStyle(arguments[0]).outlineStyle", active)
            assert outline != "none", f"{seen[-1]} does not show that it has the focus"
            if name in seen[-1]:
                return active
        raise AssertionError(f"{name} is not reached: {seen}")

    def open_group(name):
        while True:
            summary = tab_to("summary")
            if summary.find_element(By.XPATH, "..").get_attribute("id") == name:
                summary.send_keys(Keys.ENTER)
                return

    open_group("g-surface")
    tab_to("surface").send_keys("w")
    page.until(lambda: page.driver.find_element(By.ID, "amplitude").is_displayed())
    open_group("g-load")
    tab_to("loads").send_keys(Keys.CONTROL, "a")
    page.driver.switch_to.active_element.send_keys("40")
    page.until_planned()
    assert seen.index("surface") < seen.index("amplitude") < seen.index("loads")
    page.driver.switch_to.active_element.send_keys(Keys.ENTER)
    page.until(page.is_answered)
    # The focus is where the answer begins.
    assert page.driver.switch_to.active_element.get_attribute("id") == "h-answer"
    page.until(lambda: page.find("picture").is_displayed())
    # The pictures are one stop of the tabulator, and arrows go on from there.
    page.until(lambda: page.driver.find_elements(By.ID, "tab-gap"))
    tab_to("tab-pressure").send_keys(Keys.ARROW_RIGHT)
    assert page.driver.switch_to.active_element.get_attribute("id") == "tab-gap"
    assert page.find("panel").get_attribute("aria-labelledby") == "tab-gap"
    shown = page.find("picture").find_element(By.TAG_NAME, "img")
    page.until(lambda: "gap of this contact" in shown.get_attribute("alt"))
    frame = tab_to("frame")
    frame.send_keys("+")
    frame.send_keys("+")
    frame.send_keys(Keys.ARROW_RIGHT)
    image = frame.find_element(By.TAG_NAME, "img")
    assert "scale(2.25)" in image.get_attribute("style")
    moved = image.get_attribute("style")
    frame.send_keys(Keys.ARROW_LEFT)
    assert image.get_attribute("style") != moved
    frame.send_keys("0")
    assert "scale(1)" in image.get_attribute("style")


def test_the_roughness_is_measured_when_it_is_opened(page):
    page.open_example().until_planned()
    assert not page.driver.find_elements(By.CSS_SELECTOR, "[data-texture]")
    page.click(page.find("roughness").find_element(By.TAG_NAME, "summary"))
    page.until(lambda: "±" in page.driver.find_element(By.CSS_SELECTOR, "[data-texture=Sq]").text)
    page.until(lambda: page.find("roughness-surfaces").find_element(By.CLASS_NAME, "pictures").size["height"] > 100)
    before = page.driver.find_element(By.CSS_SELECTOR, "[data-texture=Sq]").text
    page.set("form", "quadratic")
    page.until(lambda: page.driver.find_element(By.CSS_SELECTOR, "[data-texture=Sq]").text != before)


def test_a_picture_is_zoomed_by_wheel_and_buttons(page):
    page.open_example()
    page.until(lambda: page.find("surface-picture").is_displayed())
    frame = page.find("surface-picture").find_element(By.CLASS_NAME, "frame")
    image = frame.find_element(By.TAG_NAME, "img")
    page.until(lambda: image.size["height"] > 100)
    plus, minus, show_all = page.find("surface-picture").find_elements(By.TAG_NAME, "button")
    page.click(plus)
    assert "scale(1.5)" in image.get_attribute("style")
    page.click(minus)
    assert "scale(1)" in image.get_attribute("style")
    wheel = (
        "arguments[0].focus(); arguments[0].dispatchEvent(new WheelEvent('wheel', {deltaY: -300, cancelable: true}))"
    )
    page.driver.execute_script(wheel, frame)
    assert "scale(2.71" in image.get_attribute("style")
    page.click(show_all)
    assert "scale(1)" in image.get_attribute("style")


def test_solve_is_in_view_and_a_swipe_over_a_picture_scrolls_the_page(page):
    page.emulate(1280, 900)
    page.open_example().until_planned()
    # However much is open.
    for group in page.driver.find_elements(By.CLASS_NAME, "group"):
        page.reveal(group)
    assert page.bottom("solve") < 900
    page.emulate(390, 844)
    assert page.bottom("solve") < 844
    page.driver.execute_cdp_cmd("Emulation.setTouchEmulationEnabled", {"enabled": True})
    picture = page.find("surface-picture").find_element(By.CLASS_NAME, "frame")

    page.until(lambda: picture.size["height"] > 200)

    def swipe():
        page.driver.execute_script("arguments[0].scrollIntoView({ block: 'center' })", picture)
        top = "return [scrollY, arguments[0].getBoundingClientRect().top]"
        before, y = page.driver.execute_script(top, picture)
        for kind, moved in (("touchStart", 0), *(("touchMove", step) for step in range(10, 90, 10)), ("touchEnd", 0)):
            points = [] if kind == "touchEnd" else [{"x": 195, "y": int(y) + 150 - moved}]
            page.driver.execute_cdp_cmd("Input.dispatchTouchEvent", {"type": kind, "touchPoints": points})
        # The page may move on for a moment.
        page.until(lambda: page.driver.execute_async_script(STANDS))
        return page.driver.execute_script(top, picture)[0] - before

    assert swipe() > 40
    page.click(page.find("surface-picture").find_element(By.TAG_NAME, "button"))
    assert swipe() == 0


def test_an_old_link_is_refused_in_words(page):
    page.driver.get(page.address.replace(page.address.split("/")[3], "old"))
    text = page.driver.find_element(By.TAG_NAME, "body").text
    assert text.startswith("roughcontact\nThis link is not of the run")
    assert "open the address that it has printed" in text
    # The status of the refusal itself is logged.
    page.driver.get_log("browser")


def test_the_file_that_the_browser_is_given_leads_to_the_page(page, tmp_path, monkeypatch):
    monkeypatch.setattr("webbrowser.open", lambda _: True)
    monkeypatch.setattr("roughcontact_app.command._SNAPS", tmp_path / "none")
    with _shown(page.address, tmp_path):
        (leading,) = tmp_path.glob("roughcontact-*.html")
        page.open(leading.as_uri())
        assert page.driver.current_url.startswith(page.address)
    assert not leading.exists()


def test_the_driver_is_the_system_own():
    assert Path(DRIVER).exists()
    assert Path(CHROMIUM).exists()


def test_a_film_law_is_read_drawn_and_downloaded(page):
    page.open_example()
    page.set("load", "film")
    assert page.text("boundary-note") == "The border was free; for a film law it is now periodic."
    for name, text in {"surface": "self-affine", "cells": "48", "shortest": "8", "separations": "1..2 9"}.items():
        page.set(name, text)
    page.until(lambda: page.text("plan").startswith("6 separations, about"))
    page.find("solve").click()
    page.until(lambda: page.text("headline") == "6 separations solved; at 1.75 Sq:")
    assert page.text("numbers").startswith("phi xx")
    assert "other places ±" in page.text("numbers")
    assert page.text("places").startswith("Fits beside the columns: greenwood-tripp: factor ")
    Select(page.find("curve-quantity")).select_by_value("asperity pressure")
    page.find("curve").send_keys(Keys.HOME)
    assert page.text("curve-point").startswith("separation over Sq 1: asperity pressure ")
    assert "MPa; other places ± " in page.text("curve-point")
    # What the form has changed is kept with another surface, and refused at its field.
    page.set("surface", "example")
    assert page.setting("boundary") == "periodic"
    page.set("boundary", "free")
    page.until(lambda: "needs a domain that repeats" in page.text("wrong"))
    assert page.download("self-affine-film.csv").read_text(encoding="utf-8").startswith("separation_over_sq,")
    assert "phi_s_xx" in page.download("self-affine-report.html").read_text(encoding="utf-8")
    assert page.download("self-affine-phi-xx.txt").read_text(encoding="utf-8").startswith("# separation_m phi_xx")


def test_a_cycle_of_surfaces_that_attract_each_other(page):
    page.open_example()
    assert not page.find("cycle_from").is_displayed()
    for name, text in {"surface": "sphere", "radius": "6", "radius_unit": "um", "side": "6", "cells": "96"}.items():
        page.set(name, text)
    for name, text in {"young": "5", "young_unit": "MPa", "poisson": "0.5", "load": "cycle"}.items():
        page.set(name, text)
    page.until(lambda: "choose an adhesion" in page.text("refusal") + page.text("plan"))
    assert not page.find("loads").is_displayed()
    for name, text in {"adhesion": "exponential", "range": "30", "cycle_from": "-0.3", "cycle_to": "0.1"}.items():
        page.set(name, text)
    page.set("states", "9")
    page.tick("ask_stiffness")
    page.until(lambda: "17 states, about" in page.text("plan"))
    page.find("solve").click()
    page.until(lambda: page.text("numbers").lower().startswith("pull-off\n-1.4"))
    assert page.text("headline") == "A cycle of approaches"
    assert "energy lost" in page.text("numbers").lower()
    assert "approach from -0.3 to 0.1 µm and back" in page.text("run-subject")
    assert "exponential adhesion of 50 mJ/m², range 30 nm" in page.text("run-subject")
    assert page.text("run-subject").endswith("; with stiffness.")
    assert page.value("jumps") >= 1
    assert page.value("stiffness at the last approach") > 0.0
    page.until(lambda: page.find("picture").is_displayed())
    table = page.download("sphere-cycle.csv")
    head = table.read_text(encoding="utf-8").partition("\n")[0]
    assert head.startswith("branch,")
    assert "stiffness [N/m]" in head
    # The link of the settings, opened anew, asks for the same cycle.
    address = page.driver.current_url
    page.open(address)
    assert (page.setting("load"), page.setting("cycle_to"), page.setting("states")) == ("cycle", "0.1", "9")


def test_a_fretting_cycle(page):
    page.open_example()
    assert not page.find("tangential_force").is_displayed()
    for name, text in {"surface": "sphere", "radius": "1", "side": "100", "cells": "32", "load": "fretting"}.items():
        page.set(name, text)
    assert not page.find("loads").is_displayed()
    for name, text in {"counterbody": "deformable", "tangential_force": "400", "tangential_force_unit": "mN"}.items():
        page.set(name, text)
    page.until(lambda: "must be below the coefficient of friction times" in page.text("refusal") + page.text("plan"))
    page.set("tangential_force", "200")
    # The time is said before anything is solved.
    page.until(lambda: "20 states, about" in page.text("plan"))
    page.find("solve").click()
    page.until(lambda: page.text("numbers").lower().startswith("energy lost in a cycle"))
    assert "normal force 1 N, tangential force ±200 mN, friction 0.3" in page.text("run-subject")
    steel = rc.Elastic(210e9, 0.3)
    bodies = rc.Body(rc.SphereSurface(1e-3), steel), rc.Body(rc.FlatSurface(), steel)
    path = rc.ContactProblem(*bodies, grid=rc.Grid((32, 32), 100e-6)).path(
        force=1.0, tangential_force=[(0.2, 0.0), (-0.2, 0.0), (0.2, 0.0)], friction=0.3
    )
    lost = path.numbers[1].dissipated.value + path.numbers[2].dissipated.value
    assert page.value("energy lost in a cycle") == pytest.approx(lost, rel=1e-3)
    page.until(lambda: page.find("picture").is_displayed())
    table = page.download("sphere-loop.csv")
    assert len(table.read_text(encoding="utf-8").splitlines()) == 21
    saved = page.download("sphere-path.npz")
    assert rc.FrictionalPath.load(saved).dissipated.value == pytest.approx(path.dissipated.value, rel=1e-3)
    # The link of the settings, opened anew, asks for the same cycle.
    page.open(page.driver.current_url)
    assert (page.setting("load"), page.setting("tangential_force"), page.setting("friction")) == (
        "fretting",
        "200",
        "0.3",
    )


def test_the_progress_of_a_fretting_cycle_of_unlike_materials(page):
    page.open_example()
    for name, text in {"surface": "sphere", "radius": "1", "side": "100", "cells": "64", "load": "fretting"}.items():
        page.set(name, text)
    page.until(lambda: "3 states, about" in page.text("plan"))
    page.find("solve").click()
    page.until(lambda: "doubled, up to 16, until the numbers hardly change" in page.text("phase"))
    assert page.find("bar").get_attribute("value") is not None
    page.find("cancel").click()
    page.until(lambda: "The run was cancelled." in page.text("run-problem"))


@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_a_path_and_a_slider_over_its_states(page, scheme):
    page.emulate(390, 844, scheme)
    page.open_example()
    for name, text in {"surface": "sphere", "radius": "1", "side": "100", "cells": "32", "load": "force"}.items():
        page.set(name, text)
    assert not page.find("time").is_displayed()
    for name, text in {"loads": "4 0 2 4", "path": "yes", "hardness": "2", "sliding": "0 0.1 0.2 1"}.items():
        page.set(name, text)
    page.until(lambda: "give the problem a law that does" in page.text("plan"))
    page.tick("law_archard")
    page.set("law_archard_coefficient", "1e-10mm2/N")
    page.until(lambda: "4 states, about" in page.text("plan"))
    page.find("solve").click()
    page.until(lambda: page.text("headline").startswith("4 states of the path; at the end:"))
    assert "4 0 2 4 N, a path, sliding 0 0.1 0.2 1 m, archard, E 210 GPa" in page.text("run-subject")
    # The course of the numbers comes first, as a curve.
    page.until(lambda: page.find("curves").is_displayed())
    assert not page.find("path-states").is_displayed()
    image = page.driver.find_element(By.CSS_SELECTOR, "#picture img")

    def press(panel):
        page.until(lambda: page.driver.find_element(By.XPATH, f"//*[@id='panel-buttons']/button[.='{panel}']")).click()

    def until_other_than(before):
        page.until(lambda: "pictures/" in (image.get_attribute("src") or "") and image.get_attribute("src") != before)
        page.until(lambda: page.find("picture").get_attribute("aria-busy") is None)
        page.until(lambda: int(image.get_attribute("naturalWidth")) > 100)
        return image.get_attribute("src")

    press("pressure")
    last = until_other_than(image.get_attribute("src"))
    slider = page.find("state")
    assert (slider.get_attribute("value"), page.text("state-name")) == ("4", "state 4, after sliding 1 m, 4 N")
    # The keyboard moves it, and what reads the page aloud says where it stands.
    slider.send_keys(Keys.ARROW_LEFT)
    assert slider.get_attribute("aria-valuetext") == page.text("state-name") == "state 3, after sliding 200 mm, 2 N"
    third = until_other_than(last)
    slider.send_keys(Keys.HOME)
    assert page.text("state-name") == "state 1, after sliding 0 m, 4 N"
    first = until_other_than(third)
    assert "pressure of state 1" in image.get_attribute("alt")
    # Another panel is of the same state.
    press("gap")
    until_other_than(first)
    assert "gap of state 1" in image.get_attribute("alt")
    assert not page.is_wider_than_the_screen()
    press("course")
    assert not page.find("path-states").is_displayed()
    assert len(page.download("sphere-4-0-2-4-N-path.csv").read_text(encoding="utf-8").splitlines()) == 5
    assert page.download("sphere-4-0-2-4-N-path.gif").read_bytes()[:6] == b"GIF89a"
    path = rc.load(page.download("sphere-4-0-2-4-N-path.npz"))
    assert path.sliding.tolist() == [0.0, 0.1, 0.2, 1.0]
    assert page.driver.find_element(By.CSS_SELECTOR, "[data-quantity='worn volume']")
    # The link of the settings, opened anew, asks for the same path.
    page.open(page.driver.current_url)
    assert (page.setting("path"), page.setting("sliding"), page.setting("law_archard_coefficient")) == (
        "yes",
        "0 0.1 0.2 1",
        "1e-10mm2/N",
    )
    assert page.driver.find_element(By.NAME, "law_archard").is_selected()


@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_a_material_of_a_plug_in_flows_and_is_seen_over_the_depth(page, scheme):
    pytest.importorskip("roughcontact_volume")
    page.emulate(390, 844, scheme)
    page.open_example()
    own = "material_plastic_hardening_swift_hardening_power"
    for name, text in {"surface": "sphere", "radius": "1", "side": "65", "cells": "16", "load": "force"}.items():
        page.set(name, text)
    assert page.find("hardness").is_displayed()
    assert not page.find("material_plastic_yield_stress").is_displayed()
    # The counterbody has the same fields.
    page.set("counterbody", "deformable")
    page.set("counterbody_material", "plastic")
    assert page.find(f"counterbody_{own.replace('_swift_hardening_power', '')}").is_displayed()
    page.set("counterbody", "rigid")
    page.set("material", "plastic")
    assert (page.find("young").is_displayed(), page.find("hardness").is_displayed()) == (True, False)
    page.until(lambda: page.text("wrong") == "The yield stress of the body is missing: fill it in.")
    assert page.find("material_plastic_yield_stress").get_attribute("aria-invalid") == "true"
    page.set("material_plastic_yield_stress", "1000")
    assert not page.find(own).is_displayed()
    page.set("material_plastic_hardening", "swift-hardening")
    page.set(own.replace("power", "strain"), "0.005")
    page.set(own, "2")
    page.until(lambda: "The power of hardening must be" in page.text("wrong"))
    page.set(own, "0.2")
    page.set("loads", "2 0")
    page.set("path", "yes")
    page.until(lambda: "2 states, about" in page.text("plan"))
    assert not page.is_wider_than_the_screen()
    page.find("solve").click()
    page.until(lambda: page.text("headline").startswith("2 states of the path; at the end:"))
    hard = "plastic, E 210 GPa, ν 0.3, yield stress 1000 MPa, swift hardening (strain 0.005; power 0.2)"
    assert hard in page.text("run-subject")
    image = page.driver.find_element(By.CSS_SELECTOR, "#picture img")
    seen = set()
    for panel in ("plastic zone", "residual stress", "total stress"):
        button = f"//*[@id='panel-buttons']/button[.='{panel}']"
        page.until(lambda button=button: page.driver.find_element(By.XPATH, button)).click()
        page.until(lambda panel=panel: f"The {panel} of state 2, 0 N" in image.get_attribute("alt"))
        page.until(lambda: int(image.get_attribute("naturalWidth")) > 100)
        seen.add(image.get_attribute("src"))
    assert len(seen) == 3
    assert not page.is_wider_than_the_screen()
    assert page.driver.find_element(By.CSS_SELECTOR, "[data-quantity='plastic strain']")
    page.open(page.driver.current_url)
    assert (page.setting("material"), page.setting("material_plastic_hardening"), page.setting(own)) == (
        "plastic",
        "swift-hardening",
        "0.2",
    )
    assert page.find(own).is_displayed()
