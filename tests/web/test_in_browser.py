"""The live page in a Chromium, with a daemon and its built-in vehicle: it lives, fits, and says when it is alone."""

import re
import subprocess
import sys
from importlib.util import module_from_spec, spec_from_file_location
from pathlib import Path

import pytest

CHROMIUM = Path(__file__).parents[1] / "report" / "chromium.py"


def load_chromium():
    """The module beside the tests of the other page: tests are found by path, and import nothing of each other."""
    spec = spec_from_file_location("web_chromium", CHROMIUM)
    module = module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


chromium = load_chromium()
pytestmark = pytest.mark.skipif(chromium.PROGRAM is None, reason="no chromium is installed (Debian: chromium)")

UNTIL = """
new Promise((done) => {
  const look = () => ((%s) ? done(1) : setTimeout(look, 50));
  look();
})
"""
NEXT_EVENT = """
new Promise((done) => {
  const source = new EventSource("/events");
  let count = 0;
  source.onmessage = () => {
    if (++count < 3) return;
    source.close();
    requestAnimationFrame(() => requestAnimationFrame(() => done(1)));
  };
})
"""
"""Waits until the page has drawn another event."""
HORIZONS = """
["ours", "theirs"].map((id) => {
  const canvas = document.getElementById(id), { width, height } = canvas;
  const pixels = canvas.getContext("2d").getImageData(0, 0, width, height).data;
  let sky = 0;
  for (let i = 0; i < pixels.length; i += 4) if (pixels[i + 2] > pixels[i] + 60 && pixels[i + 3] > 200) sky++;
  const radius = Math.min(width, height) / 2 - (4 * width) / canvas.clientWidth;
  const across = [-1, -0.5, 0, 0.5, 1].map((more) => {
    const along = (radius + more) * Math.SQRT1_2;
    const at = 4 * (Math.floor(height / 2 - along) * width + Math.floor(width / 2 - along));
    return pixels[at + 3] > 100 ? pixels[at + 2] - pixels[at] : 255;
  });
  return { sky: sky / (pixels.length / 4), rim: Math.min(...across) };
})
"""
"""Of both horizons: the share of sky; and of the pixels across the rim by how much the least blue one exceeds red."""


@pytest.fixture
def daemon():
    """A running daemon and the address of its page."""
    arguments = ["run", "--link", "sim:still", "--set", "web.listen=127.0.0.1:0"]
    process = subprocess.Popen(
        [sys.executable, "-P", "-m", "attest_mav", *arguments], stderr=subprocess.PIPE, text=True
    )
    address = next(match[1] for line in process.stderr if (match := re.search(r"live page is at (\S+)", line)))
    yield process, address
    process.terminate()
    process.communicate()


def test_the_page_lives_and_says_when_the_daemon_is_gone(daemon, tmp_path):
    process, address = daemon
    browser = chromium.Chromium(tmp_path, 1280, 900)
    try:
        browser.visit(address)
        browser.value(UNTIL % "document.getElementById('verdict').className === 'agree'")
        browser.settled()
        for horizon in browser.value(HORIZONS):
            assert horizon["sky"] > 0.1
            assert horizon["rim"] < 60
        assert browser.value("document.body.className") == ""
        assert "agrees" in browser.value("document.getElementById('verdict').textContent")
        assert browser.value("document.querySelectorAll('#lanes td').length") >= 5
        assert browser.complaints == []
        assert all(one.startswith(address) for one in browser.requests)
        browser.call("Emulation.setDeviceMetricsOverride", width=390, height=844, deviceScaleFactor=2, mobile=True)
        browser.settled()
        assert browser.value("document.documentElement.scrollWidth") == 390
        browser.value("for (const one of document.querySelectorAll('figure')) one.style.display = 'none'")
        browser.value(NEXT_EVENT)
        assert browser.complaints == [], "figures without a size, as in a window that is not laid out"
        browser.value("for (const one of document.querySelectorAll('figure')) one.style.display = ''")
        process.terminate()
        browser.value(UNTIL % "document.body.className === 'stale'")
        assert "the daemon is gone" in browser.value("document.getElementById('connection').textContent")
        assert browser.value("getComputedStyle(document.querySelector('main')).filter") == "grayscale(1)"
    finally:
        browser.close()
