"""What is configured reaches the parts, in their own units."""

from math import isnan, radians

import pytest

from attest_mav.config.parsing import parse_config
from attest_mav.config.records import Config
from attest_mav.service.assembly import service_settings


def settings_of(text):
    return service_settings(parse_config(text, "test"))


def test_the_numbers_of_the_verdict_become_radians_and_one_threshold_stands_for_both():
    verdict = settings_of(
        "[verdict]\ntilt_deg = 4\nmax_sigma_deg = 1\nhold_s = 2\nrelease = 0.5\nstale_s = 3"
    ).pipeline.verdict
    assert verdict.tilt == verdict.proven_tilt == pytest.approx(radians(4.0))
    assert verdict.max_sigma == pytest.approx(radians(1.0))
    assert (verdict.hold_s, verdict.release, verdict.stale_s) == (2.0, 0.5, 3.0)


def test_left_to_itself_the_verdict_is_stricter_beside_a_sigma_that_holds():
    verdict = settings_of("").pipeline.verdict
    assert (verdict.tilt, verdict.proven_tilt) == pytest.approx((radians(10.0), radians(3.0)))


def test_a_declination_is_in_radians_and_none_is_not_a_number():
    assert settings_of("[estimate]\ndeclination_deg = -90").declination == pytest.approx(radians(-90.0))
    assert isnan(settings_of("").declination)


def test_raw_readings_have_scales_where_they_are_configured():
    assert service_settings(Config()).raw_scales is None
    scales = settings_of("[raw_imu]\naccel_mps2 = 0.01\ngyro_radps = 0.001").raw_scales
    assert (scales.accel, scales.gyro, scales.mag) == (0.01, 0.001, 0.0)


def test_each_link_has_its_own_outputs():
    plain = "[[link]]\nurl = 'sim:'\n"
    quiet = f"{plain}publish = ['named_values', 'attitude_quaternion_cov']\nyield_to_onboard = false"
    first, second = settings_of(plain + quiet).ports
    assert (first.publish, first.yields) == (("attitude_quaternion", "statustext"), True)
    assert (set(second.publish), second.yields) == ({"named_values", "attitude_quaternion_cov"}, False)


@pytest.mark.parametrize(
    ("aiding", "asked"),
    [
        ("", ()),
        ("velocity = 'GLOBAL_POSITION_INT'", ("GLOBAL_POSITION_INT",)),
        (
            "velocity = 'GLOBAL_POSITION_INT'\nforward_speed = 'LOCAL_POSITION_NED'",
            ("GLOBAL_POSITION_INT", "LOCAL_POSITION_NED"),
        ),
    ],
)
def test_positions_of_the_autopilots_filter_are_asked_for_only_as_aids(aiding, asked):
    settings = settings_of(f"[aiding]\n{aiding}")
    assert settings.companion.data.positions == asked


def test_nothing_is_restored_that_was_not_asked_for():
    assert not settings_of("[streams]\nrequest = false\nrestore = true").companion.data.restores
    assert settings_of("[streams]\nrestore = true").companion.data.restores
