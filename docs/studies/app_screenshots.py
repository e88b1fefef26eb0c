"""The figure of docs/start/app.md: the page as it opens, with its answer, in Debian's headless Chromium, by selenium.

Writes docs/figures/app.png. Takes a minute.
"""

from __future__ import annotations

import tempfile
import threading
from pathlib import Path

from selenium import webdriver
from selenium.webdriver.chrome.service import Service
from selenium.webdriver.common.by import By
from selenium.webdriver.support.ui import WebDriverWait

from roughcontact_app import AppServer, Session

FIGURE = Path(__file__).parents[1] / "figures" / "app.png"
# Seconds, and pixels: one screen.
PATIENCE = 180
SCREEN = {"width": 1280, "height": 900, "deviceScaleFactor": 1, "mobile": False}


def draw(address, profile):
    options = webdriver.ChromeOptions()
    options.binary_location = "/usr/bin/chromium"
    for flag in ("headless=new", "no-sandbox", "disable-gpu", "hide-scrollbars", f"user-data-dir={profile}"):
        options.add_argument(f"--{flag}")
    driver = webdriver.Chrome(options=options, service=Service("/usr/bin/chromedriver"))
    wait = WebDriverWait(driver, PATIENCE)
    try:
        driver.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", SCREEN)
        driver.get(address)
        wait.until(lambda page: page.find_element(By.CSS_SELECTOR, "#picture img").size["height"] > 100)
        wait.until(lambda page: "for the solve" in page.find_element(By.ID, "plan").text)
        wait.until(lambda page: not page.find_element(By.ID, "progress").is_displayed())
        FIGURE.write_bytes(driver.get_screenshot_as_png())
    finally:
        driver.quit()


if __name__ == "__main__":
    session = Session()
    try:
        with AppServer(session) as server, tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as folder:
            threading.Thread(target=server.serve_forever, daemon=True).start()
            draw(server.address, folder)
            server.shutdown()
    finally:
        session.close()
