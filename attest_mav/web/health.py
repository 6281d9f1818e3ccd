"""Whether the daemon does its work: every link is open, and a vehicle that is there has a fresh attitude."""

from attest_mav.service.snapshot import Snapshot
from attest_mav.service.status import obstacles


def ailments(snapshot: Snapshot) -> list[str]:
    """What keeps the daemon from its work, each in a few words; nothing while it works or no vehicle is there."""
    found = [f"{link.name} is not open" for link in snapshot.links if not link.traffic.is_open]
    vehicle = snapshot.vehicle
    if vehicle is not None and vehicle.is_present and snapshot.published_lane is None:
        found += obstacles(snapshot)
    return found
