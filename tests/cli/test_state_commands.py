"""``status`` and ``watch``: a look at a daemon over HTTP, and what they say where there is none."""

import http.server
import json
import threading

import pytest
from click.testing import CliRunner

from attest_mav.cli import state_text, status, watch
from attest_mav.config.parsing import parse_config
from attest_mav.errors import LinkError, UsageError
from attest_mav.mavlink.dialect import load_dialect
from attest_mav.service.assembly import service_settings
from attest_mav.service.link_records import Traffic
from attest_mav.service.service import Service
from attest_mav.sim.autopilot import FakeAutopilot
from attest_mav.sim.settings import SimSettings
from attest_mav.types import EarthField
from attest_mav.web.document import encoded


@pytest.fixture(scope="module")
def documents():
    """The states of a daemon before a vehicle comes, ten seconds later, and five seconds after it was switched off."""
    dialect = load_dialect()
    vehicle = FakeAutopilot(SimSettings(scenario="still", fast_rate_hz=50.0), 1, dialect)
    config = parse_config("[[link]]\nurl = 'udpin::0'\n", "test")
    service = Service(service_settings(config), ["udpin::0"], dialect, lambda *_: (EarthField(0.2, -1.1), "x"), 0)
    states = [encoded(service.snapshot(0, [Traffic(is_open=True)]))]
    for now_ns in range(0, 10_000_000_000, 10_000_000):
        service.receive(0, b"".join(vehicle.frames_until(now_ns)), now_ns)
        service.poll(now_ns)
        for frame in service.take_frames(0):
            vehicle.handle(frame, now_ns)
    states.append(encoded(service.snapshot(now_ns, [Traffic(is_open=True)])))
    for silent_ns in range(now_ns, now_ns + 5_000_000_000, 10_000_000):
        service.poll(silent_ns)
    return [*states, encoded(service.snapshot(silent_ns, [Traffic(is_open=True)]))]


class Answers(http.server.BaseHTTPRequestHandler):
    """Gives the server's answers one after another, the last one for ever; None ends the connection."""

    def do_GET(self):
        answers = self.server.answers
        body = answers.pop(0) if len(answers) > 1 else answers[0]
        if body is None:
            return
        self.send_response(200)
        self.end_headers()
        self.wfile.write(body)

    def log_message(self, *_):
        pass


@pytest.fixture
def server(monkeypatch):
    """Makes a server with these answers; its address."""
    monkeypatch.setattr(watch, "PERIOD_S", 0.0)
    servers = []

    def make(*answers):
        made = http.server.HTTPServer(("127.0.0.1", 0), Answers)
        made.answers = list(answers)
        threading.Thread(target=made.serve_forever, args=(0.01,), daemon=True).start()
        servers.append(made)
        return f"127.0.0.1:{made.server_port}"

    yield make
    for one in servers:
        one.shutdown()
        one.server_close()


def run(module, *arguments):
    done = CliRunner().invoke(module.command, arguments, catch_exceptions=False)
    assert done.exit_code == 0
    return done.output


def test_status_prints_verdict_attitudes_sensors_and_links(server, documents):
    said = run(status, "--at", server(documents[1]))
    lines = said.splitlines()
    assert lines[0] == "active: system 1, disarmed"
    assert any(line.startswith("ATTITUDE agrees, tilt 0.") for line in lines)
    assert any(line.startswith("  ours       roll ") for line in lines)
    assert any(line.startswith("  RAW_IMU: ") for line in lines)
    assert any(line.startswith("  udpin::0: open, ") for line in lines)


def test_status_of_a_vehicle_that_is_gone_names_no_aid_and_no_difference(server, documents):
    lines = run(status, "--at", server(documents[2])).splitlines()
    assert lines[0].endswith(", not heard")
    assert "  RAW_IMU: no samples" in lines
    assert any(" undecided (no-reference), for " in line for line in lines)
    assert "heading -" not in "".join(lines).replace("heading -0.", "")


def test_the_newest_measurement_of_each_aid_is_told_though_most_steps_have_none(documents):
    state = json.loads(documents[1])
    ages_s = {one["aid"]: state["now_s"] - one["received_s"] for one in state["aids"]}
    assert ages_s["magnetometer"] < 0.5  # ten a second at least
    assert json.loads(documents[0])["aids"] == []


def test_status_of_a_daemon_without_a_vehicle_and_as_json(server, documents):
    address = server(documents[0])
    assert run(status, "--at", address).splitlines()[:2] == ["waiting: no vehicle yet", "no verdict yet"]
    assert json.loads(run(status, "--at", address, "--json")) == json.loads(documents[0])


