import io
import math

import pytest

from attest_mav.estimate import Estimate
from attest_mav.filters.gradient_descent.filter import GradientDescent
from attest_mav.logs.tlog.annotate import OUR_COMPONENT, AnnotatedLogWriter
from attest_mav.logs.tlog.reader import TlogReader
from attest_mav.logs.tlog.source import TlogSource
from attest_mav.mavlink.component.encoder import Encoder
from attest_mav.replay.engine import replay
from attest_mav.replay.request import Outputs, Request, Window
from attest_mav.types import North


class Rows:
    def __init__(self):
        self.rows = []

    def write(self, row):
        self.rows.append(row)


def annotate(data, dialect, *filters):
    annotated = io.BytesIO()
    replay(TlogSource(data, dialect), Request(filters, window=Window(skip_s=0.0)), Outputs(annotated=annotated))
    return annotated.getvalue()


def attitudes(data, dialect, one):
    rows = Rows()
    replay(TlogSource(data, dialect), Request((one,), window=Window(skip_s=0.0)), Outputs(rows))
    return [row.attitude for row in rows.rows if row.name == one.name]


def test_without_our_records_the_original_is_left_byte_for_byte(data_cut, dialect):
    damaged = data_cut[:50_000] + b"garbage \xfd\xfe" + data_cut[50_000:-5]
    annotated = annotate(damaged, dialect, GradientDescent())
    kept, last = b"", 0
    for frame in TlogReader(annotated, dialect, frozenset({dialect.id_of("ATTITUDE_QUATERNION")})):
        kept += annotated[last : frame.offset - 8]
        last = frame.offset + frame.size
    assert kept + annotated[last:] == damaged


@pytest.mark.parametrize("q", [(math.nan, 0.0, 0.0, 0.0), (2.0, 0.0, 0.0, 0.0)])
def test_what_the_daemon_would_not_send_is_not_inserted(dialect, q):
    annotated = io.BytesIO()
    writer = AnnotatedLogWriter(b"original", annotated, Encoder(dialect, 1, OUR_COMPONENT))
    writer.insert(Estimate("RAW_IMU", "any", 0, 0, q, (0.0, 0.0, 0.0), North.TRUE, 0.0, 0.0, 0.02), 4)
    writer.finish()
    assert annotated.getvalue() == b"original"


def test_our_records_carry_the_first_filters_attitudes_behind_their_samples(data_cut, dialect):
    first, second = GradientDescent(), GradientDescent(beta=0.5)
    annotated = annotate(data_cut, dialect, first, second)
    fields = dialect.layout("ATTITUDE_QUATERNION").pick("time_boot_ms", "q1", "q2", "q3", "q4")
    ours, imu = [], None
    for frame in TlogReader(annotated, dialect):
        if frame.component == OUR_COMPONENT:
            assert frame.message_id == dialect.id_of("ATTITUDE_QUATERNION")
            assert frame.system == 1
            assert frame.version == 2
            assert frame.sequence == len(ours) % 256
            assert frame.rx_ns == imu.rx_ns
            ours.append(fields.unpack(frame.payload))
        elif frame.message_id == dialect.id_of("RAW_IMU"):
            imu = frame
    expected = attitudes(data_cut, dialect, first)
    assert len(ours) == len(expected) > 900
    for (time_boot_ms, *q), attitude in zip(ours, expected, strict=True):
        assert time_boot_ms == attitude.t_ns // 1_000_000
        assert q == pytest.approx(attitude.q_nb, abs=1e-6)
