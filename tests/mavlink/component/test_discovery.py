import pytest

from attest_mav.mavlink.component.companion_settings import CompanionSettings
from attest_mav.mavlink.component.discovery import VehicleDiscovery

SECOND = 1_000_000_000
COPTER, TRACKER, GCS, CAMERA, ONBOARD, ADSB = 2, 5, 6, 30, 18, 27
ARDUPILOT, GENERIC, INVALID = 3, 0, 8


@pytest.mark.parametrize(
    ("vehicle_type", "autopilot"),
    [(CAMERA, INVALID), (ONBOARD, INVALID), (GCS, INVALID), (GCS, GENERIC), (CAMERA, GENERIC), (COPTER, INVALID)],
)
def test_what_is_no_autopilot_is_not_taken(notebook, vehicle_type, autopilot):
    discovery = VehicleDiscovery(0, notebook)
    assert not discovery.heartbeat(0, 255, 190, vehicle_type, autopilot, 0)
    assert discovery.vehicle is None
    assert discovery.next_deadline_ns is None


def test_the_first_autopilot_is_taken(notebook):
    discovery = VehicleDiscovery(0, notebook)
    assert discovery.heartbeat(3, 7, 1, COPTER, ARDUPILOT, 0)
    assert (discovery.vehicle.system, discovery.vehicle.component, discovery.vehicle.link) == (7, 1, 3)
    assert discovery.present
    assert not discovery.heartbeat(3, 7, 1, COPTER, ARDUPILOT, SECOND), "it is known already"


