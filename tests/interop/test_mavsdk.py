"""A real MAVSDK client takes our ATTITUDE_QUATERNION: vehicle, daemon and client are three programs on UDP.

MAVSDK's telemetry takes the message from any component of the vehicle's system, so the client hangs on a link of the
daemon's own, on which nobody else speaks, and the raw messages must all come from our component.
"""

import json
import queue
from math import degrees

import pytest

from attest_mav.algebra import tilt_between
from attest_mav.sim.autopilot import FakeAutopilot
from attest_mav.sim.settings import SimSettings

mavsdk = pytest.importorskip("mavsdk", reason="mavsdk has no wheel for this machine")

from mavsdk.plugins.mavlink_direct import MavlinkDirect  # noqa: E402  (after the check)
from mavsdk.plugins.telemetry import Telemetry  # noqa: E402

PATIENCE_S = 30.0
LISTENING = r"listening on udpin:127\.0\.0\.1:(\d+)"
SEED = 3


@pytest.fixture
def ground_station():
    """A MAVSDK ground station; it is taken down in the end, with its threads."""
    configuration = mavsdk.Configuration.create_with_component_type(mavsdk.ComponentType.GROUND_STATION)
    client = mavsdk.Mavsdk(configuration)
    yield client
    client.destroy()
    configuration.destroy()


def wait_for_system(client):
    found = queue.Queue()
    client.subscribe_on_new_system(lambda _: found.put(True))
    systems = client.get_systems()
    if not systems:
        found.get(timeout=PATIENCE_S)
        systems = client.get_systems()
    return systems[0]


def take(messages, count):
    return [messages.get(timeout=PATIENCE_S) for _ in range(count)]


def test_mavsdk_receives_our_attitude(start, ground_station):
    daemon = start("run", "--link", "udpin:127.0.0.1:0", "--link", "udpin:127.0.0.1:0")
    vehicle_port, client_port = daemon.wait_for(LISTENING)[1], daemon.wait_for(LISTENING)[1]
    start("sim", "--link", f"udpout:127.0.0.1:{vehicle_port}", "--scenario", "still", "--seed", str(SEED))
    daemon.wait_for("the first estimate is there")

    result = ground_station.add_any_connection(f"udpout://127.0.0.1:{client_port}")
    assert result == mavsdk.ConnectionResult.SUCCESS
    system = wait_for_system(ground_station)
    attitudes, raw = queue.Queue(), queue.Queue()
    telemetry, direct = Telemetry(system), MavlinkDirect(system)
    telemetry.subscribe_attitude_quaternion(lambda q, _: attitudes.put(q))
    direct.subscribe_message("ATTITUDE_QUATERNION", lambda message, _: raw.put(message))
    got, sent = take(attitudes, 60), take(raw, 60)

    assert {(message.system_id, message.component_id) for message in sent} == {(1, 193)}
    times_ms = {json.loads(message.fields_json)["time_boot_ms"] for message in sent}
    ours = [q for q in got if q.timestamp_us // 1000 in times_ms]
    assert len(ours) >= 40, "what telemetry shows is what the component sent"
    rate_hz = (len(got) - 1) * 1e6 / (got[-1].timestamp_us - got[0].timestamp_us)
    assert rate_hz == pytest.approx(20.0, abs=1.0), "as configured"

    vehicle = FakeAutopilot(SimSettings(scenario="still"), SEED)
    for q in got:
        truth = vehicle.truth(q.timestamp_us * 1000).q_nb
        assert degrees(tilt_between(truth, (q.w, q.x, q.y, q.z))) < 1.5
    assert daemon.end() == 0


def shared_link(start, hub, tmp_path, extra=""):
    """A daemon and a vehicle on one hub; the daemon is settled when the ground station of the caller is heard."""
    config = tmp_path / "shared.toml"
    config.write_text(f"[[link]]\nurl = 'udpout:127.0.0.1:{hub.port}'\n{extra}[log]\nstatus_s = 0.5\n")
    daemon = start("run", "--config", str(config))
    start("sim", "--link", f"udpout:127.0.0.1:{hub.port}", "--scenario", "still", "--seed", str(SEED))
    daemon.wait_for("the first estimate is there")
    return daemon


@pytest.mark.parametrize(("extra", "is_ours"), [("", False), ("yield_to_stations = false\n", True)])
def test_on_a_shared_link_our_attitude_takes_no_place_unless_configured(
    start, hub, tmp_path, ground_station, extra, is_ours
):
    result = ground_station.add_any_connection(f"udpout://127.0.0.1:{hub.port}")
    assert result == mavsdk.ConnectionResult.SUCCESS
    daemon = shared_link(start, hub, tmp_path, extra)
    system = wait_for_system(ground_station)
    daemon.wait_for("sent 20|sent 19" if is_ours else "held back on udpout")
    direct, telemetry = MavlinkDirect(system), Telemetry(system)
    euler, quaternions, harmless = queue.Queue(), queue.Queue(), queue.Queue()
    telemetry.subscribe_attitude_quaternion(lambda q, _: quaternions.put(q))
    direct.subscribe_message("ATTITUDE", lambda message, _: euler.put(message))
    direct.subscribe_message("ATTITUDE_QUATERNION_COV", lambda message, _: harmless.put(message))
    assert {message.component_id for message in take(euler, 30)} == {1}, "the autopilot's own"
    if is_ours:
        take(quaternions, 20)
        assert harmless.empty()
    else:
        assert {message.component_id for message in take(harmless, 5)} == {193}
        assert quaternions.empty(), "telemetry shows nothing of ours"
    assert daemon.end() == 0
