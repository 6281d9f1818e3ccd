"""The entry point of ``attest-mav``: the command line is loaded while garbage is seldom searched for."""

from attest_mav.cli.collector import seldom_collected


def main() -> None:
    """Load the command line, and run it. The searches while it loads would cost a start 3 ms."""
    with seldom_collected():
        from attest_mav.cli.main import main as run_command_line  # noqa: PLC0415 - loaded within the block
    run_command_line()
