"""Other people's filters over a trial: VQF with its defaults, and the best setting of imufusion.

Both take the data set's own units and frames and give attitudes to ENU.
"""

from typing import Final

import numpy as np

from attest_mav.evaluation.broad.trial import Trial
from attest_mav.evaluation.motion import Array
from attest_mav.types import G_MPS2

FUSION_GAIN: Final = 0.1
FUSION_REJECTION_DEG: Final = 40.0
FUSION_TIMEOUT_S: Final = 5.0
FUSION_RANGE_DEGPS: Final = 2000.0
"""The best of some thirty settings on the even trials: gains from 0.02 to 1, rejection off or at 10 to 60 degrees."""


def vqf(trial: Trial, with_mag: bool) -> Array:
    """Sensor to ENU, shape (n, 4), of VQF as it comes."""
    from vqf import VQF  # noqa: PLC0415 - not always installed

    filter_ = VQF(1.0 / trial.rate_hz)
    if with_mag:
        found: Array = filter_.updateBatch(trial.gyr, trial.acc, trial.mag)["quat9D"]
    else:
        found = filter_.updateBatch(trial.gyr, trial.acc)["quat6D"]
    return found


def imufusion(trial: Trial, with_mag: bool) -> Array:
    """Sensor to ENU, shape (n, 4), of imufusion with its own bias estimation at rest."""
    import imufusion as fusion  # noqa: PLC0415 - not always installed

    ahrs, bias = fusion.Ahrs(), fusion.Bias()
    settings, bias_settings = fusion.AhrsSettings(), fusion.BiasSettings()
    settings.convention = fusion.CONVENTION_ENU
    settings.sample_rate = bias_settings.sample_rate = trial.rate_hz
    settings.gain, settings.gyroscope_range = FUSION_GAIN, FUSION_RANGE_DEGPS
    settings.acceleration_rejection = settings.magnetic_rejection = FUSION_REJECTION_DEG
    settings.rejection_timeout = FUSION_TIMEOUT_S
    ahrs.set_settings(settings)
    bias.set_settings(bias_settings)
    found = np.empty((len(trial.gyr), 4))
    for number, (gyr, acc, mag) in enumerate(zip(np.degrees(trial.gyr), trial.acc / G_MPS2, trial.mag, strict=True)):
        rate = bias.update(gyr)
        if with_mag:
            ahrs.update(rate, acc, mag)
        else:
            ahrs.update_no_magnetometer(rate, acc)
        found[number] = ahrs.get_quaternion()
    return found
