"""The rates that ground stations ask for: the verdict does not flap, and no honest autopilot is accused."""

import pytest

from attest_mav.estimation.events import Agreement
from attest_mav.sim.settings import SimSettings


@pytest.mark.parametrize("hz", [1, 2, 4])
@pytest.mark.parametrize("scenario", ["still", "hover"])
def test_at_slow_rates_at_most_two_verdicts_a_minute_are_told(flight, hz, scenario):
    text = f"[streams]\nimu_hz = {hz}\nattitude_hz = {hz}\naiding_hz = {hz}\n"
    f = flight(text, SimSettings(scenario=scenario, fast_rate_hz=float(hz)))
    f.run_until(120.0)
    told = [line for line in f.texts if line.startswith("verdict:")]
    assert 1 <= len(told) <= 4
    assert not [line for line in told if "DISAGREES" in line]
    assert f.snapshot().verdict.verdict.agreement != Agreement.DISAGREE
