"""Other settings while the service works: the filter goes on from where it is."""

from math import radians

import pytest

from attest_mav.config.parsing import parse_config
from attest_mav.service.assembly import service_settings

from .test_own_parameters import set_to

LINK = "[[link]]\nurl = 'udpin::0'\n"


def settings(text, link=""):
    return service_settings(parse_config(f"{LINK}{link}{text}", "test"))


def test_rate_outputs_and_thresholds_take_effect_and_the_filter_goes_on(flight):
    f = flight()
    f.run_until(8.0)
    f.service.use(
        settings(
            "[output]\nrate_hz = 5\n[verdict]\ntilt_deg = 4\nhold_s = 2\n",
            "publish = ['attitude_quaternion', 'named_values']\n",
        )
    )
    f.run_until(12.1)
    assert 15 <= len(f.of_type("ATTITUDE_QUATERNION", 9.0, 12.0)) <= 16
    assert len(f.of_type("NAMED_VALUE_FLOAT", 0.0, 8.0)) == 0
    assert len(f.of_type("NAMED_VALUE_FLOAT", 8.0, 12.1)) >= 6
    assert not any("aligned" in text for text in f.texts if "using" not in text and "has found" not in text)
    judge = f.service._pipeline._check.judge
    assert judge._settings.tilt == pytest.approx(radians(4.0))
    assert judge._settings.hold_s == 2.0
    assert f.snapshot().lanes[0].restarts == 0


def test_an_output_can_be_withdrawn_and_a_limit_set(flight):
    f = flight()
    f.run_until(8.0)
    f.service.use(settings("[output]\nmax_sigma_deg = 0.01\n"))
    f.run_until(9.0)
    assert "over 0.01 deg" in f.snapshot().withheld
    f.service.use(settings("", "publish = []\n"))
    f.run_until(12.0)
    assert f.of_type("ATTITUDE_QUATERNION", 9.0) == []


def test_gains_change_in_the_running_filter(flight):
    f = flight("[filter]\nname = 'gradient-descent'\n")
    f.run_until(4.0)
    before = f.service._pipeline.lanes["RAW_IMU"]._run.state
    f.service.use(settings("[filter]\nname = 'gradient-descent'\n[filter.gradient-descent]\nbeta = 0.2\n"))
    run = f.service._pipeline.lanes["RAW_IMU"]._run
    assert run.state is before
    assert run.filter.beta == 0.2
    f.run_until(5.0)
    assert run.state is not before


def test_what_a_station_has_set_stays(flight):
    f = flight("parameters = true")
    f.run_until(6.0)
    assert set_to(f, b"ATT_RATE", 2.0) == [2.0]
    f.service.use(settings("[output]\nrate_hz = 10\nmax_sigma_deg = 2.5\n", "parameters = true\n"))
    f.run_until(7.0)
    assert f.service._tuning.pipeline.max_sigma == pytest.approx(radians(2.5))
    f.run_until(10.1)
    assert 5 <= len(f.of_type("ATTITUDE_QUATERNION", 7.0, 10.0)) <= 7
