"""A few runs of each fuzz target, and what the targets would notice; tools/fuzz runs them for minutes."""

from random import Random

import pytest

from attest_mav.evaluation.fuzz import decoder, framer, service
from attest_mav.evaluation.fuzz.targets import TARGETS
from attest_mav.evaluation.fuzz.values import payload
from attest_mav.evaluation.fuzz.violation import InvariantError
from attest_mav.mavlink.decode.decoder import Decoder
from attest_mav.mavlink.wire.framer import Framer
from attest_mav.samples import AttitudeSample
from attest_mav.service.publication_gate import PublicationGate


@pytest.mark.parametrize(("name", "seeds"), [("framer", 30), ("decoder", 20), ("service", 3)])
def test_a_few_runs(name, seeds):
    assert sum(TARGETS[name](seed) for seed in range(seeds)) > 1000


def test_a_seed_repeats_its_run(dialect):
    layout = dialect.layout("RAW_IMU")
    assert payload(Random(1), layout, 0.5) == payload(Random(1), layout, 0.5) != payload(Random(2), layout, 0.5)
    assert service.fuzz_service(11) == service.fuzz_service(11)


def run_all(target):
    for seed in range(20):
        target(seed)


class LosingFramer:
    """A framer that loses frames."""

    def __init__(self, *arguments):
        self._framer = Framer(*arguments)

    def feed(self, data, rx_ns):
        return [frame for frame in self._framer.feed(data, rx_ns) if frame.offset % 10]

    def finish(self, rx_ns):
        return self._framer.finish(rx_ns)


class ScalingDecoder:
    """A decoder whose quaternions have the length 2."""

    def __init__(self, *arguments):
        self._decoder = Decoder(*arguments)

    def __getattr__(self, name):
        return getattr(self._decoder, name)

    def decode(self, frame):
        samples = self._decoder.decode(frame)
        return [
            one.with_attitude(tuple(2.0 * c for c in one.q_nb), frame_known=True)
            for one in samples
            if isinstance(one, AttitudeSample)
        ]


def test_a_framer_that_loses_frames_is_noticed(monkeypatch):
    monkeypatch.setattr(framer, "Framer", LosingFramer)
    with pytest.raises(InvariantError, match=r"intact frame at byte \d+ of \d+ is lost"):
        run_all(framer.fuzz_framer)


def test_a_decoder_that_passes_on_any_quaternion_is_noticed(monkeypatch):
    monkeypatch.setattr(decoder, "Decoder", ScalingDecoder)
    with pytest.raises(InvariantError, match="the quaternion is"):
        run_all(decoder.fuzz_decoder)


def test_a_service_that_publishes_whatever_its_sigma_is_noticed(monkeypatch):
    monkeypatch.setattr(PublicationGate, "_objection", lambda *_: "")
    with pytest.raises(InvariantError, match="sent at a tilt sigma of"):
        run_all(service.fuzz_service)
