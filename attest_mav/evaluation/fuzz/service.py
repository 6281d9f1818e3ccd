"""The whole service over a hostile line: what it sends is finite, fresh, confident, and what it keeps has an end."""

from math import degrees, inf, isfinite, isnan
from random import Random
from typing import Final

from attest_mav.algebra import norm, q_norm
from attest_mav.config.parsing import parse_config
from attest_mav.config.records import Config
from attest_mav.evaluation.disturbed_flights.frames import message_id
from attest_mav.evaluation.fuzz.hostile_line import HostileLine
from attest_mav.evaluation.fuzz.violation import require
from attest_mav.evaluation.service_flight import Line, ServiceFlight
from attest_mav.mavlink.dialect import Dialect, load_dialect
from attest_mav.mavlink.wire.frame import CHECKSUM_BYTES, HEADER_V2
from attest_mav.service.service import Service
from attest_mav.service.status import status_line
from attest_mav.sim.autopilot import FakeAutopilot
from attest_mav.sim.fault_text import parse_faults
from attest_mav.sim.scenarios import SCENARIOS
from attest_mav.sim.settings import SimSettings

FILTERS: Final = ("velocity-aided", "velocity-aided", "gradient-descent", "robust-adaptive", "leveling")
FAULTS: Final = (
    "reboot@9",
    "imu1-nan@5+3",
    "imu-saturated@6+1",
    "receiver-off@5+5",
    "gyro1-freeze@6+4",
    "compass=900@5",
)
STALE_S: Final = 0.5
MAX_SIGMA_DEG: Final = 3.0
"""The defaults of ``estimate.stale_s`` and ``output.max_sigma_deg``."""
ROUNDING_S: Final = 0.022
"""A stamp is cut to milliseconds, and is up to an interval old when it is sent."""
DRIFT: Final = 0.001
"""Share of the elapsed time by which a delay may grow unseen; half of a round trip is not known either."""
FIRST_CONTACT_S: Final = 5.0
"""Ages are held against their bound from then on: late first samples may be those of another clock, s."""
SECONDS: Final = 20.0
MOST_LINES: Final = 150
"""Lines of the log in one flight."""
CONFIG: Final = """
[[link]]
url = "udpin::0"
publish = ["attitude_quaternion", "attitude_quaternion_cov", "named_values", "statustext"]
[output]
rate_hz = 50
[filter]
name = "{}"
"""


class _WatchedFlight(ServiceFlight):
    """A flight that keeps the least tilt sigma of the present instant, in which several samples may have come."""

    def __init__(self, vehicle: FakeAutopilot, config: Config, dialect: Dialect, line: Line) -> None:
        super().__init__(vehicle, config, dialect, line)
        self.least_sigma_deg = inf

    def take(self, data: bytes) -> None:
        """See ``ServiceFlight``."""
        super().take(data)
        self.least_sigma_deg = min(self.least_sigma_deg, _sigma(self.service))


