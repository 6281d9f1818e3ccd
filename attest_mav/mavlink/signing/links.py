"""The signatures of all links: one clock, and for each link that signs a signer and a verifier."""

from collections.abc import Sequence
from typing import Final

from attest_mav.mavlink.component.notes import Notebook
from attest_mav.mavlink.dialect import Dialect
from attest_mav.mavlink.signing.clock import SigningClock
from attest_mav.mavlink.signing.settings import SigningSettings
from attest_mav.mavlink.signing.signature import signature_for
from attest_mav.mavlink.signing.streams import SignedStreams
from attest_mav.mavlink.signing.verifier import Verifier


class FrameSigner:
    """Signs the frames that leave on one link."""

    def __init__(self, key: bytes, link_id: int, clock: SigningClock) -> None:
        self._key: Final = key
        self._link_id: Final = link_id
        self._clock: Final = clock

    def sign(self, frame: bytes) -> bytes:
        """The 13 bytes behind a frame, which is given from its magic to its checksum."""
        return signature_for(self._key, frame, self._link_id, self._clock.take())


class LinkSigning:
    """A signer and a verifier for each link. ``links``: a name and the settings of each, None where nothing is signed.

    The link id in our signatures is the number of the link.
    """

    def __init__(
        self,
        dialect: Dialect,
        own_component: int,
        links: Sequence[tuple[str, SigningSettings | None]],
        notebook: Notebook,
    ) -> None:
        self.clock: Final = SigningClock()
        """The time of our signatures."""
        streams = {one.key: SignedStreams(own_component) for _, one in links if one is not None}
        self.signers: Final = [
            None if settings is None else FrameSigner(settings.key, number & 0xFF, self.clock)
            for number, (_, settings) in enumerate(links)
        ]
        """One for each link."""
        self.verifiers: Final = [
            None if settings is None else Verifier(dialect, name, settings, self.clock, streams[settings.key], notebook)
            for name, settings in links
        ]
        """One for each link."""
