from attest_mav.evaluation.replay.stamping import BurstStamp

MS = 1_000_000


def test_the_timed_message_before_lends_its_time_once():
    stamp = BurstStamp()
    assert stamp.time_of_untimed(0) is None
    stamp.timed(8484 * MS, 100 * MS)
    assert stamp.time_of_untimed(102 * MS) == 8484 * MS
    assert stamp.time_of_untimed(103 * MS) is None


def test_a_burst_whose_timed_message_was_lost_has_no_time():
    stamp = BurstStamp()
    stamp.timed(8484 * MS, 100 * MS)
    assert stamp.time_of_untimed(933 * MS) is None


def test_bursts_read_at_one_instant_are_told_apart_by_their_order():
    stamp = BurstStamp()
    times = []
    for burst_ms in (8000, 8250):
        stamp.timed(burst_ms * MS, 500 * MS)
        times.append(stamp.time_of_untimed(500 * MS))
    assert times == [8000 * MS, 8250 * MS]