class _Watch:
    """Holds the invariants of one flight. is_honest: no stamp is edited or forged, so that ages can be told."""

    def __init__(self, dialect: Dialect, flown: _WatchedFlight, is_honest: bool) -> None:
        self._flown: Final = flown
        self._is_honest: Final = is_honest
        self._plain: Final = dialect.layout("ATTITUDE_QUATERNION").pick(
            "time_boot_ms", "q1", "q2", "q3", "q4", "rollspeed", "pitchspeed", "yawspeed"
        )
        self._cov: Final = dialect.layout("ATTITUDE_QUATERNION_COV").pick(
            "q", "rollspeed", "pitchspeed", "yawspeed", "covariance"
        )
        self._ids: Final = dialect.id_of("ATTITUDE_QUATERNION"), dialect.id_of("ATTITUDE_QUATERNION_COV")
        self._lines = 0
        self._seen = flown.service.snapshot(0)

    def sent(self, frames: list[bytes]) -> None:
        """Check what was sent in this instant."""
        least = min(self._flown.least_sigma_deg, _sigma(self._flown.service))
        self._flown.least_sigma_deg = _sigma(self._flown.service)
        for frame in frames:
            data = frame[HEADER_V2:-CHECKSUM_BYTES]
            if message_id(frame) == self._ids[0]:
                boot_ms, *values = self._plain.unpack(data)
                _check_motion(values[:4], values[4:])
                require(least <= MAX_SIGMA_DEG, f"sent at a tilt sigma of {least:.2f} deg, or unaligned")
                self._check_age(boot_ms * 1e-3)
            elif message_id(frame) == self._ids[1]:
                values = list(self._cov.unpack(data))
                _check_motion(values[:4], values[4:7])
                _check_covariance(values[7:])

    def _check_age(self, boot_s: float) -> None:
        flown = self._flown
        now_s = flown.now_ns * 1e-9
        if not self._is_honest or now_s < FIRST_CONTACT_S:
            return
        # After a reboot a frame of the time before it may be on its way: its stamp is ahead of the new clock.
        booted_s = flown.vehicle.boot_ns * 1e-9
        age_s = now_s - boot_s - (booted_s if boot_s < now_s - booted_s + ROUNDING_S else 0.0)
        if age_s > STALE_S:
            round_trip_s = flown.service.snapshot(flown.now_ns).clock.round_trip_s
            limit_s = STALE_S + ROUNDING_S + 0.5 * round_trip_s + DRIFT * now_s
            # Without an exchange, as after a reboot, a delay that is there from the start cannot be known.
            require(age_s <= limit_s or round_trip_s == 0.0, f"sent {age_s:.3f} s old, limit {limit_s:.3f} s")

    def look(self) -> None:
        """Check once a second what is kept and told."""
        service, now_ns = self._flown.service, self._flown.now_ns
        seen = service.snapshot(now_ns)
        status_line(seen, self._seen)
        self._lines += len(service.take_notes())
        require(self._lines <= MOST_LINES, f"{self._lines} lines of the log in {now_ns * 1e-9:.0f} s")
        require(len(seen.refusals) < 300, f"{len(seen.refusals)} sources are remembered")
        self._seen = seen


def _sigma(service: Service) -> float:
    """The tilt sigma of the newest estimate, degrees; 0 for a filter without one, infinite without an estimate."""
    estimate = service.estimate
    if estimate is None:
        return inf
    require(not isfinite(estimate.tilt_sigma) or estimate.tilt_sigma >= 0.0, f"sigma {estimate.tilt_sigma}")
    return 0.0 if isnan(estimate.tilt_sigma) else degrees(estimate.tilt_sigma)


def _check_motion(q_nb: list[float], rates: list[float]) -> None:
    w, x, y, z = q_nb
    require(abs(q_norm((w, x, y, z)) - 1.0) < 1e-5, f"the quaternion is {q_nb}")
    require(isfinite(norm((rates[0], rates[1], rates[2]))), f"the rates are {rates}")


def _check_covariance(values: list[float]) -> None:
    """All unknown, or finite with variances that are not negative."""
    unknown = all(map(isnan, values))
    diagonal = values[0], values[4], values[8]
    require(unknown or (all(map(isfinite, values)) and min(diagonal) >= 0.0), f"the covariance is {values}")


def fuzz_service(seed: int) -> int:
    """One flight; the frames delivered or events handled."""
    rng = Random(f"service {seed}")  # noqa: S311  # repeatable, no secret
    dialect = load_dialect()
    is_honest = rng.random() < 0.4
    settings = SimSettings(
        scenario=rng.choice(SCENARIOS),
        personality=rng.choice(("ardupilot", "ardupilot", "px4")),
        fast_rate_hz=rng.choice((4.0, 50.0, 50.0, 200.0)),
        faults=parse_faults(rng.sample(FAULTS, rng.randrange(3))),
    )
    vehicle = FakeAutopilot(settings, seed, dialect)
    config = parse_config(CONFIG.format(rng.choice(FILTERS)), "fuzz")
    flown = _WatchedFlight(vehicle, config, dialect, HostileLine(rng, dialect, is_honest))
    watch = _Watch(dialect, flown, is_honest)
    steps, look_ns, end_ns = 0, 0, round(SECONDS * 1e9)
    while flown.now_ns < end_ns:
        watch.sent(flown.advance(look_ns))
        steps += 1
        require(steps < 1e6, "time stands still: what is due is due again at once")
        if flown.now_ns >= look_ns:
            look_ns = flown.now_ns + 1_000_000_000
            watch.look()
    return steps
