import subprocess
import sys

import pytest
from pymavlink import mavextra

from attest_mav.earth_field import SECONDS_PER_YEAR, field_at, simulated_field_at


def unix_s(year):
    return (year - 1970.0) * SECONDS_PER_YEAR


@pytest.mark.parametrize(
    ("latitude", "longitude", "altitude_m", "year", "expected"),
    [
        # Published test values of the models: WMM2015v2, WMM2020, WMM2025.
        (80.0, 0.0, 0.0, 2015.0, -3.90),
        (80.0, 0.0, 0.0, 2020.0, -1.28),
        (0.0, 120.0, 0.0, 2020.0, 0.16),
        (-80.0, 240.0, 0.0, 2020.0, 69.36),
        (80.0, 0.0, 100_000.0, 2020.0, -1.70),
    ],
)
def test_published_values(latitude, longitude, altitude_m, year, expected):
    found = field_at(latitude, longitude, altitude_m, unix_s(year))
    assert found.declination_deg == pytest.approx(expected, abs=0.05)


@pytest.mark.parametrize(
    ("year", "model", "remark"),
    [
        (1970.0, "WMM-2025", "clock says 1970"),
        (2007.0, "WMM-2010", "oldest model"),
        (2018.6, "WMM-2015v2", ""),
        (2029.5, "WMM-2025", ""),
        (2040.0, "WMM-2025", "newest model ends"),
    ],
)
def test_every_date_is_answered_and_a_poor_match_is_admitted(year, model, remark):
    found = field_at(51.873, 0.171, 50.0, unix_s(year))
    assert found.source.startswith(model)
    assert remark in found.source
    assert remark or "(" not in found.source


def test_the_dip_is_that_of_the_published_test_values():
    # WMM2020: near the equator and towards either pole.
    assert field_at(0.0, 120.0, 0.0, unix_s(2020.0)).inclination_deg == pytest.approx(-15.42, abs=0.05)
    assert field_at(80.0, 0.0, 0.0, unix_s(2020.0)).inclination_deg == pytest.approx(83.14, abs=0.05)
    assert field_at(-80.0, 240.0, 0.0, unix_s(2020.0)).inclination_deg == pytest.approx(-72.20, abs=0.05)


def test_the_poles_have_an_answer():
    for latitude in (90.0, -90.0):
        assert -180.0 <= field_at(latitude, 0.0, 0.0, unix_s(2024.0)).declination_deg <= 180.0


def test_the_simulators_table_is_pymavlinks():
    for place in ((51.873, 0.171), (-35.36, 149.17), (0.0, 0.0), (59.9, 179.9)):
        found, expected = simulated_field_at(*place), mavextra.get_mag_field_ef(*place)
        assert (found.declination_deg, found.inclination_deg) == tuple(expected[:2])
    assert simulated_field_at(90.0, 0.0) is None


WITHOUT_NUMPY = """
import sys
from attest_mav.earth_field import simulated_field_at

assert simulated_field_at(51.873, 0.171) is not None
assert "numpy" not in sys.modules
from pymavlink.mavextra import Quaternion
"""


def test_the_simulators_table_loads_no_numpy_and_leaves_pymavlink_whole():
    subprocess.run([sys.executable, "-P", "-c", WITHOUT_NUMPY], check=True)
