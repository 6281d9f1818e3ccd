"""The clocks of a log as the first pass found them: the sensors', the recorder's, and the date."""

from collections.abc import Iterable
from math import nan
from typing import Final

from attest_mav.earth_field import LAST_YEAR, year_of
from attest_mav.logs.source import FlightDate, VehicleId
from attest_mav.logs.tlog.arrivals import Arrivals, judge_arrivals
from attest_mav.logs.tlog.message_counter import MessageCounter
from attest_mav.logs.tlog.sensor_clock import SensorClock, judge_clock
from attest_mav.logs.tlog.stamp_columns import StampColumn
from attest_mav.mavlink.decode.boot_clock import BootClock

SAME_DATE_S: Final = 30 * 86400.0
"""The field of the Earth does not change by a hundredth of a degree in this time."""
MAVLINK_YEAR: Final = 2009.0
"""No log is older."""


class LogClocks:
    """Judges the clocks of a counted log."""

    def __init__(self, counter: MessageCounter, boot_clock: BootClock) -> None:
        self._counter: Final = counter
        self._boot_clock: Final = boot_clock
        self._columns: Final = {((one.system, one.component), one.name): one for one in counter.stamps.columns.values()}
        self._judged: Final[dict[tuple[VehicleId, str], SensorClock]] = {}
        self.arrivals: Final[Arrivals] = judge_arrivals(self._fullest(), counter.bad_stamps)
        """The judgement on the times of arrival."""

    def sensor(self, vehicle: VehicleId, name: str) -> SensorClock:
        """The clock of one inertial message; ``SensorClock()`` where there is no such message."""
        key = (vehicle, name)
        judged = self._judged.get(key)
        if judged is None:
            column = self._columns.get(key)
            judged = SensorClock() if column is None else self._judge(column)
            self._judged[key] = judged
        return judged

    def duration_s(self) -> float:
        """Time from the first to the last message, s: by arrival, or by a sensor's clock where that is unfit."""
        counter, fullest = self._counter, self._fullest()
        by_arrival_s = (counter.last_rx_ns - counter.first_rx_ns) * 1e-9
        if fullest is None or (self.arrivals.fit and not counter.bare):
            return by_arrival_s
        by_sensor_s = self.sensor((fullest.system, fullest.component), fullest.name).duration_s
        return max(by_arrival_s, 0.0) if by_sensor_s is None else by_sensor_s

    def unix_shift_us(self, vehicle: VehicleId) -> int:
        """The shift of the vehicle's UNIX times in inertial messages, us; 0 where SYSTEM_TIME tells it, or none is."""
        shifts = [
            self.sensor(vehicle, name).rule.shift
            for sender, name in self._columns
            if sender == vehicle and self.sensor(vehicle, name).is_unix
        ]
        return shifts[0] if shifts else 0

    def _judge(self, column: StampColumn) -> SensorClock:
        return judge_clock(column, self._boot_clock, self.arrivals.fit)

    def _fullest(self) -> StampColumn | None:
        """The column with most times."""
        return max(self._columns.values(), key=lambda one: len(one.stamps), default=None)


def date_of(arrivals_ns: Iterable[int], told_us: int | None) -> FlightDate:
    """The date of a flight.

    arrivals_ns: times of arrival, the best first, none for a log without. told_us: UNIX time that the vehicle's
    receiver told, us.
    """
    recorded = [one * 1e-9 for one in arrivals_ns]
    told_s = nan if told_us is None else told_us * 1e-6
    if _is_plausible(told_s):
        if not recorded or abs(recorded[0] - told_s) <= SAME_DATE_S:
            return FlightDate(recorded[0] if recorded else told_s)
        return FlightDate(told_s, _instead(recorded[0], f"SYSTEM_TIME's ({year_of(told_s):.1f}) is taken"))
    if not recorded:
        return FlightDate(0.0, "the log tells no date; the declination is that of the newest model")
    plausible = [one for one in recorded if _is_plausible(one)]
    if not plausible:
        return FlightDate(recorded[0], _instead(recorded[0], "no other is known"))
    note = "" if plausible[0] == recorded[0] else _instead(recorded[0], f"{year_of(plausible[0]):.1f} is taken")
    return FlightDate(plausible[0], note)


def _is_plausible(unix_s: float) -> bool:
    """True for a date that a log can have; False for NaN."""
    return MAVLINK_YEAR <= year_of(unix_s) < LAST_YEAR


def _instead(recorded_s: float, taken: str) -> str:
    return f"the recorder's date ({year_of(recorded_s):.1f}) is not that of the flight; for the declination {taken}"
