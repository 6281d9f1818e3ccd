"""The exceptions a user can meet, with the exit code each one ends a command with.

::

    AttestMavError
     +-- UsageError          2   an argument that cannot be meant
     |    +-- ArgumentError      the same in a call from Python, a ValueError too
     +-- UnreadableDataError 65  a file that is missing, empty, or not what it should be
     +-- UnwritableError     65  a result that cannot be written
     +-- LinkError           69  a port or device that cannot be opened
     +-- WorkersError        69  processes or computers that were to help and are gone
     +-- ConfigError         78  a configuration key or value

Bad *samples* never raise: they are counted results (see ``attest_mav.estimation``). Anything that escapes and is not
in this tree is a bug.
"""


class AttestMavError(Exception):
    """Base of all errors meant for the user: one clear line, no traceback."""

    exit_code = 1


class UsageError(AttestMavError):
    """An argument is unknown or makes no sense."""

    exit_code = 2


class UnreadableDataError(AttestMavError):
    """A file cannot be read in the format expected of it."""

    exit_code = 65


class UnwritableError(AttestMavError):
    """A result cannot be written where it was to go."""

    exit_code = 65


class LinkError(AttestMavError):
    """A link cannot be opened, and the caller asked to be told instead of waiting."""

    exit_code = 69


class WorkersError(AttestMavError):
    """Helping processes have ended, or a Dask cluster does not answer or cannot do the work."""

    exit_code = 69


class ConfigError(AttestMavError):
    """A configuration file or value is wrong. The message names the file and the key."""

    exit_code = 78


class ArgumentError(UsageError, ValueError):
    """A call of the library with an argument that makes no sense: the argument, what is expected, and what came."""
