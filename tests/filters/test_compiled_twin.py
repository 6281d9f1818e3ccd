"""The compiled core against the very same sources interpreted: a hundred thousand random steps of each filter."""

import json
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from attest_mav import algebra

REPOSITORY = Path(__file__).parents[2]
FLIGHT = Path(__file__).with_name("random_flight.py")


def flown(name, *, interpreted):
    """The attitudes of the random flight in a process of its own, and where its core came from."""
    environment = dict(os.environ)
    environment.pop("PYTHONPATH", None)
    # A source tree ahead of everything shadows the installed, compiled package.
    path = [str(REPOSITORY)] if interpreted else [entry for entry in sys.path if entry]
    environment["PYTHONPATH"] = os.pathsep.join(path)
    run = subprocess.run(
        [sys.executable, str(FLIGHT), name, "11"],
        env=environment,
        capture_output=True,
        text=True,
        check=True,
        timeout=300,
    )
    answer = json.loads(run.stdout)
    return np.array(answer["attitudes"]), answer["core"]


@pytest.mark.skipif(
    algebra.__file__.endswith(".py"), reason="the core is not compiled here: there is nothing to compare"
)
@pytest.mark.parametrize(
    "name", ["gradient-descent", "gradient-descent with options", "robust-adaptive", "leveling", "velocity-aided"]
)
def test_a_hundred_thousand_steps_agree(name):
    compiled, core = flown(name, interpreted=False)
    interpreted, source = flown(name, interpreted=True)
    assert core == algebra.__file__
    assert source == str(REPOSITORY / "attest_mav" / "algebra.py")
    assert np.isfinite(compiled[:, :4]).all()
    assert len(compiled) == 1000
    assert np.nanmax(np.abs(compiled - interpreted)) < 1e-12
