"""The examples, and the Python in the README, run and show what the text beside them says."""

import re
import runpy
import subprocess
import sys
from math import cos, pi, sin
from pathlib import Path

import pytest

from attest_mav.algebra import q_from_euler, tilt_between
from attest_mav.filters.base import FilterInputs, Start
from attest_mav.samples import ImuSample
from attest_mav.types import North

REPOSITORY = Path(__file__).parents[2]
EXAMPLES = REPOSITORY / "examples"


def run(script: Path, *arguments: str) -> str:
    """What the script prints; -P keeps the checkout from shadowing an installed wheel."""
    done = subprocess.run(
        [sys.executable, "-P", str(script), *arguments], capture_output=True, text=True, check=True, timeout=120
    )
    return done.stdout


def test_arrays_show_that_only_one_filter_leans_with_the_turn():
    rows = [line.split() for line in run(EXAMPLES / "filters_on_arrays.py").splitlines()[2:]]
    assert [float(row[0]) for row in rows] == [10, 20, 30, 40, 50, 60, 70, 80]
    plain_tilt, aided_tilt, aided_heading = ([abs(float(row[k])) for row in rows] for k in (1, 3, 4))
    assert max(plain_tilt) > 5.0
    assert max(aided_tilt) < 0.1
    assert max(aided_heading) < 0.1


def test_a_filter_of_ones_own_is_compared_on_a_log(cuts):
    lines = run(EXAMPLES / "own_filter.py", str(cuts / "plane_circles_turn.tlog")).splitlines()
    figures = {line.split()[0]: [float(number) for number in re.findall(r"\d+\.\d+", line)] for line in lines[1:]}
    assert list(figures) == ["complementary", "velocity-aided", "autopilot's"]
    # A filter that takes the specific force for gravity cannot hold a banked turn; the others do.
    assert figures["complementary"][0] > 10.0
    assert figures["velocity-aided"][0] < 1.0
    assert figures["autopilot's"][0] < 1.0


def test_the_complementary_filter_levels_itself_with_its_time_constant():
    own_filter = runpy.run_path(str(EXAMPLES / "own_filter.py"))["Complementary"](time_constant_s=5.0)
    truth = q_from_euler(0.1, -0.05, 0.0)
    accel = (9.81 * sin(-0.05), -9.81 * sin(0.1) * cos(0.05), -9.81 * cos(0.1) * cos(0.05))
    start = (1.0, 0.0, 0.0, 0.0)
    state = own_filter.initial(Start(start, (0.0, 0.0, 0.0), North.RELATIVE, accel, None))
    for k in range(1, 501):
        sample = ImuSample("own", 1, 1, k * 10_000_000, k * 10_000_000, (0.0, 0.0, 0.0), accel, None)
        state = own_filter.step(state, 0.01, sample, FilterInputs())
    # One time constant leaves 1/e of a small error.
    assert tilt_between(state.q_nb, truth) / tilt_between(start, truth) == pytest.approx(0.368, abs=0.005)


def test_the_python_in_the_readme_prints_what_stands_there():
    readme = (REPOSITORY / "README.md").read_text(encoding="utf-8")
    program, printed = re.findall(r"```(?:python|text)\n(.*?)```", readme, re.DOTALL)[-2:]
    done = subprocess.run([sys.executable, "-P", "-c", program], capture_output=True, text=True, check=True, timeout=60)
    assert done.stdout == printed


def test_the_specific_force_of_the_arrays_is_that_of_a_coordinated_turn():
    module = runpy.run_path(str(EXAMPLES / "filters_on_arrays.py"))
    flight = module["circling_flight"](40.0, 1.0, 5.0)
    acceleration = (flight.velocity[-1] - flight.velocity[-3]) * module["RATE_HZ"] / 2.0
    # In a level turn the horizontal acceleration is g tan(bank), and the specific force g / cos(bank).
    assert (acceleration[0] ** 2 + acceleration[1] ** 2) ** 0.5 == pytest.approx(9.80665 * 0.8391, rel=1e-3)
    assert -flight.accel[-1, 2] == pytest.approx(9.80665 / cos(40.0 * pi / 180.0))


def test_the_readme_and_the_page_of_the_library_show_the_example_of_two_filters():
    program = (EXAMPLES / "two_filters.py").read_text(encoding="utf-8").partition("import numpy")[2]
    for page in ("README.md", "docs/library.md"):
        assert program in (REPOSITORY / page).read_text(encoding="utf-8")


def rms_of(lines, ending="degrees"):
    """The figures of lines like "name ... rms 1.23 degrees", by their first word."""
    return {line.split()[0]: float(re.search(r"rms +([\d.]+) " + ending, line)[1]) for line in lines}


def test_hand_held_holds_the_vertical_beside_the_peers():
    errors = rms_of(run(EXAMPLES / "hand_held.py").splitlines())
    assert {"gradient-descent", "robust-adaptive", "velocity-aided"} <= set(errors)
    assert errors["velocity-aided"] < 1.5
    assert errors["gradient-descent"] < 1.5
    for peer in {"VQF", "imufusion"} & set(errors):
        assert errors[peer] < 4.0  # turned into the same axes, else it would be 90 degrees and more


def test_a_flight_as_arrays_tells_error_and_sigma(cuts, tmp_path):
    picture = tmp_path / "flight.png"
    lines = run(EXAMPLES / "flight_to_arrays.py", str(cuts / "plane_circles_turn.tlog"), str(picture)).splitlines()
    assert lines[0] == "RAW_IMU: 1000 readings; reference SIM_STATE"
    assert float(re.search(r"rms ([\d.]+)", lines[2])[1]) < 1.0
    assert picture.read_bytes().startswith(b"\x89PNG")


def test_tuning_shows_a_best_value_between_the_ends(cuts):
    errors = [
        float(re.search(r"rms +([\d.]+)", line)[1])
        for line in run(EXAMPLES / "tuning.py", str(cuts / "plane_circles_turn.tlog")).splitlines()
    ]
    assert min(errors) < min(errors[0], errors[-1])


def test_a_live_sensor_is_followed_and_torn_lines_are_counted(monkeypatch, capsys):
    module = runpy.run_path(str(EXAMPLES / "live_serial.py"))
    clock = iter(0.02 * k for k in range(1, 2000))
    monkeypatch.setattr("time.monotonic", lambda: next(clock))
    lines = ["0, 0, 0, 0, 0, 9.8, 0.2, 0, -0.4\n"] * 500 + ["0 0 0 0", "x\n"]
    assert module["follow"](lines) == 2
    last = capsys.readouterr().out.splitlines()[-1]
    roll, pitch, yaw = (float(number) for number in re.findall(r"-?\d+\.\d", last)[:3])
    assert (abs(roll), abs(pitch)) == pytest.approx((0.0, 0.0), abs=0.2)
    assert yaw == pytest.approx(90.0, abs=1.0)  # the nose to the north, counted from the east
