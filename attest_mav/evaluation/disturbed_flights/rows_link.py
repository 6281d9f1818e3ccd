"""Rows: the link loses, copies, delays, mixes up and damages."""

from math import inf
from typing import Final

from attest_mav.evaluation.disturbed_flights.link_faults import (
    INERTIAL,
    amid_garbage,
    clock_set,
    copied,
    damaged,
    deaf_to,
    delayed,
    disordered,
    lossy,
    renamed,
    repeated,
    without,
)
from attest_mav.evaluation.disturbed_flights.row import BEGIN_S, DOUBT, Disturbance

WRAP_MS: Final = 2**32 - round((BEGIN_S + 5.0) * 1e3)
"""A clock that is ahead by this wraps 5 s after the beginning, ms."""
STOPPED: Final = "samples stopped"
LATE: Final = r"samples come \d\.\d+ s late"

ROWS: Final = (
    Disturbance(
        "30 % of the frames are lost", lossy(0.3), sign="% of the frames are lost", tilt_deg=1.0, detected_s=5.0
    ),
    Disturbance("70 % of the frames are lost", lossy(0.7), verdicts=DOUBT),
    Disturbance("the link is cut for 0.76 s", lossy(1.0), lasts_s=0.76, sign=STOPPED, verdicts=DOUBT, recovered_s=2.0),
    Disturbance("the link is cut for 10 s", lossy(1.0), sign=STOPPED, verdicts=DOUBT, recovered_s=3.0),
    Disturbance(
        "the inertial messages are lost, all others come",
        without(*INERTIAL),
        sign=STOPPED,
        verdicts=DOUBT,
        recovered_s=3.0,
    ),
    Disturbance("the heartbeats are lost, all others come", without("HEARTBEAT"), sign="no heartbeat", detected_s=4.0),
    Disturbance("every frame comes three times at once", copied((0.0, 0.0, 0.0))),
    Disturbance("every frame comes three times, 50 ms apart", copied((0.0, 0.05, 0.1))),
    Disturbance("every frame comes again after 0.2 s", copied((0.0, 0.2))),
    Disturbance("the last 0.5 s come again every 2 s, renumbered", repeated(0.5, 2.0, 100)),
    Disturbance("every frame is late by 0 to 0.1 s, at random", disordered(0.1)),
    Disturbance("every frame is late by 0 to 0.3 s, at random", disordered(0.3), verdicts=DOUBT),
    Disturbance("all is late by 0.4 s", delayed(lambda _t_s: 0.4), in_order=True, sign=LATE, verdicts=DOUBT),
    Disturbance(
        "all is late by 2 s",
        delayed(lambda _t_s: 2.0),
        in_order=True,
        sign=LATE,
        verdicts=DOUBT,
        detected_s=3.0,
        recovered_s=3.0,
    ),
    Disturbance(
        "all is late, by 0.4 s more each second",
        delayed(lambda t_s: 0.4 * t_s),
        in_order=True,
        sign=LATE,
        verdicts=DOUBT,
        recovered_s=5.0,
    ),
    Disturbance(
        "10 s come late, at three times their rate",
        delayed(lambda t_s: max(0.0, 10.0 - t_s + t_s / 3.0)),
        in_order=True,
        lasts_s=15.0,
        sign=STOPPED,
        verdicts=DOUBT,
    ),
    Disturbance(
        "1 % of the bytes are damaged",
        damaged(0.01),
        sign="% of the frames are damaged",
        verdicts=DOUBT,
        detected_s=5.0,
    ),
    Disturbance("up to 200 random bytes before each frame", amid_garbage(200)),
    Disturbance(
        "the vehicle's clock is set on by 5 s",
        clock_set(5000),
        clock_shifts_ms=(0, 5000),
        verdicts=DOUBT,
        recovered_s=3.0,
    ),
    Disturbance(
        "the vehicle's clock is set back by 5 s",
        clock_set(-5000),
        clock_shifts_ms=(0, -5000),
        verdicts=DOUBT,
        recovered_s=3.0,
    ),
    Disturbance(
        "the 32-bit clock of the vehicle wraps",
        clock_set(WRAP_MS),
        personality="px4",
        begin_s=0.0,
        lasts_s=BEGIN_S + 20.0,
        after_s=0.1,
        clock_shifts_ms=(WRAP_MS,),
        recovered_s=inf,
        verdicts=DOUBT,
    ),
    Disturbance(
        "the vehicle changes its system id for 10 s", renamed(2), sign="system 2|lost", verdicts=DOUBT, recovered_s=3.0
    ),
    Disturbance("the vehicle hears nothing of ours", hears=deaf_to()),
)
