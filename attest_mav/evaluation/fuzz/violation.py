"""An invariant that does not hold."""


class InvariantError(AssertionError):
    """Says which invariant was broken, with the numbers."""


def require(holds: bool, text: str) -> None:
    """InvariantError with this text unless it holds."""
    if not holds:
        raise InvariantError(text)
