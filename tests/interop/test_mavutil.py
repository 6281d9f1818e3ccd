"""pymavlink's mavutil as an old client: MAVLink 1 until told otherwise, and with no idea of companions."""

import pytest

from .conftest import PATIENCE_S

LISTENING = r"listening on udpin:127\.0\.0\.1:(\d+)"


@pytest.fixture
def connect(monkeypatch):
    """Opens a connection of mavutil with this version of MAVLink; it is closed in the end."""
    opened = []

    def make(port, version):
        monkeypatch.setenv("MAVLINK20", "1") if version == "2" else monkeypatch.delenv("MAVLINK20", raising=False)
        from pymavlink import mavutil  # noqa: PLC0415  # it reads the environment

        mavutil.set_dialect("ardupilotmega")
        opened.append(mavutil.mavlink_connection(f"udpout:127.0.0.1:{port}", source_system=255))
        return opened[-1]

    yield make
    for one in opened:
        one.close()


@pytest.mark.parametrize("version", ["1", "2"])
def test_an_old_client_hears_us_and_its_commands_are_answered(start, connect, version):
    daemon = start("run", "--link", "sim:still", "--link", "udpin:127.0.0.1:0")
    client = connect(daemon.wait_for(LISTENING)[1], version)
    daemon.wait_for("the first estimate is there")
    assert client.mav.protocol_marker == (253 if version == "2" else 254)
    client.mav.heartbeat_send(6, 8, 0, 0, 4)
    beat = client.wait_heartbeat(timeout=PATIENCE_S)
    assert (beat.get_srcSystem(), beat.get_srcComponent(), beat.type, beat.autopilot) == (1, 193, 18, 8)
    client.mav.command_long_send(1, 193, 511, 0, 31, 100_000, 0, 0, 0, 0, 0)
    ack = client.recv_match(type="COMMAND_ACK", blocking=True, timeout=PATIENCE_S)
    assert (ack.command, ack.result) == (511, 0)
    attitude = client.recv_match(type="ATTITUDE_QUATERNION", blocking=True, timeout=PATIENCE_S)
    assert sum(q * q for q in (attitude.q1, attitude.q2, attitude.q3, attitude.q4)) == pytest.approx(1.0, abs=1e-5)
    client.mav.command_long_send(1, 193, 400, 0, 1, 0, 0, 0, 0, 0, 0)
    ack = client.recv_match(type="COMMAND_ACK", blocking=True, timeout=PATIENCE_S)
    assert (ack.command, ack.result) == (400, 3), "arming is not ours: unsupported"
    assert daemon.end() == 0
