"""Receivers that are wrong, on virtual time: the tilt error that is published, and an autopilot that is right.

The fault lasts from 20 to 40 s. Bounds: 1 deg under way, also where a vehicle only says so by being armed; 0.7 deg on
the ground, where the accelerometer's bias alone makes 0.4 with a good receiver. 0.5 on the ground is not reached: fixes
that come back after a time without any move tilt and accelerometer bias, which rest cannot tell apart, by up to 0.2.
"""

from functools import cache
from math import inf

import pytest

from attest_mav.estimation.events import LaneEventKind

from .flying import fly

pytestmark = pytest.mark.campaign

UNTIL_S = 60.0
SETTLED_S = 12.0
LATER_S = 50.0
"""From then on what was learned from bad fixes must be forgotten."""
LEFT_DEG = 0.3
"""So much more than without the fault may be left of it."""

FAULTS = {
    "glitches": (
        "receiver-offset-north=10@20+0.3",
        "receiver-offset-east=-15@27+0.3",
        "receiver-offset=20@32+0.5",
        "receiver-offset-north=5@39+0.3",
    ),
    "frozen": ("receiver-frozen@20+20",),
    "spoofed by 10 m/s": ("receiver-offset-north=10@20+20",),
    "spoofed by 3 m/s": ("receiver-offset-north=3@20+20",),
    "wandering by 1 m/s": ("receiver-wander=1@20+20",),
    "wandering by 3 m/s": ("receiver-wander=3@20+20",),
    "wandering by 3 m/s, and saying so": ("receiver-wander=3@20+20", "receiver-noise=1.5@20+20"),
}


@cache
def healthy(scenario, armed):
    """The flight with a receiver that is right."""
    return fly(UNTIL_S, "velocity-aided", scenario=scenario, armed=armed).worst_published(LATER_S)


KINDS = {"standing": ("still", False, 0.7), "standing armed": ("still", True, 1.0), "hovering": ("hover", True, 1.0)}
"""Motion, whether the vehicle is armed, and the bound, deg."""


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("name", FAULTS)
def test_a_bad_receiver(kind, name):
    scenario, armed, bound = KINDS[kind]
    flight = fly(UNTIL_S, "velocity-aided", FAULTS[name], right=True, scenario=scenario, armed=armed)
    assert flight.first_disagreement_s() == inf
    assert flight.worst_published(LATER_S) < healthy(scenario, armed) + LEFT_DEG
    assert flight.worst_published(SETTLED_S) < bound


def test_a_receiver_that_is_used_again_is_judged_by_its_next_fix():
    """The last fix of before still shows the whole offset, of which the lanes now know nothing."""
    faults = ("receiver-wander=3@20+10", "receiver-offset-north=3@20+30")
    flight = fly(45.0, "velocity-aided", faults, right=True, scenario="hover", armed=True)
    times_s = {
        kind: [event.t_ns * 1e-9 for event in flight.lane_events if event.kind is kind]
        for kind in (LaneEventKind.RECEIVER_USED, LaneEventKind.CONTRADICTED)
    }
    (used_s,) = times_s[LaneEventKind.RECEIVER_USED]
    assert 30.0 < used_s < 40.0
    assert not any(used_s < t_s < used_s + 2.0 for t_s in times_s[LaneEventKind.CONTRADICTED])
