"""A filter of one's own, a complementary filter, run over logs and compared with the reference in them.

    .venv/bin/python examples/own_filter.py LOG...

A filter is a frozen record of parameters with a name, ``initial`` and a pure ``step``. The replay aligns it, restarts
it after gaps and compares it like the package's own filters.
"""

import sys
from dataclasses import dataclass
from math import exp
from typing import Any

from attest_mav.algebra import cross, down_in_body, norm, q_exp, q_mul, q_unit, scale, sub
from attest_mav.filters.base import AttitudeFilter, FilterInputs, FilterState, Start
from attest_mav.filters.registry import default_filter
from attest_mav.replay.batch import replay_file
from attest_mav.replay.request import Request, Window
from attest_mav.runtime.files import open_log
from attest_mav.samples import ImuSample


@dataclass(frozen=True)
class Complementary(AttitudeFilter):
    """The gyro's attitude, levelled by the accelerometer with a time constant. Its heading is the gyro's alone."""

    time_constant_s: float = 5.0

    @property
    def name(self) -> str:
        """The name in the report."""
        return "complementary"

    def initial(self, start: Start) -> FilterState:
        """Begin with the attitude and the gyro bias of the alignment."""
        return FilterState(start.q_nb, start.gyro_bias, accel_used=False, mag_used=False)

    def step(self, state: FilterState, dt_s: float, sample: ImuSample, inputs: FilterInputs) -> FilterState:
        """Turn by the gyro, then towards the vertical that the accelerometer shows."""
        q = q_mul(state.q_nb, q_exp(scale(sub(sample.gyro, state.gyro_bias), 0.5 * dt_s)))
        length = norm(sample.accel)
        usable = 0.0 < length < 1e3
        if usable:
            down = scale(sample.accel, -1.0 / length)
            correction = cross(down, down_in_body(q))  # the body-side rotation from the estimate's down to this one
            share = 1.0 - exp(-dt_s / self.time_constant_s)
            q = q_mul(q, q_exp(scale(correction, 0.5 * share)))
        return FilterState(q_unit(q), state.gyro_bias, accel_used=usable, mag_used=False)


def compared(path: str, skip_s: float = 30.0) -> dict[str, Any]:
    """The report on one log, as ``attest-mav replay --json`` prints it, with the figures after ``skip_s`` seconds."""
    filters = (Complementary(), default_filter("velocity-aided"))
    return replay_file(path, Request(filters, window=Window(skip_s=skip_s)), open_log)


def main(paths: list[str]) -> None:
    """Print the tilt errors of both filters and of the autopilot on each log."""
    for path in paths:
        report = compared(path, skip_s=5.0)
        print(path)
        rows = [(one["name"], one["tilt_deg"]) for one in report["filters"]]
        if report["autopilot"] is not None:
            rows.append((f"autopilot's {report['autopilot']['message']}", report["autopilot"]["tilt_deg"]))
        for name, tilt in rows:
            text = "nothing to compare" if tilt is None else f"rms {tilt['rms']:6.2f}  max {tilt['max']:6.2f}"
            print(f"  {name:<24} tilt, degrees: {text}")


if __name__ == "__main__":
    main(sys.argv[1:])
