"""The fake autopilot on a real link, faster than real time."""

import socket
import time

import numpy as np
import pytest
from pymavlink.dialects.v20 import ardupilotmega as mavlink

from attest_mav.config.link_url import parse_link
from attest_mav.runtime.links.open import open_link
from attest_mav.runtime.vehicle_host import VehicleHost
from attest_mav.sim.autopilot import FakeAutopilot
from attest_mav.sim.settings import SimSettings

SPEED = 20.0
DURATION_NS = 3_000_000_000


@pytest.fixture
def link(peer):
    link = open_link(parse_link(f"udpout:127.0.0.1:{peer.getsockname()[1]}"), 0)
    yield link
    link.close()


def fly(link, duration_ns, stopped=False):
    host = VehicleHost(FakeAutopilot(SimSettings(scenario="still", fast_rate_hz=50.0), 1), link, duration_ns, SPEED)
    stop, signal = socket.socketpair()
    with stop, signal:
        if stopped:
            signal.send(b"x")
        host.run(stop)


def test_it_flies_for_the_simulated_time_and_ends(peer, heard, link):
    began_s = time.monotonic()
    fly(link, DURATION_NS)
    assert time.monotonic() - began_s >= DURATION_NS * 1e-9 / SPEED
    messages = heard(peer)
    assert [one.get_type() for one in messages].count("HEARTBEAT") == pytest.approx(3, abs=1)
    times_us = [one.time_usec for one in messages if one.get_type() == "RAW_IMU"]
    assert len(times_us) == pytest.approx(150, abs=2)
    assert times_us == sorted(times_us)
    assert times_us[-1] == pytest.approx(3e6, abs=4e4)


def test_it_answers_on_its_link(peer, heard, link):
    sender = mavlink.MAVLink(None, srcSystem=255, srcComponent=190)
    command = mavlink.MAVLink_command_long_message(
        1, 1, mavlink.MAV_CMD_SET_MESSAGE_INTERVAL, 0, 27, 1e5, 0, 0, 0, 0, 0
    )
    peer.sendto(command.pack(sender), link.socket.getsockname())
    fly(link, DURATION_NS)
    messages = heard(peer)
    (answer,) = [one for one in messages if one.get_type() == "COMMAND_ACK"]
    assert (answer.command, answer.result) == (mavlink.MAV_CMD_SET_MESSAGE_INTERVAL, mavlink.MAV_RESULT_ACCEPTED)
    after = messages[messages.index(answer) :]
    times_us = [one.time_usec for one in after if one.get_type() == "RAW_IMU"]
    assert len(times_us) > 10
    assert np.diff(times_us[1:]) == pytest.approx(1e5, abs=2e4), "ten a second from the answer on"


def test_the_stop_signal_ends_it_before_its_time(peer, heard, link):
    fly(link, None, stopped=True)
    assert len(heard(peer)) < 5
