import pytest

from attest_mav.errors import ConfigError
from attest_mav.mavlink.companion import CompanionSettings
from attest_mav.mavlink.lock_on import LockOn

SECOND = 1_000_000_000
COPTER, GCS, CAMERA, ONBOARD = 2, 6, 30, 18
ARDUPILOT, GENERIC, INVALID = 3, 0, 8


@pytest.mark.parametrize(
    ("vehicle_type", "autopilot"), [(CAMERA, INVALID), (ONBOARD, INVALID), (GCS, INVALID), (GCS, GENERIC)]
)
def test_what_is_no_autopilot_is_not_taken(notebook, vehicle_type, autopilot):
    lock = LockOn(0, notebook)
    assert not lock.heartbeat(0, 255, 190, vehicle_type, autopilot, 0)
    assert lock.vehicle is None
    assert lock.next_deadline_ns is None


def test_the_first_autopilot_is_taken(notebook):
    lock = LockOn(0, notebook)
    assert lock.heartbeat(3, 7, 1, COPTER, ARDUPILOT, 0)
    assert (lock.vehicle.system, lock.vehicle.component, lock.vehicle.link) == (7, 1, 3)
    assert lock.present
    assert not lock.heartbeat(3, 7, 1, COPTER, ARDUPILOT, SECOND), "it is known already"


def test_a_second_vehicle_at_the_start_is_an_error_that_says_what_to_do(notebook):
    lock = LockOn(0, notebook)
    lock.heartbeat(0, 1, 1, COPTER, ARDUPILOT, 0)
    with pytest.raises(ConfigError, match=r"systems 1 and 2: .*system_id under \[vehicle\]"):
        lock.heartbeat(0, 2, 1, COPTER, ARDUPILOT, SECOND)


def test_a_second_vehicle_in_flight_is_reported_once(notebook):
    lock = LockOn(0, notebook)
    lock.heartbeat(0, 1, 1, COPTER, ARDUPILOT, 0)
    notebook.take()
    for t_s in (10, 11):
        assert not lock.heartbeat(0, 2, 1, COPTER, ARDUPILOT, t_s * SECOND)
    assert lock.vehicle.system == 1
    assert [note.text for note in notebook.take()] == [
        "another vehicle, system 2, is on the links; only system 1 is used"
    ]


def test_a_named_vehicle_is_the_only_one_taken(notebook):
    lock = LockOn(2, notebook)
    assert not lock.heartbeat(0, 1, 1, COPTER, ARDUPILOT, 0)
    assert lock.heartbeat(0, 2, 1, COPTER, ARDUPILOT, 1)
    assert not lock.heartbeat(0, 1, 1, COPTER, ARDUPILOT, 2), "no error: the configuration has named one"
    assert lock.vehicle.system == 2


def test_silence_is_noticed_and_ends(notebook):
    lock = LockOn(0, notebook)
    lock.heartbeat(0, 1, 1, COPTER, ARDUPILOT, 0)
    due_ns = lock.next_deadline_ns
    lock.poll(due_ns - 1)
    assert lock.present
    lock.poll(due_ns)
    assert not lock.present
    assert lock.heartbeat(0, 1, 1, COPTER, ARDUPILOT, 9 * SECOND), "found again"
    assert lock.present


def test_a_silent_vehicle_is_taken_up_on_another_link(notebook):
    lock = LockOn(0, notebook)
    lock.heartbeat(0, 1, 1, COPTER, ARDUPILOT, 0)
    assert not lock.heartbeat(1, 1, 1, COPTER, ARDUPILOT, 1), "the first link works"
    lock.poll(lock.next_deadline_ns)
    assert lock.heartbeat(1, 1, 1, COPTER, ARDUPILOT, 9 * SECOND)
    assert lock.vehicle.link == 1


def test_a_broken_link_asks_for_a_fresh_heartbeat(notebook):
    lock = LockOn(0, notebook)
    lock.heartbeat(0, 1, 1, COPTER, ARDUPILOT, 0)
    lock.link_broken(1)
    assert lock.present
    lock.link_broken(0)
    assert not lock.present
    assert lock.heartbeat(0, 1, 1, COPTER, ARDUPILOT, 1)


def test_component_1_is_preferred_to_another_autopilot_of_the_system(notebook):
    lock = LockOn(0, notebook)
    lock.heartbeat(0, 1, 140, COPTER, ARDUPILOT, 0)
    assert lock.heartbeat(0, 1, 1, COPTER, ARDUPILOT, 1)
    assert lock.vehicle.component == 1
    assert not lock.heartbeat(0, 1, 140, COPTER, ARDUPILOT, 2)


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
