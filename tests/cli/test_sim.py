import pytest
from click.testing import CliRunner

from attest_mav.cli.main import group
from attest_mav.errors import UsageError
from attest_mav.sim.faults import KINDS


def test_help_names_every_fault_within_80_columns():
    done = CliRunner().invoke(group, ["sim", "--help"], terminal_width=80, prog_name="attest-mav")
    assert done.exit_code == 0
    assert max(len(line) for line in done.output.splitlines()) <= 80
    for kind in KINDS:
        plain = [line for line in done.output.splitlines() if line.strip().replace("[N]", "").startswith(kind.name)]
        assert any(line.endswith(kind.does) for line in plain), kind.name


@pytest.mark.parametrize(
    ("fault", "said"),
    [
        ("receiver-of@20", "did you mean receiver-off?"),
        ("gyro1-bias-x@20", "gyro-bias needs a size in deg/s"),
        ("gyro1-bias-x=5", "expected NAME[=SIZE]@START[+DURATION], for example gyro1-bias-x=5@20+15"),
    ],
)
def test_a_fault_that_cannot_be_meant_is_told_before_any_link_is_opened(fault, said):
    with pytest.raises(UsageError) as caught:
        CliRunner().invoke(
            group, ["sim", "--link", "udpout:nowhere.invalid:1", "--fault", fault], catch_exceptions=False
        )
    assert said in str(caught.value)
