"""The signatures on one link, as a record of the snapshot and in words: who signs, and what to do about the others."""

from dataclasses import dataclass
from typing import Final

from attest_mav.mavlink.signing.verifier import Trust, Verifier

SHOWN_SYSTEMS: Final = 4
"""So many systems are named in the status line."""

SYSTEM_WORDS: Final = {
    Trust.VERIFIED: "signed with our key",
    Trust.UNKNOWN_KEY: "signed, key not known: put its key into key_file",
    Trust.OLD: "signed with an old time: its clock is behind ours, or somebody repeats its frames",
    Trust.FUTURE: "signed with an impossible time: set its clock",
    Trust.DROPPED: "unsigned and dropped: set our key there",
    Trust.UNSIGNED: "unsigned",
}


@dataclass(frozen=True)
class SigningSnapshot:
    """The signatures on one link. All counts are of frames of wanted messages."""

    requires: bool
    """Whether unsigned frames are dropped."""
    verified: int
    """Signed with our key, in time."""
    bad_signatures: int
    """Signed, and not with our key."""
    old_timestamps: int
    """Signed with our key, and repeated or older than a minute."""
    future_timestamps: int
    """Signed with our key, with a timestamp near the end of its 48 bits."""
    dropped_unsigned: int
    """Unsigned, and dropped."""
    accepted_unsigned: int
    """Unsigned, and taken."""
    systems: tuple[tuple[int, Trust], ...]
    """The systems heard in the last seconds, each with the best outcome of its frames."""


def signing_snapshot(verifier: Verifier | None, now_ns: int) -> SigningSnapshot | None:
    """The signatures of a link, None where nothing is signed."""
    if verifier is None:
        return None
    counts = verifier.counts
    return SigningSnapshot(
        requires=verifier.requires,
        verified=counts[Trust.VERIFIED],
        bad_signatures=counts[Trust.UNKNOWN_KEY],
        old_timestamps=counts[Trust.OLD],
        future_timestamps=counts[Trust.FUTURE],
        dropped_unsigned=counts[Trust.DROPPED],
        accepted_unsigned=counts[Trust.UNSIGNED],
        systems=tuple(verifier.systems(now_ns)),
    )


def signing_text(link: str, signing: SigningSnapshot) -> str:
    """Who signs on a link, and the frames that were refused."""
    named = [f"system {system} {SYSTEM_WORDS[trust]}" for system, trust in signing.systems[:SHOWN_SYSTEMS]]
    left_out = len(signing.systems) - len(named)
    if left_out > 0:
        named.append(f"{left_out} more")
    counts = (
        (signing.bad_signatures, "bad signatures"),
        (signing.old_timestamps + signing.future_timestamps, "wrong times"),
        (signing.dropped_unsigned, "unsigned dropped"),
    )
    refused = ", ".join([f"{count} {what}" for count, what in counts if count])
    return f"signing on {link}: {'; '.join(named) or 'nobody heard'}{f' ({refused})' if refused else ''}"
