"""The documents of the site, of a service with a simulated vehicle."""

import json
import re
from dataclasses import replace
from math import degrees

import pytest

from attest_mav.algebra import q_to_euler
from attest_mav.config.parsing import parse_config
from attest_mav.mavlink.dialect import load_dialect
from attest_mav.service.assembly import service_settings
from attest_mav.service.link_records import Traffic
from attest_mav.service.service import Service
from attest_mav.sim.autopilot import FakeAutopilot
from attest_mav.sim.settings import SimSettings
from attest_mav.types import EarthField
from attest_mav.web.request import Refusal, Request
from attest_mav.web.site import Site

UP = [Traffic(is_up=True, is_open=True)]


class Flown:
    """A service beside a standing vehicle, on virtual time."""

    def __init__(self):
        dialect = load_dialect()
        config = parse_config("[[link]]\nurl = 'udpin::0'\n", "test")
        self.vehicle = FakeAutopilot(SimSettings(scenario="still", fast_rate_hz=50.0), 1, dialect)
        settings = service_settings(config)
        self.service = Service(settings, ['li"nk\\'], dialect, lambda *_: (EarthField(0.2, -1.1), "a test"), 0)
        self.now_ns = 0

    def run_until(self, t_s, *, silent=False):
        while self.now_ns < t_s * 1e9:
            self.now_ns += 10_000_000
            data = b"".join(self.vehicle.frames_until(self.now_ns))
            if not silent:
                self.service.receive(0, data, self.now_ns)
            self.service.poll(self.now_ns)
            for frame in self.service.take_frames(0):
                self.vehicle.handle(frame, self.now_ns)

    def snapshot(self, traffic=None):
        return self.service.snapshot(self.now_ns, traffic or UP)

    def get(self, path, traffic=None):
        return Site({"/": b"<p>page</p>"}).answer(Request(path, True), lambda: self.snapshot(traffic))


@pytest.fixture(scope="module")
def flown():
    made = Flown()
    made.run_until(15.0)
    return made


def test_the_status_is_the_snapshot_in_degrees_and_seconds(flown):
    document = json.loads(flown.get("/status").body)
    snapshot = flown.snapshot()
    estimate = snapshot.published_lane.estimate
    shown = next(lane for lane in document["lanes"] if lane["estimate"])["estimate"]
    assert document["now_s"] == pytest.approx(15.0)
    assert shown["tilt_sigma_deg"] == pytest.approx(degrees(estimate.tilt_sigma))
    roll, pitch, _ = (degrees(angle) for angle in q_to_euler(flown.vehicle.truth(flown.now_ns).q_nb))
    assert shown["roll_deg"] == pytest.approx(roll, abs=1.0)
    assert document["autopilot"]["source"] == "ATTITUDE"
    assert document["autopilot"]["pitch_deg"] == pytest.approx(pitch, abs=1.0)
    assert document["verdict"]["agreement"] == document["spans"][-1]["agreement"] == "agree"
    assert document["tilt_threshold_deg"] == pytest.approx(3.0)
    assert document["links"][0]["name"] == 'li"nk\\'
    assert document["ailments"] == document["obstacles"] == []
    renamed = {"now_ns", "tilt_threshold"}
    assert vars(snapshot).keys() - renamed <= document.keys()


def test_before_anything_came_the_status_knows_nothing_and_is_healthy():
    idle = Flown()
    document = json.loads(idle.get("/status").body)
    assert document["vehicle"] is document["verdict"] is document["tilt_threshold_deg"] is None
    assert idle.get("/healthz").status == 200
    assert "attest_mav_vehicle_present 0" in idle.get("/metrics").body.decode()


def test_metrics_have_the_form_of_prometheus_and_the_values_of_the_snapshot(flown):
    text = flown.get("/metrics").body.decode()
    known = set()
    for line in text.splitlines():
        if line.startswith("# TYPE "):
            name, kind = line.split()[2:]
            assert name not in known
            assert (kind == "counter") == name.endswith("_total")
            known.add(name)
        elif not line.startswith("# HELP "):
            match = re.fullmatch(r'(\w+)(\{\w+="(?:[^"\\\n]|\\[\\"n])*"\})? (NaN|[-+.e0-9]+)', line)
            assert match, line
            assert match[1] in known
    assert f"attest_mav_samples_total {flown.snapshot().samples}\n" in text
    assert 'attest_mav_verdict{agreement="agree"} 1\n' in text
    assert f'attest_mav_link_frames_total{{link="li\\"nk\\\\"}} {flown.snapshot().links[0].frames}\n' in text


def test_health_names_a_link_that_is_closed(flown):
    answer = flown.get("/healthz", [Traffic(is_up=False, is_open=False)])
    assert answer.status == 503
    assert answer.body == b'li"nk\\ is not open\n'


def test_health_names_a_present_vehicle_without_samples():
    f = Flown()
    f.run_until(8.0)
    assert f.get("/healthz").status == 200
    f.run_until(9.0, silent=True)
    assert f.snapshot().vehicle.is_present
    assert (f.get("/healthz").status, f.get("/healthz").body) == (503, b"nothing is sent: samples stopped\n")
    f.run_until(30.0, silent=True)
    assert not f.snapshot().vehicle.is_present
    assert f.get("/healthz").status == 200


def test_pages_and_what_does_not_exist(flown):
    page = flown.get("/")
    assert (page.status, page.body, page.content_type) == (200, b"<p>page</p>", "text/html; charset=utf-8")
    assert flown.get("/../etc/passwd").status == 404
    stream = flown.get("/events")
    assert stream.streams
    data = stream.body.decode().splitlines()
    assert json.loads(next(line for line in data if line.startswith("data: "))[6:])["state"] == "active"


def test_an_answer_for_head_has_no_body_and_a_refusal_says_what_is_allowed(flown):
    page = flown.get("/status")
    assert page.encoded(with_body=False) == page.encoded(with_body=True)[: -len(page.body)]
    assert f"Content-Length: {len(page.body)}\r\n".encode() in page.encoded(with_body=False)
    refused = Site({}).answer(Refusal(replace(page, status=405).status, "no"), flown.snapshot)
    assert refused.body == b"no\n"
