"""Chromium without a window, as Debian packages it: opens a page and tells what a reader would see and meet."""

import json
import re
import shutil
import time
from contextlib import contextmanager

import numpy as np
import pytest

WIDE, NARROW = (1280, 900), (390, 844)
PAGE = "report.html"
READ = """
const [places, done] = arguments, canvas = document.querySelector('.view canvas'), found = [];
const frame = () => new Promise((next) => requestAnimationFrame(next));
(async () => {
  for (const [x, y] of places) {
    const box = canvas.getBoundingClientRect();
    const at = {clientX: box.left + x * box.width, clientY: box.top + y * box.height};
    canvas.dispatchEvent(new PointerEvent('pointermove', at));
    await frame();
    const read = document.querySelector('.view .read');
    if (read.dataset.value !== '') found.push([Number(read.dataset.value), read.textContent]);
  }
  done(found);
})();
"""


class Browser:
    """A page in a browser; the console and the network are listened to."""

    def __init__(self, driver):
        self.driver = driver

    def open(self, path, size=WIDE, dark=False):
        """Open a page and wait until its scripts are done."""
        metrics = {"width": size[0], "height": size[1], "deviceScaleFactor": 1, "mobile": size[0] < 500}
        self.command("Emulation.setDeviceMetricsOverride", **metrics)
        scheme = {"name": "prefers-color-scheme", "value": "dark" if dark else "light"}
        self.command("Emulation.setEmulatedMedia", features=[scheme])
        self.driver.get_log("browser"), self.driver.get_log("performance")
        self.driver.get(path.resolve().as_uri())
        self.wait("return document.documentElement.dataset.ready === 'true'")

    def wait(self, condition, seconds=30):
        """Wait until a script returns true."""
        end = time.monotonic() + seconds
        while not self.run(condition):
            assert time.monotonic() < end, f"{condition}: not within {seconds} s; {self.complaints()}"
            time.sleep(0.05)

    def command(self, name, **arguments):
        return self.driver.execute_cdp_cmd(name, arguments)

    def run(self, script, *arguments):
        return self.driver.execute_script(script, *arguments)

    def text(self, css):
        return self.run("return document.querySelector(arguments[0]).textContent", css)

    def change(self, identifier, value, event="input"):
        """Give a control a value, as its user does."""
        script = "const c = document.getElementById(arguments[0]); c.value = arguments[1];"
        self.run(f"{script} c.dispatchEvent(new Event(arguments[2]))", identifier, str(value), event)

    def press(self, identifier):
        self.run("document.getElementById(arguments[0]).click()", identifier)

    def complaints(self):
        """What stands in the console."""
        return [entry["message"] for entry in self.driver.get_log("browser")]

    def requests(self):
        """Addresses that the page asked for, itself and what it holds aside."""
        messages = [json.loads(entry["message"])["message"] for entry in self.driver.get_log("performance")]
        asked = [one["params"]["request"]["url"] for one in messages if one["method"] == "Network.requestWillBeSent"]
        return [url for url in asked if not url.startswith(("data:", "blob:", "file:"))]

    def overflow(self):
        """How many pixels the page is wider than its window."""
        return self.run("return document.documentElement.scrollWidth - innerWidth")


@contextmanager
def opened(*switches):
    """A browser, closed at the end; a test without one is skipped."""
    webdriver = pytest.importorskip("selenium.webdriver", reason="Selenium is not installed here")
    programs = [shutil.which(name) for name in ("chromium", "chromedriver")]
    if not all(programs):
        pytest.skip("Debian's packages chromium and chromium-driver are not installed here")
    options = webdriver.ChromeOptions()
    options.binary_location = programs[0]
    given = ("--headless=new", "--no-sandbox", "--disable-dev-shm-usage", "--use-angle=swiftshader", *switches)
    for switch in (*given, "--enable-unsafe-swiftshader"):
        options.add_argument(switch)
    options.set_capability("goog:loggingPrefs", {"browser": "ALL", "performance": "ALL"})
    driver = webdriver.Chrome(options=options, service=webdriver.ChromeService(programs[1]))
    try:
        yield Browser(driver)
    finally:
        driver.quit()


def all_readings(browser):
    """Values by the number of their cell or node, from a grid of places."""
    places = [(x, y) for x in np.linspace(0.2, 0.8, 7) for y in np.linspace(0.3, 0.7, 5)]
    found = browser.driver.execute_async_script(READ, places)
    return {int(words.split()[-1]): value for value, words in found}


def step_of(browser):
    """Largest rounding of the shown field that the page states."""
    return float(re.search(r"rounded by (\S+)", browser.text("#range-note"))[1])
