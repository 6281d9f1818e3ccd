"""``python -m attest_mav`` is ``attest-mav``."""

from attest_mav.cli.entry import main

main()
