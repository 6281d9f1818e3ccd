"""The receiving side of all links: bytes in, intact frames out, with their signatures verified."""

from collections.abc import Sequence
from typing import Final

from attest_mav.mavlink.component.companion import Companion
from attest_mav.mavlink.dialect import Dialect
from attest_mav.mavlink.signing.links import LinkSigning
from attest_mav.mavlink.wire.frame import Frame
from attest_mav.service.link_input import LinkInput
from attest_mav.service.link_records import NO_TRAFFIC, LinkSnapshot, Traffic
from attest_mav.service.observation import link_snapshot
from attest_mav.service.settings import ServiceSettings
from attest_mav.service.signing_status import signing_snapshot


class Reception:
    """Framers and a verifier for each link. The companion's frames are signed with the same keys."""

    def __init__(self, dialect: Dialect, companion: Companion, settings: ServiceSettings) -> None:
        links = [(port.name, one.signing) for port, one in zip(companion.ports, settings.ports, strict=True)]
        signing = LinkSigning(dialect, settings.companion.component, links, companion.notebook)
        for port, signer in zip(companion.ports, signing.signers, strict=True):
            if signer is not None:
                port.sign_with(signer.sign)
        self.clock: Final = signing.clock
        """The time of our signatures."""
        self._companion: Final = companion
        self._verifiers: Final = signing.verifiers
        self._inputs: Final = [
            LinkInput(dialect, companion.wanted, None if verifier is None else verifier.accepts)
            for verifier in signing.verifiers
        ]

    def feed(self, link: int, data: bytes, now_ns: int, stream: int) -> tuple[list[Frame], bool]:
        """The wanted frames that these bytes of a stream complete, and whether they complete an intact one at all.

        On a link that requires signatures only a frame with a correct one counts as intact; one of an old time does
        too, since a vehicle whose clock is behind must hear us to follow ours.
        """
        self.clock.advance(now_ns)
        source, verifier = self._inputs[link], self._verifiers[link]
        authentic = 0 if verifier is None else verifier.authentic
        frames = source.feed(data, now_ns, stream)
        if verifier is not None and verifier.requires:
            return frames, verifier.authentic > authentic
        return frames, source.completed

    def restarted(self, link: int) -> None:
        """A link was opened again: a frame that was received in part is dropped."""
        self._inputs[link].reset()

    def measure_loss(self, now_ns: int) -> None:
        """Tell the companion what the vehicle's link loses."""
        vehicle = self._companion.discovery.vehicle
        if vehicle is not None:
            source = self._inputs[vehicle.link]
            self._companion.data.stream_manager.loss.take(source.frames, source.lost, source.bad_crc, now_ns)

    def snapshots(self, traffic: Sequence[Traffic], now_ns: int) -> tuple[LinkSnapshot, ...]:
        """All links. traffic: the host's counters, one record a link, or nothing."""
        counters = traffic or [NO_TRAFFIC] * len(self._inputs)
        signing = [signing_snapshot(verifier, now_ns) for verifier in self._verifiers]
        parts = zip(self._inputs, self._companion.ports, signing, counters, strict=True)
        return tuple(link_snapshot(*part) for part in parts)