@pytest.mark.parametrize("module", [status, watch], ids=["status", "watch"])
def test_where_no_daemon_answers_the_code_is_69_and_the_line_says_what_to_do(server, module):
    for answer, said in ((None, r"no daemon answers .*web\.listen"), (b"<html>", "is no attest-mav"), (b"{}", "is no")):
        with pytest.raises(LinkError, match=said) as caught:
            CliRunner().invoke(module.command, ["--at", server(answer)], catch_exceptions=False)
        assert caught.value.exit_code == 69
        assert "\n" not in str(caught.value)


def test_an_address_that_is_none_is_a_usage_error():
    with pytest.raises(UsageError, match=r"--at: expected HOST:PORT, such as 127\.0\.0\.1:8484, got 'nonsense'"):
        CliRunner().invoke(status.command, ["--at", "nonsense"], catch_exceptions=False)


def test_watch_in_a_pipe_writes_a_line_for_each_change_and_waits_for_a_daemon_that_is_gone(server, documents):
    idle, active, _ = documents
    address = server(idle, idle, active, active, None, None, active)
    lines = run(watch, "--at", address, "--looks", "7").splitlines()
    assert [line.split(":")[0] for line in lines] == ["waiting", "active", "the daemon at 127.0.0.1", "active"]
    assert "agrees" in lines[1]
    assert lines[2].endswith(" is gone")


def test_bytes_that_are_no_mavlink_are_told_where_a_vehicle_is_waited_for(documents):
    state = json.loads(documents[0])
    state["links"][0]["bad_bytes"] = 500
    assert state_text.headline(state).endswith("bytes come, but no MAVLink; is the baud rate right?")


def rows_of(state, size, banner=""):
    return watch._view(state, banner, "here at 12:00:00; Ctrl-C ends", size).plain.split("\n")


def test_watch_on_a_terminal_shows_the_whole_state(documents):
    state = json.loads(documents[1])
    rows = rows_of(state, (80, 40))
    assert any(row.startswith("ATTITUDE agrees") for row in rows)
    assert any(row.startswith("  RAW_IMU: published, 5") for row in rows)
    assert rows[-1] == "here at 12:00:00; Ctrl-C ends"
    assert rows_of(state, (80, 40), "it is gone")[0] == "it is gone"


@pytest.mark.parametrize("size", [(40, 10), (60, 20), (100, 30)], ids=str)
def test_watch_fits_the_terminal_and_says_what_it_leaves_out(documents, size):
    columns, height = size
    state = json.loads(documents[1])
    rows = rows_of(state, size)
    whole = rows_of(state, (columns, 1000))
    assert max(map(len, rows)) <= columns
    assert len(rows) <= height
    left_out = len(whole) - len(rows)
    assert rows[-1].startswith(f"{left_out} lines more" if left_out else "here at")
    assert rows[:-1] == whole[: len(rows) - 1]


def test_lines_of_a_section_that_are_folded_are_told_from_titles(documents):
    rows = rows_of(json.loads(documents[1]), (30, 1000))
    titles = [row for row in rows if not row.startswith(" ")]
    assert "links" in titles
    assert "sent" not in " ".join(titles)


def test_watch_on_a_terminal_without_a_cursor_writes_lines(server, documents, monkeypatch):
    monkeypatch.setenv("TERM", "dumb")
    monkeypatch.setattr("click.testing._NamedTextIOWrapper.isatty", lambda _: True, raising=False)
    assert run(watch, "--at", server(documents[1]), "--looks", "2").startswith("active: system 1, disarmed | ")


def test_a_number_that_rounds_to_zero_has_no_sign_and_a_heading_is_below_360():
    assert [state_text.number(one, 1, "+") for one in (-0.04, 0.04, -0.06, None)] == ["+0.0", "+0.0", "-0.1", "-"]
    attitude = {"roll_deg": 0.0, "pitch_deg": 0.0, "yaw_deg": 359.97, "received_s": 0.0}
    assert state_text.attitude_line({"now_s": 0.0}, "ours", attitude).text.endswith("heading   0.0")


def test_lengths_of_time_are_told_in_units_that_people_read():
    assert [state_text.duration(one) for one in (4.4, 99.0, 100.0, 5999.0, 33000.0)] == [
        "4 s",
        "99 s",
        "2 min",
        "100 min",
        "9.2 h",
    ]


def test_an_undecided_verdict_is_explained_in_words(server, documents):
    lines = run(status, "--at", server(documents[2])).splitlines()
    place = next(place for place, line in enumerate(lines) if " undecided (no-reference), for " in line)
    assert lines[place + 1].startswith("  the autopilot's attitudes have stopped")
