"""A short campaign of damage, and what it would notice; tools/damage_logs runs the long one."""

import subprocess
import sys
from pathlib import Path
from random import Random

import pytest

from attest_mav.evaluation.damage.campaign import Patient, outcome, survivors_of
from attest_mav.evaluation.damage.injuries import INJURIES, Chance, Piece, content
from attest_mav.evaluation.damage.readings import Reading
from attest_mav.evaluation.damage.samples import SAMPLES

TOOL = Path(__file__).parents[3] / "tools" / "damage_logs"


@pytest.fixture(scope="module", params=sorted(SAMPLES))
def patient(request, dialect):
    return Patient(request.param, SAMPLES[request.param](Random(1)), dialect)


def test_every_intact_record_is_recovered(patient):
    assert patient.fit
    intact = 0
    for seed in range(30):
        pieces = patient.damaged(seed)
        found = outcome(patient, pieces, patient.reader.read(content(pieces, patient.log)))
        assert (found.missing, found.complaint) == ((), ""), f"seed {seed}"
        intact += found.intact
    assert intact > 5_000


def test_each_injury_changes_the_log(patient):
    for name, injure in INJURIES.items():
        chance = Chance(Random(3), patient.log, patient.records)
        damaged = content(injure(chance, [Piece(0, len(patient.log))]), patient.log)
        assert damaged != patient.log, name


def test_a_reader_that_loses_a_record_is_noticed(patient):
    whole = [Piece(0, len(patient.log))]
    reading = patient.reader.read(patient.log)
    lost = outcome(patient, whole, Reading(reading.found[:-1], 0))
    assert (lost.intact - lost.recovered, len(lost.missing)) == (1, 1)
    assert "counted as lost" in outcome(patient, whole, Reading(reading.found, len(patient.log))).complaint


def test_records_behind_a_destroyed_description_are_not_expected(dialect):
    patient = Patient("dataflash", SAMPLES["dataflash"](Random(1)), dialect)
    described = next(one for one in patient.records if one.kind == "RATE").descriptions[0]
    pieces = [Piece(0, described[0] + 30), Piece(described[0] + 30, described[0] + 31, b"?")]
    pieces.append(Piece(described[0] + 31, len(patient.log)))
    kinds = {patient.records[index].kind for index, _ in survivors_of(pieces, patient.records)}
    assert kinds == {"IMU", "ATT", "MODE", "PARM", "MSG"}


def test_the_command_damages_logs_and_archives_and_repeats_a_run_by_its_seed():
    command = [sys.executable, "-P", str(TOOL), "--seed", "99", "--runs"]
    kinds = {"capture_output": True, "text": True, "timeout": 120}
    done = [subprocess.run([*command, runs], check=False, **kinds) for runs in ("3", "1")]
    assert [one.returncode for one in done] == [0, 0]
    rows = [line.split()[:4] for line in done[0].stdout.splitlines() if "plain" in line]
    assert len(rows) == 5
    assert rows == [line.split()[:4] for line in done[1].stdout.splitlines() if "plain" in line]
    assert done[0].stdout.splitlines()[-1].endswith("faults: 0")
