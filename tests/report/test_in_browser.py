"""The page in a Chromium: it complains of nothing, fetches nothing, draws every chart, and zooms."""

import sys
from importlib.util import module_from_spec, spec_from_file_location
from pathlib import Path

import pytest

from attest_mav.cli.main import main

HERE = Path(__file__).parent
LAPS = HERE.parent / "data" / "copter_square_laps.tlog"


def load_chromium():
    """The module beside this one: tests are found by path, and import nothing of each other."""
    spec = spec_from_file_location("report_chromium", HERE / "chromium.py")
    module = module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


chromium = load_chromium()
pytestmark = pytest.mark.skipif(chromium.PROGRAM is None, reason="no chromium is installed (Debian: chromium)")

COLOURED_PIXELS = """
[...document.querySelectorAll("canvas")].map((canvas) => {
  const pixels = canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height).data;
  let count = 0;
  for (let i = 0; i < pixels.length; i += 4) {
    const three = pixels.slice(i, i + 3);
    if (pixels[i + 3] > 100 && Math.max(...three) - Math.min(...three) > 60) count++;
  }
  return count;
})
"""
"""Pixels that are no grey, by canvas: axes and texts are grey, series are not. A level line can lie between rows."""
SHOWN = "[Number(document.body.dataset.begin), Number(document.body.dataset.end)]"
FIRST_CHART = """
(() => {
  const canvas = document.querySelector("#charts canvas");
  canvas.scrollIntoView({ block: "center" });
  const box = canvas.getBoundingClientRect();
  return [box.left, box.top, box.width, box.height];
})()
"""


@pytest.fixture(scope="module")
def page(tmp_path_factory):
    """The page of a short flight, made by the command."""
    path = tmp_path_factory.mktemp("page") / "flight.html"
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(sys, "argv", ["attest-mav", "replay", str(LAPS), "--skip", "2", "--report", str(path)])
        with pytest.raises(SystemExit) as end:
            main()
    assert not end.value.code
    return path


@pytest.fixture
def browser(tmp_path, page):
    """A browser with the page open."""
    opened = chromium.Chromium(tmp_path, 1280, 900)
    try:
        opened.open(page)
        opened.settled()
        yield opened
    finally:
        opened.close()


def test_the_page_draws_every_chart_without_complaint_or_request(browser, page):
    coloured = browser.value(COLOURED_PIXELS)
    assert len(coloured) >= 12
    assert min(coloured) > 100
    assert browser.complaints == []
    assert browser.requests == [page.as_uri()]


def test_dragging_zooms_all_charts_and_a_double_click_ends_it(browser):
    begin, end = browser.value(SHOWN)
    left, top, width, height = browser.value(FIRST_CHART)
    before = browser.value("[...document.querySelectorAll('canvas')].map((one) => one.toDataURL())")
    middle = top + height / 2
    browser.drag((left + 0.4 * width, middle), (left + 0.6 * width, middle))
    zoomed = browser.value(SHOWN)
    assert zoomed[1] - zoomed[0] == pytest.approx(0.2 * (end - begin), rel=0.1)
    assert begin < zoomed[0] < zoomed[1] < end
    after = browser.value("[...document.querySelectorAll('canvas')].map((one) => one.toDataURL())")
    assert all(one != other for one, other in zip(before, after, strict=True))
    browser.value(
        "document.querySelector('#charts canvas').dispatchEvent(new MouseEvent('dblclick', { bubbles: true })), 1"
    )
    browser.settled()
    assert browser.value(SHOWN) == [begin, end]


def test_pointing_shows_the_verdict_and_the_values_of_all_charts(browser):
    left, top, width = browser.value(
        "(({ left, top, width }) => [left, top, width])"
        "(document.querySelector('#timeline canvas').getBoundingClientRect())"
    )
    browser.point(left + 0.7 * width, top + 8)
    tip = "(({ style, textContent }) => [style.display, textContent])(document.getElementById('tip'))"
    shown, text = browser.value(tip)
    assert shown == "block"
    assert text.startswith("agree, ")
    left, top, width, height = browser.value(FIRST_CHART)
    browser.point(left + 0.7 * width, top + height / 2)
    assert browser.value(tip)[0] == "none"
    readings = browser.value(
        "[...document.querySelectorAll('#charts figure')].map((one) => one.querySelector('b').textContent)"
    )
    assert all(readings)
    assert readings[0].endswith("°")


def test_a_series_can_be_hidden(browser):
    browser.value("document.querySelector('#charts figure').querySelectorAll('.key').forEach((key) => key.click())")
    browser.settled()
    timeline, first, *others = browser.value(COLOURED_PIXELS)
    assert timeline > 100
    assert first == 0
    assert min(others) > 100


def test_buttons_zoom_and_move(browser):
    begin, end = browser.value(SHOWN)
    browser.value("document.querySelector('[title=\"Zoom in\"]').click()")
    browser.value("document.querySelector('[title=\"Later\"]').click()")
    browser.settled()
    length = (end - begin) / 2
    first, last = browser.value(SHOWN)
    assert first == pytest.approx(begin + 0.25 * (end - begin) + 0.4 * length, abs=0.01)
    assert last - first == pytest.approx(length, abs=0.01)


def test_the_page_fits_a_phone(browser, page):
    browser.call("Emulation.setDeviceMetricsOverride", width=390, height=844, deviceScaleFactor=2, mobile=True)
    browser.open(page)
    browser.settled()
    assert browser.value("document.documentElement.scrollWidth") == 390


def test_a_browser_names_a_broken_page(tmp_path, browser):
    broken = tmp_path / "broken.html"
    broken.write_text("<script>missing.call()</script>", encoding="utf-8")
    browser.open(broken)
    assert any("missing" in one or "Uncaught" in one for one in browser.complaints)
