"""Published means believed: what is withheld, in which form it still goes out, and what is told of it."""

import itertools
from math import nan, radians

import pytest

from attest_mav.estimate import Estimate
from attest_mav.mavlink.component.outputs import Confidence
from attest_mav.service.publication_gate import PublicationGate
from attest_mav.sim.fault_text import parse_faults
from attest_mav.sim.settings import SimSettings
from attest_mav.types import North

SECOND = 1_000_000_000
CALIBRATING, ACTIVE = 2, 4
WARNING, NOTICE = 4, 5
BOTH = "publish = ['attitude_quaternion', 'attitude_quaternion_cov', 'named_values', 'statustext']\n"
TWO_LANES = "[streams]\nfurther_imu_messages = ['SCALED_IMU2']\n"
GPS_RAW_INT = 24


def estimate(sigma_deg, q_nb=(1.0, 0.0, 0.0, 0.0)):
    sigma = radians(sigma_deg)
    return Estimate("RAW_IMU", "any", 0, 0, q_nb, (0.0, 0.0, 0.0), North.TRUE, sigma, sigma, 0.02)


class Gate:
    """A gate with a limit of 5 degrees, and its changes with their times (s)."""

    def __init__(self):
        self.gate = PublicationGate(radians(5.0))
        self.changes = []

    def run(self, begin_s, end_s, sigma_deg, contradicted=False):
        """Estimates at 10 Hz with a sigma, or a function of the time."""
        for step in range(round(10 * begin_s), round(10 * end_s)):
            sigma = sigma_deg(step / 10) if callable(sigma_deg) else sigma_deg
            change = self.gate.take(estimate(sigma), contradicted, step * SECOND // 10)
            if change is not None:
                self.changes.append((step / 10, change.opened, change.reason))


def test_the_first_believed_attitude_is_no_change():
    g = Gate()
    g.run(0, 1, 20.0)
    assert not g.gate.is_open
    g.run(1, 2, 4.9)
    assert g.gate.is_open
    assert g.changes == []


def test_a_sigma_above_the_limit_is_told_once_with_its_number():
    g = Gate()
    g.run(0, 1, 1.0)
    g.run(1, 5, 7.2)
    assert g.changes == [(2.0, False, "tilt sigma 7.2 over 5 deg")], "when it has lasted for a second"


def test_a_sigma_that_wavers_about_the_limit_does_not_flap():
    g = Gate()
    g.run(0, 1, 1.0)
    g.run(1, 30, lambda t_s: 5.5 if round(10 * t_s) % 2 else 4.5)
    assert [opened for _, opened, _ in g.changes] == [False]
    g.run(30, 35, 3.9)
    assert g.changes[1][:2] == (30.9, True), "a second after the last estimate above four fifths of the limit"
    assert len(g.changes) == 2


def test_a_contradiction_that_comes_and_goes_is_one_interruption():
    g = Gate()
    g.run(0, 1, 1.0)
    for begin in range(1, 10):
        g.run(begin, begin + 0.3, 1.0, contradicted=True)
        g.run(begin + 0.3, begin + 1, 1.0)
        assert not g.gate.is_open
    assert [change[:2] for change in g.changes] == [(2.0, False)]
    g.run(10, 12, 1.0)
    assert [opened for _, opened, _ in g.changes] == [False, True]


def test_a_contradiction_of_less_than_a_second_is_not_told():
    g = Gate()
    g.run(0, 1, 1.0)
    g.run(1, 1.8, 1.0, contradicted=True)
    assert not g.gate.is_open
    g.run(1.8, 5, 1.0)
    assert g.gate.is_open
    assert g.changes == []


def test_an_estimate_that_is_gone_is_told_at_once():
    g = Gate()
    assert g.gate.close("aligning", 0) is None, "nothing was published before"
    g.run(0, 1, 1.0)
    assert g.gate.close("samples stopped", SECOND).reason == "samples stopped"
    assert g.gate.close("aligning", 2 * SECOND) is None
    g.run(3, 5, 1.0)
    assert [change[:2] for change in g.changes] == [(3.0, True)]


def test_a_filter_without_a_sigma_has_no_limit():
    g = Gate()
    g.run(0, 1, nan)
    assert g.gate.is_open


@pytest.mark.parametrize(
    ("sigma_deg", "contradicted", "q_nb", "confidence"),
    [
        (1.0, False, (1.0, 0.0, 0.0, 0.0), Confidence.BELIEVED),
        (9.0, False, (1.0, 0.0, 0.0, 0.0), Confidence.UNCERTAIN),
        (1.0, True, (1.0, 0.0, 0.0, 0.0), Confidence.DOUBTED),
        (1.0, False, (nan, 0.0, 0.0, 0.0), Confidence.DOUBTED),
    ],
)
def test_how_far_an_estimate_is_believed(sigma_deg, contradicted, q_nb, confidence):
    gate = PublicationGate(radians(5.0))
    one = estimate(sigma_deg, q_nb)
    gate.take(one, contradicted, 0)
    assert gate.confidence(one, contradicted) == confidence


def sim(scenario, faults=()):
    return SimSettings(scenario=scenario, fast_rate_hz=50.0, faults=parse_faults(faults))


def announced(f, begin_s):
    """Severities and texts about publishing; chunks are joined."""
    texts = []
    for one in f.of_type("STATUSTEXT", begin_s):
        if one.chunk_seq:
            texts[-1] = (texts[-1][0], texts[-1][1] + one.text)
        else:
            texts.append((one.severity, one.text))
    return [one for one in texts if "attitude" in one[1]]


def test_an_uncertain_attitude_is_withheld_and_goes_on_with_its_covariance(flight):
    """Without fixes sigma grows beyond the limit; the limit is set where that happens soon."""
    f = flight(f"{BOTH}[output]\nmax_sigma_deg = 1.1\n", sim("hover"))
    f.run_until(20.0)
    f.deaf_to.add(GPS_RAW_INT)
    f.run_until(45.0)
    assert " | attitude withheld: tilt sigma " in f.status()
    f.deaf_to.clear()
    f.run_until(90.0)
    end_s = max(t_s for t_s, one in f.heard if one.get_type() == "ATTITUDE_QUATERNION" and t_s < 45.0)
    assert 21.0 < end_s < 40.0, "sigma passes the limit while there are no fixes"
    assert len(f.of_type("ATTITUDE_QUATERNION_COV", end_s, 45.0)) == pytest.approx(20 * (45.0 - end_s), abs=3)
    for one in f.of_type("ATTITUDE_QUATERNION_COV", end_s + 0.1, 45.0):
        assert one.covariance[0] > radians(0.56) ** 2, "above four fifths of the limit"
    assert {beat.system_status for beat in f.of_type("HEARTBEAT", end_s + 1.0, 45.0)} == {CALIBRATING}
    assert f.of_type("NAMED_VALUE_FLOAT", end_s + 1.0, 45.0), "the verdict is told all the same"
    assert f.of_type("ATTITUDE_QUATERNION", 85.0)
    assert f.of_type("HEARTBEAT")[-1].system_status == ACTIVE
    told = announced(f, 20.0)
    assert told[0] == (WARNING, "attest: attitude withheld: tilt sigma 1.1 over 1.1 deg")
    assert told[1][0] == NOTICE
    assert told[1][1].startswith("attest: attitude sent again after ")
    assert len(told) == 2
    assert [text.split(" ")[1] for text in f.texts if text.startswith("attitude ")][-2:] == ["withheld:", "sent"]


def test_a_contradicted_attitude_is_sent_in_no_form(flight):
    f = flight(f"{BOTH}{TWO_LANES}", sim("square", ["gyro1-bias-x=5@20+15"]))
    f.run_until(30.0)
    for name in ("ATTITUDE_QUATERNION", "ATTITUDE_QUATERNION_COV"):
        times = [t_s for t_s, one in f.heard if one.get_type() == name and 20.0 < t_s < 25.0]
        gaps = [later - earlier for earlier, later in itertools.pairwise(times)]
        assert max(gaps) > 0.5, "while the two sensors disagree"
        assert f.of_type(name, 28.0)
    assert f.of_type("NAMED_VALUE_FLOAT", 20.5, 22.0)


def test_what_is_withheld_is_refused_to_whoever_requests_it(flight):
    f = flight("[output]\nmax_sigma_deg = 0.001\n", sim("still"))
    f.run_until(5.0)
    values = {"param1": 31.0, "command": 512, "target_system": 1, "target_component": 193}
    f.service.receive(0, f.vehicle.encoder.message("COMMAND_LONG", values), f.now_ns)
    f.run_until(5.5)
    assert [one.result for one in f.of_type("COMMAND_ACK")] == [1]
    assert f.of_type("ATTITUDE_QUATERNION") == []
