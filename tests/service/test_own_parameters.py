"""Parameters set over MAVLink take effect in the service, are shown, and survive a restart."""

import hashlib

import pytest
from pymavlink.dialects.v20 import ardupilotmega as mavlink

from attest_mav.service.kept_state import KeptState, parse_state, state_text

KEY = hashlib.sha256(b"ours").digest()
REAL32 = mavlink.MAV_PARAM_TYPE_REAL32


def station(key=None):
    sender = mavlink.MAVLink(None, srcSystem=255, srcComponent=190)
    if key is not None:
        sender.signing.secret_key, sender.signing.sign_outgoing = key, True
    return sender


def set_to(f, name, value, sender=None):
    message = mavlink.MAVLink_param_set_message(1, 193, name, value, REAL32)
    f.service.receive(0, message.pack(sender or station()), f.now_ns)
    f.run_until(f.now_ns * 1e-9 + 0.1)
    return [one.param_value for one in f.of_type("PARAM_VALUE") if one.param_id == name.decode()]


def test_the_rate_is_that_of_the_parameter(flight):
    f = flight("parameters = true")
    f.run_until(8.0)
    assert set_to(f, b"ATT_RATE", 5.0) == [5.0]
    f.run_until(12.1)
    assert 15 <= len(f.of_type("ATTITUDE_QUATERNION", 9.0, 12.0)) <= 16
    assert "ATT_RATE 5 set by 255/190 on udpin::0" in f.status()


def test_thresholds_reach_publishing_and_verdict(flight):
    f = flight("parameters = true")
    f.run_until(8.0)
    assert f.of_type("ATTITUDE_QUATERNION", 7.0)
    set_to(f, b"ATT_MAX_SIG", 0.01)
    set_to(f, b"ATT_TILT_LIM", 1.5)
    set_to(f, b"ATT_HOLD", 9.0)
    f.run_until(10.0)
    assert "tilt sigma" in f.snapshot().withheld
    assert "over 0.01 deg" in f.snapshot().withheld
    assert f.of_type("ATTITUDE_QUATERNION", 9.0) == []
    judge = f.service._pipeline._check.judge
    assert judge._settings.tilt == judge._settings.proven_tilt == pytest.approx(0.0261799, rel=1e-5)
    assert judge._settings.hold_s == 9.0
    assert judge._settings.stale_s == 1.0, "what is no parameter stays"


def test_what_was_set_survives_a_restart_with_its_sender(flight):
    f = flight("parameters = true\n[output]\nrate_hz = 10")
    f.run_until(2.0)
    set_to(f, b"ATT_RATE", 2.0)
    kept = parse_state(state_text(f.service.persistence.state))
    again = flight("parameters = true\n[output]\nrate_hz = 10")
    again.service.persistence.restore(kept, 0, 0)
    again.run_until(12.0)
    assert 3 <= len(again.of_type("ATTITUDE_QUATERNION", 10.0)) <= 5
    assert "ATT_RATE is 2, set by 255/190 on udpin::0; the configuration says 10" in again.texts


def test_a_kept_state_of_a_foreign_hand_is_bounded(flight):
    text = b'{"parameters": {"ATT_RATE": {"value": 1e300, "by": "x"}, "NONE": {"value": 1, "by": "y"}}}'
    f = flight("parameters = true")
    f.service.persistence.restore(parse_state(text), 0, 0)
    assert list(f.service.persistence.state.parameters) == ["ATT_RATE"]
    assert f.service.persistence.state.parameters["ATT_RATE"].value == 1000.0


def test_on_a_link_that_signs_only_signed_commands_set_anything(flight):
    f = flight('parameters = true\nsigning = "sign"\nkey_file = "k"', keys={"k": KEY})
    f.service.persistence.restore(KeptState(), 0, 0)
    f.run_until(2.0)
    assert set_to(f, b"ATT_RATE", 4.0) == [20.0]
    assert "udpin::0: 255/190 may not set ATT_RATE: the command is not signed" in f.texts
    signer = station(KEY)
    signer.signing.timestamp = 1000 * 100_000
    assert set_to(f, b"ATT_RATE", 4.0, signer) == [20.0, 4.0]


def test_kept_values_do_not_count_where_no_link_has_parameters(flight):
    f = flight()
    f.service.persistence.restore(parse_state(b'{"parameters": {"ATT_RATE": {"value": 1, "by": "x"}}}'), 0, 0)
    assert f.service.persistence.state.parameters == {}
    assert f.snapshot().own_parameters == ()
