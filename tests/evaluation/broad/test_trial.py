"""Trials are read from both formats, and what is wrong with one is said with its name."""

import h5py
import numpy as np
import pytest

from attest_mav.errors import UnreadableDataError
from attest_mav.evaluation.broad.trial import read_trial

NAMES = ("01_undisturbed_a.hdf5", "02_disturbed_b.mat")


@pytest.mark.parametrize("name", NAMES)
def test_both_formats_give_what_was_written(tmp_path, trial_fields, write_trial, name):
    content = trial_fields(3.0)
    content["opt_quat"][120] = np.nan
    write_trial(tmp_path / name, content)
    trial = read_trial(name, (tmp_path / name).read_bytes())
    assert (trial.name, trial.rate_hz) == (name.rpartition(".")[0], 50.0)
    assert trial.disturbed == (name == NAMES[1])
    assert np.array_equal(trial.gyr, content["imu_gyr"])
    assert np.array_equal(trial.acc, content["imu_acc"])
    assert np.array_equal(trial.mag, content["imu_mag"])
    # 150 samples, the first 101 of them at rest, one without a true attitude.
    assert np.flatnonzero(~trial.counted).tolist() == [*range(101), 120]


def broken(content, name):
    """The content with one thing wrong with it, and what must be said."""
    n = len(content["imu_gyr"])
    return {
        "missing": ("imu_mag", lambda: content.pop("imu_mag"), "imu_mag: the field is missing"),
        "short": (
            "imu_acc",
            lambda: content.update(imu_acc=content["imu_acc"][1:]),
            f"imu_acc: expected {n} rows of 3",
        ),
        "narrow": ("opt_quat", lambda: content.update(opt_quat=content["imu_gyr"]), "opt_quat: expected"),
        "no motion": ("movement", lambda: content["movement"].fill(0), "movement: no sample"),
        "no truth": ("opt_quat", lambda: content["opt_quat"].fill(np.nan), "no sample has movement = 1 and a finite"),
        "few flags": ("movement", lambda: content.update(movement=content["movement"][1:]), f"movement: expected {n}"),
    }[name]


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("fault", ["missing", "short", "narrow", "no motion", "no truth", "few flags"])
def test_an_error_names_the_file_and_the_field(tmp_path, trial_fields, write_trial, name, fault):
    content = trial_fields(3.0)
    field, breaks, said = broken(content, fault)
    breaks()
    write_trial(tmp_path / name, content)
    with pytest.raises(UnreadableDataError) as caught:
        read_trial(name, (tmp_path / name).read_bytes())
    assert str(caught.value).startswith(f"{name}: ")
    assert field in str(caught.value)
    assert said in str(caught.value)


@pytest.mark.parametrize("rate", [0.0, -1.0, np.nan, np.inf, "fast"])
def test_a_rate_that_is_none_is_refused(tmp_path, trial_fields, write_trial, rate):
    write_trial(tmp_path / "a.hdf5", trial_fields(3.0))
    with h5py.File(tmp_path / "a.hdf5", "a") as file:
        file.attrs["sampling_rate"] = rate
    with pytest.raises(UnreadableDataError, match=r"^a\.hdf5: sampling_rate: expected"):
        read_trial("a.hdf5", (tmp_path / "a.hdf5").read_bytes())


def error_of(name, data):
    """What is wrong with the file, empty when it is read."""
    try:
        read_trial(name, data)
    except UnreadableDataError as error:
        return str(error)
    return ""


@pytest.mark.parametrize("name", NAMES)
def test_a_damaged_file_is_read_or_refused_in_one_line(tmp_path, trial_fields, write_trial, name):
    """Cut off anywhere, overwritten anywhere, or something else altogether."""
    write_trial(tmp_path / name, trial_fields(3.0))
    whole = (tmp_path / name).read_bytes()
    rng = np.random.default_rng(1)
    cut = [whole[: round(share * len(whole))] for share in (0.0, 0.001, 0.01, 0.3, 0.6, 0.9, 0.999)]
    torn = []
    for _ in range(60):
        data = bytearray(whole)
        at = int(rng.integers(0, len(data) - 8))
        data[at : at + 8] = rng.bytes(8)
        torn.append(bytes(data))
    said = [error_of(name, data) for data in [*cut, b"text", bytes(5000), *torn]]
    assert all(said[:6])
    assert all(said[len(cut) : len(cut) + 2])
    for text in filter(None, said):
        assert text.startswith(f"{name}: ")
        assert "\n" not in text
