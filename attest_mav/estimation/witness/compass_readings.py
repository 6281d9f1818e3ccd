"""The newest reading of each magnetometer, beside the attitude of the selected lane."""

from typing import Final

from attest_mav.estimation.field_evidence import FieldReading
from attest_mav.estimation.witness.flight_state import field_reading, hard_iron
from attest_mav.estimation.witness.lane_watch import LaneWatch
from attest_mav.filters.base import FilterState
from attest_mav.filters.velocity_aided.reading import field_of

SPACING_NS: Final = 50_000_000
"""ns. Readings that come faster are left out, as the filter does."""
REPEAT_NS: Final = 500_000_000
"""ns. A reading that stays the same counts again after this time."""


class CompassReadings:
    """Follows the samples of all lanes."""

    def __init__(self) -> None:
        self.newest: Final[dict[str, FieldReading]] = {}
        """By the name of the inertial message."""
        self._selected = ""
        self._state: FilterState | None = None

    def take(self, lane: LaneWatch, selected: LaneWatch) -> None:
        """Take the newest sample of a lane: the filter of the selected one has chosen its reading already."""
        self._forget_others(lane, selected)
        reading = _own(lane) if lane is selected else self._beside(lane, selected)
        if reading is not None:
            self.newest[lane.name] = reading

    def _forget_others(self, lane: LaneWatch, selected: LaneWatch) -> None:
        """Forget the readings beside an attitude from which the selected one does not go on."""
        moment = lane.moments.newest
        goes_on = selected.name == self._selected and selected.is_navigating
        if lane is selected and moment is not None:
            goes_on = goes_on and moment.before is self._state
            self._state = moment.state
        self._selected = selected.name
        if not goes_on:
            self.newest.clear()

    def _beside(self, lane: LaneWatch, selected: LaneWatch) -> FieldReading | None:
        """The reading in the newest sample of another lane, None where it has none, or no new one."""
        moment, beside = lane.moments.newest, selected.moments.newest
        if moment is None or beside is None or lane.state is None:
            return None
        before = self.newest.get(lane.name)
        if before is not None:
            since_ns = moment.t_ns - before.t_ns
            is_same = field_of(moment.sample) == before.field
            if 0 <= since_ns < (REPEAT_NS if is_same else SPACING_NS):
                return None
        apart_s = (moment.t_ns - beside.t_ns) * 1e-9
        iron, inclination = hard_iron(lane.state), moment.inputs.inclination
        return field_reading(selected.name, beside.state, moment.sample, iron, apart_s, inclination)


def _own(selected: LaneWatch) -> FieldReading | None:
    """The reading in the newest sample of the selected lane, None where its filter has used none."""
    moment, reading = selected.moments.newest, selected.field_reading
    return reading if moment is not None and reading is not None and reading.t_ns == moment.t_ns else None
