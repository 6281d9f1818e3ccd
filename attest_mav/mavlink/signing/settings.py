"""The settings of the signatures on one link."""

from dataclasses import dataclass, field


@dataclass(frozen=True)
class SigningSettings:
    """A link whose outgoing frames are signed, and whose signed frames are verified."""

    key: bytes = field(repr=False)
    """The secret, 32 bytes; it appears in no text."""
    requires: bool = False
    """Unsigned frames are dropped, whoever sends them."""
    accept_unsigned: tuple[str, ...] = ()
    """Messages that are taken unsigned, but not of a component that has signed with our key."""
