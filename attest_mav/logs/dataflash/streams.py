"""Names of streams: one for each sensor or estimator core, whichever firmware wrote the log.

Before 4.1 the second sensor had a record of its own (IMU2); since then the record IMU has a column with the sensor's
number. Both are the stream IMU2 here.
"""

from typing import Final

from attest_mav.logs.dataflash.record_format import RecordFormat

SENSORS: Final = {
    "IMU": ("IMU", "IMU2", "IMU3", "IMU4", "IMU5"),
    "MAG": ("MAG", "MAG2", "MAG3"),
    "GPS": ("GPS", "GPS2"),
    "GPA": ("GPA", "GPA2"),
    "ARSP": ("ARSP", "ARSP2"),
    "XKF1": ("XKF1", "XKF6", "XKF11"),
    "NKF1": ("NKF1", "NKF6", "NKF11"),
    "XKQ": ("XKQ", "XKQ2", "XKQ3"),
    "NKQ": ("NKQ", "NKQ2", "NKQ3"),
}
"""The streams of records with a number, by the number. Those of the estimators' cores are the old records' names."""
RENAMED: Final = {"XKQ1": "XKQ", "NKQ1": "NKQ"}
"""Old names of the first core."""
NUMBERS: Final = ("I", "C")
"""Names of the column with the number: of a sensor (instance), of an estimator (core)."""


def number_column(record_format: RecordFormat) -> int:
    """The column with the number of the sensor or core; -1 for a record without."""
    if record_format.name not in SENSORS or not record_format.is_readable:
        return -1
    found = [record_format.index(name) for name in NUMBERS if record_format.index(name) >= 0]
    # The second column is the number's; an I elsewhere is something else.
    return found[0] if found and found[0] <= 1 and record_format.codes[found[0]] == "B" else -1


def streams_of(record_format: RecordFormat) -> tuple[str, ...]:
    """The streams that the records of one type belong to, by their numbers; one for records without."""
    name = RENAMED.get(record_format.name, record_format.name)
    return SENSORS[name] if number_column(record_format) >= 0 else (name,)
