"""The page: texts of logs stay texts, nothing is fetched, and its script stands in the policy."""

import json
import re
from base64 import b64encode
from hashlib import sha256
from html.parser import HTMLParser

import pytest

from attest_mav.report.page import Assets, page_of, summary_of
from attest_mav.vehicle_reports import EstimatorNews, EstimatorNewsSample

ASSETS = Assets("p { color: red }", "document.title;", "attest-mav 0")
HOSTILE = "</script><script>alert(1)</script><!--<img src=x onerror=alert(2)> & \" ' {0} \u2028 \udcff"


class Reader(HTMLParser):
    """Tags of the page, and the content of its scripts."""

    def __init__(self, page):
        super().__init__(convert_charrefs=True)
        self.tags, self.scripts, self.text = [], [], ""
        self._in_script = False
        self.feed(page)

    def handle_starttag(self, tag, attrs):
        self.tags.append((tag, dict(attrs)))
        self._in_script = tag == "script"
        if self._in_script:
            self.scripts.append("")

    def handle_endtag(self, tag):
        self._in_script = False

    def handle_data(self, data):
        if self._in_script:
            self.scripts[-1] += data
        self.text += data


@pytest.fixture
def hostile_page(recorder, report):
    """A page of a log in which every text is hostile."""
    recorder.vehicle(EstimatorNewsSample("STATUSTEXT", 1, 1, 0, EstimatorNews.VARIANCE, HOSTILE), 2.0)
    report["log"] = HOSTILE
    report["notes"] = [HOSTILE]
    report["lanes"][0]["message"] = HOSTILE
    report["lanes"][0]["faults"][0]["text"] = HOSTILE
    report["reference"]["message"] = HOSTILE
    report["verdict"]["intervals"][0]["sensors"] = [HOSTILE]
    return page_of(report, recorder, ASSETS)


def test_hostile_texts_make_no_element(hostile_page):
    read = Reader(hostile_page)
    names = [tag for tag, _ in read.tags]
    assert names.count("script") == 2
    assert "img" not in names
    assert not [one for _, attributes in read.tags for one in attributes if one.startswith("on")]
    assert read.scripts[1] == ASSETS.script
    assert HOSTILE in read.text
    data = json.loads(read.scripts[0])
    assert data["marks"][0]["text"] == HOSTILE
    assert data["lanes"][0]["name"] == HOSTILE
    assert "<" not in read.scripts[0]


def test_names_that_are_no_text_can_be_written(hostile_page):
    assert b"{0} \xe2\x80\xa8 ?" in hostile_page.encode(errors="replace")


def test_the_policy_allows_the_own_script_and_style_alone(recorder, report):
    page = page_of(report, recorder, ASSETS)
    policy = next(one["content"] for _, one in Reader(page).tags if one.get("http-equiv"))
    script, style = (
        f"'sha256-{b64encode(sha256(one.encode()).digest()).decode()}'" for one in (ASSETS.script, ASSETS.style)
    )
    assert policy == f"default-src 'none'; style-src {style}; script-src {script}"
    assert not re.search(r"\b(?:src|href)=|url\(", page)


def test_data_of_the_page(recorder, report):
    data = json.loads(Reader(page_of(report, recorder, ASSETS)).scripts[0])
    assert data["verdict"] == [
        {
            "begin": 3.0,
            "end": 5.0,
            "state": "disagree",
            "text": "DISAGREE, 3.0 to 5.0 s: tilt; largest tilt difference 12.0°; RAW_IMU used",
        }
    ]
    assert data["lanes"][0]["faults"] == [{"begin": 4.0, "end": None, "text": "frozen: repeats one reading"}]


@pytest.mark.parametrize(
    ("lasted", "state", "text"),
    [
        ((0.0, 2.0, 0.0), "disagree", "DISAGREE for 2.0 s."),
        ((50.0, 2.0, 1.0), "disagree", "DISAGREE for 2.0 s, agree for 50.0 s, undecided for 1.0 s."),
        ((50.0, 0.0, 1.0), "agree", "agree for 50.0 s, undecided for 1.0 s."),
        ((0.0, 0.0, 9.0), "undecided", "undecided for 9.0 s."),
    ],
)
def test_the_summary_begins_with_what_matters(report, lasted, state, text):
    report["verdict"].update(zip(("agree_s", "disagree_s", "undecided_s"), lasted, strict=True))
    assert summary_of(report) == (state, f"Verdict on the autopilot's attitude: {text}")


def test_without_an_attitude_of_the_autopilot_there_is_no_verdict(recorder, report):
    report["verdict"]["intervals"] = []
    report["reference"] = None
    page = page_of(report, recorder, ASSETS)
    assert "No verdict: the log has no attitude of the autopilot to judge." in page
    assert "Reference: none" in page


def test_the_largest_errors_have_log_time_time_of_day_and_phase(recorder, report):
    text = Reader(page_of(report, recorder, ASSETS)).text
    assert "Largest errorsangleerror, °log time, stime of day, UTCphasevelocity-aidedtilt37.222:13:27.4climb" in text


def test_a_log_without_a_date_has_no_time_of_day(recorder, report):
    report["filters"][0]["tilt_deg"]["max_at_unix_s"] = None
    assert "velocity-aidedtilt37.2-climb" in Reader(page_of(report, recorder, ASSETS)).text


def test_a_smoothed_reference_tells_its_sigma(recorder, report):
    spread = {"rms": 0.0421, "p95": 0.05, "max": 0.06}
    report["reference"] = {
        "message": "smoothed",
        "samples": 600,
        "sigma": {"tilt_deg": spread, "heading_deg": None, "unsure": 0},
    }
    assert "Reference: smoothed, tilt sigma 0.0421° rms" in Reader(page_of(report, recorder, ASSETS)).text
