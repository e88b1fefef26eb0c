"""The figure of docs/start/app.md: the page with an answer, in Debian's headless Chromium, by selenium.

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
# Seconds, and pixels.
PATIENCE = 180
BORDER = 150


def draw(address, profile):
    options = webdriver.ChromeOptions()
    options.binary_location = "/usr/bin/chromium"
    for flag in ("headless=new", "no-sandbox", "disable-gpu", "window-size=1280,1800", f"user-data-dir={profile}"):
        options.add_argument(f"--{flag}")
    driver = webdriver.Chrome(options=options, service=Service("/usr/bin/chromedriver"))
    wait = WebDriverWait(driver, PATIENCE)
    try:
        driver.get(address)
        wait.until(lambda page: "for the solve" in page.find_element(By.ID, "plan").text)
        driver.find_element(By.ID, "solve").click()
        wait.until(lambda page: page.find_element(By.CSS_SELECTOR, "#picture img").size["height"] > 100)
        wait.until(lambda page: not page.find_element(By.ID, "progress").is_displayed())
        # The window shows the whole page, and some for its own border.
        driver.set_window_size(1280, driver.execute_script("return document.documentElement.scrollHeight") + BORDER)
        driver.execute_script("scrollTo(0, 0)")
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
