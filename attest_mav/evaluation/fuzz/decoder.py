"""The decoder: no message raises, attitudes are unit quaternions, and what is remembered has an end."""

from math import isfinite
from random import Random
from typing import Final

from attest_mav.algebra import q_norm
from attest_mav.evaluation.fuzz.values import payload
from attest_mav.evaluation.fuzz.violation import require
from attest_mav.mavlink.decode.decoder import Decoder
from attest_mav.mavlink.dialect import load_dialect
from attest_mav.mavlink.wire.frame import Frame
from attest_mav.samples import AttitudeSample, ImuSample, Sample, VelocitySample

MESSAGES: Final = 400
"""Messages of one run."""
MOST_SOURCES: Final = 2000
"""Sources with a reason that a decoder may remember."""


def fuzz_decoder(seed: int) -> int:
    """One run; its messages."""
    rng = Random(f"decoder {seed}")  # noqa: S311  # repeatable, no secret
    dialect = load_dialect()
    decoder = Decoder(dialect)
    layouts = [dialect.by_id[number] for number in sorted(decoder.wanted)]
    share = rng.choice((0.05, 0.5, 1.0))
    known: dict[str, bytes] = {}
    for number in range(MESSAGES):
        layout = rng.choice(layouts)
        data = known[layout.name] = payload(rng, layout, share, known.get(layout.name, b""))
        cut = data[: rng.randrange(len(data) + 1)] if rng.random() < 0.1 else data
        frame = Frame(layout.message_id, rng.choice((1, 1, 2, 0, 255)), 1, number % 256, 2, False, cut, number)
        for sample in decoder.decode(frame):
            _check(sample)
    sources = len(decoder.refusals) + len(decoder.refused)
    require(sources < MOST_SOURCES, f"{sources} sources are remembered")
    return MESSAGES


def _check(sample: Sample) -> None:
    """The invariants of one sample."""
    if isinstance(sample, AttitudeSample):
        require(abs(q_norm(sample.q_nb) - 1.0) < 1e-6, f"{sample.source}: the quaternion is {sample.q_nb}")
    elif isinstance(sample, ImuSample):
        require(all(map(isfinite, sample.accel)), f"{sample.source}: the force is {sample.accel}")
    elif isinstance(sample, VelocitySample):
        require(all(map(isfinite, sample.v_ned)), f"{sample.source}: the velocity is {sample.v_ned}")
