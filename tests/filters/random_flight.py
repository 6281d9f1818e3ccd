"""A hundred thousand random steps of a filter; the attitude every hundred steps, as JSON on standard output.

Run by test_compiled_twin.py with the interpreted sources and with the compiled package.
"""

import json
import math
import random
import sys

from attest_mav import algebra
from attest_mav.algebra import q_exp, q_heading, q_mul, q_unit, rotate_back
from attest_mav.filters.base import Airspeed, BodyVelocity, FilterInputs, Start
from attest_mav.filters.gradient_descent.filter import GradientDescent
from attest_mav.filters.registry import default_filter
from attest_mav.samples import ImuSample, VelocitySample
from attest_mav.types import AirspeedSource, North, VelocityOrigin

STEPS = 100_000
EVERY = 100

RECEIVER = VelocityOrigin.RECEIVER


def attitudes(name, seed):
    """A body that turns at random, with readings that are noisy, sometimes absent, and sometimes far off."""
    rng = random.Random(seed)
    if name == "gradient-descent with options":
        chosen = GradientDescent(beta=0.02, rest_bias=True, accel_time_s=2.5, heading_rate=0.01, field_gate=True)
    else:
        chosen = default_filter(name)
    truth, rate, speed = q_heading(0.5), (0.0, 0.0, 0.0), 10.0
    state = chosen.initial(Start(truth, (0.0, 0.0, 0.0), North.MAGNETIC, (0.0, 0.0, -9.81), None))
    t_ns, fix = 0, None
    for k in range(STEPS):
        dt_s = rng.choice((0.01, 0.02, 0.02, 0.04, 0.25))
        t_ns += round(dt_s * 1e9)
        if rng.random() < 0.1:
            v_ned = (speed + rng.gauss(0.0, 0.1), rng.gauss(0.0, 1.0), 0.0)
            fix = (
                VelocitySample("GPS_RAW_INT", 1, 1, t_ns, t_ns, v_ned, False, RECEIVER) if rng.random() < 0.9 else None
            )
        rate = tuple(0.98 * w + rng.gauss(0.0, 0.1) for w in rate)
        speed = 0.999 * speed + rng.gauss(0.01, 0.1)
        truth = q_unit(q_mul(truth, q_exp(tuple(0.5 * dt_s * w for w in rate))))
        outlier = 10.0 if rng.random() < 0.02 else 0.3
        force = tuple(f + rng.gauss(0.0, outlier) for f in rotate_back(truth, (0.0, 0.0, -9.81)))
        field = tuple(b + rng.gauss(0.0, 0.01) for b in rotate_back(truth, (0.2, 0.0, 0.4)))
        sample = ImuSample(
            "RANDOM", 1, 1, t_ns, t_ns, rate, force, field if rng.random() < 0.9 else None, rng.random() < 0.01
        )
        state = chosen.step(state, dt_s, sample, _inputs(rng, speed, fix))
        if k % EVERY == 0:
            yield [*state.q_nb, state.tilt_sigma, state.heading_sigma]


def _inputs(rng, speed, fix):
    heading = rng.gauss(0.0, 1.0) if rng.random() < 0.01 else None
    speed = math.nan if rng.random() < 0.1 else speed
    return FilterInputs(
        BodyVelocity(speed, is_new=rng.random() < 0.3),
        rng.random() < 0.05,
        0.6,
        0.1,
        fix,
        heading=heading,
        inclination=1.1,
        airspeed=Airspeed(speed, AirspeedSource.SENSOR),
        goes_where_it_points=True,
    )


if __name__ == "__main__":
    json.dump({"core": algebra.__file__, "attitudes": list(attitudes(sys.argv[1], int(sys.argv[2])))}, sys.stdout)