def two_at_the_start(notebook, until_s):
    """Systems 1 and 2 from the start, once a second."""
    discovery = VehicleDiscovery(0, notebook)
    for t_s in range(until_s):
        discovery.heartbeat(0, 1, 1, COPTER, ARDUPILOT, t_s * SECOND)
        discovery.heartbeat(0, 2, 1, COPTER, ARDUPILOT, t_s * SECOND + SECOND // 2)
    return discovery


def test_of_two_vehicles_at_the_start_none_is_taken_and_that_is_said_now_and_then(notebook):
    discovery = two_at_the_start(notebook, 100)
    assert discovery.vehicle is None
    assert not discovery.present
    said = "several vehicles, systems 1 and 2: name one with system_id under [vehicle]"
    assert discovery.ambiguity == said
    errors = [note.text for note in notebook.take() if note.level == 40]
    assert errors == [f"{said} in the configuration; nothing is sent until one is left"] * 2


def test_when_one_of_two_vehicles_goes_the_other_is_taken(notebook):
    discovery = two_at_the_start(notebook, 10)
    taken_s = next(t_s for t_s in range(10, 20) if discovery.heartbeat(0, 2, 1, COPTER, ARDUPILOT, t_s * SECOND))
    assert taken_s == 13, "system 1 was heard at 9 s"
    assert (discovery.vehicle.system, discovery.ambiguity) == (2, "")


def test_when_both_vehicles_go_nothing_is_said_to_be_there(notebook):
    discovery = two_at_the_start(notebook, 10)
    discovery.poll(14 * SECOND)
    assert discovery.ambiguity == ""


@pytest.mark.parametrize("vehicle_type", [CAMERA, ADSB, TRACKER, ONBOARD])
def test_what_is_no_vehicle_is_no_second_one(notebook, vehicle_type):
    discovery = VehicleDiscovery(0, notebook)
    assert not discovery.heartbeat(0, 42, 1, vehicle_type, GENERIC, 0)
    assert discovery.heartbeat(0, 1, 1, COPTER, ARDUPILOT, 1)
    discovery.heartbeat(0, 42, 1, vehicle_type, GENERIC, SECOND)
    assert discovery.vehicle.system == 1


def test_what_is_named_is_taken_whatever_it_calls_itself(notebook):
    discovery = VehicleDiscovery(42, notebook)
    assert not discovery.heartbeat(0, 42, 100, CAMERA, GENERIC, 0)
    assert discovery.heartbeat(0, 42, 1, TRACKER, ARDUPILOT, 0)


def test_a_claim_without_component_1_is_no_match_for_one_with_it(notebook):
    discovery = VehicleDiscovery(0, notebook)
    discovery.heartbeat(0, 42, 140, COPTER, GENERIC, 0)
    assert discovery.heartbeat(0, 1, 1, COPTER, ARDUPILOT, SECOND)
    discovery.heartbeat(0, 42, 140, COPTER, GENERIC, 2 * SECOND)
    assert discovery.vehicle.system == 1


def test_a_second_vehicle_in_flight_is_reported_once(notebook):
    discovery = VehicleDiscovery(0, notebook)
    discovery.heartbeat(0, 1, 1, COPTER, ARDUPILOT, 0)
    notebook.take()
    for t_s in (10, 11):
        assert not discovery.heartbeat(0, 2, 1, COPTER, ARDUPILOT, t_s * SECOND)
    assert discovery.vehicle.system == 1
    assert [note.text for note in notebook.take()] == [
        "another vehicle, system 2, is on the links; only system 1 is used"
    ]


def test_a_named_vehicle_is_the_only_one_taken(notebook):
    discovery = VehicleDiscovery(2, notebook)
    assert not discovery.heartbeat(0, 1, 1, COPTER, ARDUPILOT, 0)
    assert discovery.heartbeat(0, 2, 1, COPTER, ARDUPILOT, 1)
    assert not discovery.heartbeat(0, 1, 1, COPTER, ARDUPILOT, 2), "no error: the configuration has named one"
    assert discovery.vehicle.system == 2


def test_silence_is_noticed_and_ends(notebook):
    discovery = VehicleDiscovery(0, notebook)
    discovery.heartbeat(0, 1, 1, COPTER, ARDUPILOT, 0)
    due_ns = discovery.next_deadline_ns
    discovery.poll(due_ns - 1)
    assert discovery.present
    discovery.poll(due_ns)
    assert not discovery.present
    assert discovery.heartbeat(0, 1, 1, COPTER, ARDUPILOT, 9 * SECOND), "found again"
    assert discovery.present


def test_a_silent_vehicle_is_taken_up_on_another_link(notebook):
    discovery = VehicleDiscovery(0, notebook)
    discovery.heartbeat(0, 1, 1, COPTER, ARDUPILOT, 0)
    assert not discovery.heartbeat(1, 1, 1, COPTER, ARDUPILOT, 1), "the first link works"
    discovery.poll(discovery.next_deadline_ns)
    assert discovery.heartbeat(1, 1, 1, COPTER, ARDUPILOT, 9 * SECOND)
    assert discovery.vehicle.link == 1


def test_a_broken_link_asks_for_a_fresh_heartbeat(notebook):
    discovery = VehicleDiscovery(0, notebook)
    discovery.heartbeat(0, 1, 1, COPTER, ARDUPILOT, 0)
    discovery.link_broken(1)
    assert discovery.present
    discovery.link_broken(0)
    assert not discovery.present
    assert discovery.heartbeat(0, 1, 1, COPTER, ARDUPILOT, 1)


def other_component(discovery, from_s, to_s, link=0):
    """When component 140 was taken for the vehicle, None if never; it sends every second."""
    seconds = range(from_s, to_s)
    return next((t for t in seconds if discovery.heartbeat(link, 1, 140, COPTER, GENERIC, t * SECOND)), None)


def test_another_component_is_believed_once_component_1_was_waited_for(notebook):
    discovery = VehicleDiscovery(0, notebook)
    assert other_component(discovery, 0, 10) == 3
    assert discovery.vehicle.component == 140


@pytest.mark.parametrize("link", [0, 1])
def test_component_1_takes_over_from_another_on_any_link(notebook, link):
    discovery = VehicleDiscovery(0, notebook)
    other_component(discovery, 0, 10)
    assert discovery.heartbeat(link, 1, 1, COPTER, ARDUPILOT, 10 * SECOND)
    assert (discovery.vehicle.component, discovery.vehicle.link) == (1, link)
    assert discovery.present


@pytest.mark.parametrize("link", [0, 1])
def test_nothing_takes_over_from_component_1_not_even_while_it_is_silent(notebook, link):
    discovery = VehicleDiscovery(0, notebook)
    discovery.heartbeat(0, 1, 1, COPTER, ARDUPILOT, 0)
    discovery.poll(discovery.next_deadline_ns)
    assert other_component(discovery, 4, 30, link) is None
    assert not discovery.present, "another component's heartbeats are not the autopilot's"
    assert discovery.heartbeat(0, 1, 1, COPTER, ARDUPILOT, 30 * SECOND)


def test_no_request_before_the_heartbeat_nor_after_a_break(bench):
    b = bench(CompanionSettings())
    b.run_until(5.0)
    assert b.interval_requests() == []
    b.vehicle_heartbeat()
    b.run_until(5.2)
    asked = len(b.interval_requests())
    assert asked > 0
    b.companion.link_broken(0)
    b.run_until(20.0)
    assert len(b.interval_requests()) == asked
