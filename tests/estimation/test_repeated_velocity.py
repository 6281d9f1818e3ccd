"""A receiver that repeats one velocity with new times."""

from attest_mav.estimation.lane_inputs import RepeatedVelocity
from attest_mav.samples import VelocitySample
from attest_mav.types import VelocityOrigin


def fix(t_s, north):
    return VelocitySample("GPS_RAW_INT", 1, 1, round(t_s * 1e9), 0, (north, 1.0, 0.0), False, VelocityOrigin.RECEIVER)


def answers(*fixes):
    receiver = RepeatedVelocity()
    return [receiver.is_frozen(one) for one in fixes]


def test_five_equal_velocities_over_a_second_are_a_frozen_receiver():
    assert answers(*[fix(0.25 * k, 3.0) for k in range(6)]) == [False] * 4 + [True] * 2


def test_a_fast_receiver_is_given_a_second():
    assert answers(*[fix(0.1 * k, 3.0) for k in range(12)]) == [False] * 10 + [True] * 2


def test_one_fix_that_is_given_again_is_no_repetition():
    assert not any(answers(*[fix(5.0, 3.0)] * 20, fix(5.2, 3.0)))


def test_it_is_over_with_the_first_other_velocity():
    frozen = [fix(0.25 * k, 3.0) for k in range(6)]
    assert answers(*frozen, fix(1.5, 3.01), fix(1.75, 3.01))[-3:] == [True, False, False]


def test_a_velocity_of_zero_is_what_a_receiver_at_rest_gives():
    still = [
        VelocitySample("GPS_RAW_INT", 1, 1, k * 200_000_000, 0, (0.0, 0.0, 0.0), False, VelocityOrigin.RECEIVER)
        for k in range(30)
    ]
    assert not any(answers(*still))


def test_a_clock_that_goes_back_begins_anew():
    before = [fix(100.0 + 0.25 * k, 3.0) for k in range(6)]
    assert answers(*before, *[fix(0.25 * k, 3.0) for k in range(4)])[6:] == [False] * 4
