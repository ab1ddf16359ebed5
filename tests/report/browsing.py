"""A browser without a window, in which tests open pages as a reader does."""

import json
import os
import shutil

import pytest

#: what a reader's screen is wide, in pixels
SCREEN = (1400, 900)
OPTIONS = (
    "--headless",
    "--no-sandbox",
    "--disable-gpu",
    "--disable-quic",
    "--no-first-run",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
)


def open_browser(profile):
    """Chromium; BOLTJOINT_BROWSER=required makes its absence a failure."""
    stop = pytest.fail if os.environ.get("BOLTJOINT_BROWSER") == "required" else pytest.skip
    chromium = shutil.which("chromium") or shutil.which("chromium-browser")
    driver = shutil.which("chromedriver")
    if chromium is None or driver is None:
        stop("no chromium and chromedriver on this machine: .ci/install-browser installs them")
    try:
        from selenium import webdriver
        from selenium.webdriver.chrome.service import Service
    except ImportError:
        stop("selenium is not installed: pip install -e .[test]")
    options = webdriver.ChromeOptions()
    options.binary_location = chromium
    for option in (*OPTIONS, f"--user-data-dir={profile}"):
        options.add_argument(option)
    options.set_capability("goog:loggingPrefs", {"browser": "ALL", "performance": "ALL"})
    running = webdriver.Chrome(options=options, service=Service(driver))
    running.set_window_size(*SCREEN)
    return running


def errors(browser):
    """What the console of the browser has complained about since it was asked last."""
    return [entry for entry in browser.get_log("browser") if entry["level"] == "SEVERE"]


def wait_for(browser, find):
    """The first true answer of a function, within a few seconds."""
    from selenium.webdriver.support.ui import WebDriverWait

    return WebDriverWait(browser, 10, poll_frequency=0.05).until(lambda _: find())


#: beginnings of addresses of what a page holds itself, and of the browser's own pages
_OWN = ("data:", "blob:", "chrome:")


def requests(browser):
    """Addresses from elsewhere that the browser has loaded since it was asked last."""
    messages = (json.loads(entry["message"])["message"] for entry in browser.get_log("performance"))
    loaded = (
        each["params"]["request"]["url"]
        for each in messages
        if each["method"] == "Network.requestWillBeSent"
    )
    return [address for address in loaded if not address.startswith(_OWN)]
