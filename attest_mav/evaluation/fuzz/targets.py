"""What can be fuzzed. Each takes a seed, raises at the first broken invariant, and returns the number of its steps."""

from collections.abc import Callable, Mapping
from typing import Final

from attest_mav.evaluation.fuzz.decoder import fuzz_decoder
from attest_mav.evaluation.fuzz.framer import fuzz_framer
from attest_mav.evaluation.fuzz.service import fuzz_service

TARGETS: Final[Mapping[str, Callable[[int], int]]] = {
    "framer": fuzz_framer,
    "decoder": fuzz_decoder,
    "service": fuzz_service,
}
