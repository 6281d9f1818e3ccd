"""Who takes a lane's filter from one sample to the next: the filter alone, or someone who watches it."""

from attest_mav.filters.base import AttitudeFilter, FilterInputs, FilterState
from attest_mav.samples import ImuSample


class Stepper:
    """The filter alone."""

    def step(
        self, one: AttitudeFilter, state: FilterState, dt_s: float, sample: ImuSample, inputs: FilterInputs
    ) -> FilterState:
        """The state ``dt_s`` later; see ``AttitudeFilter.step``."""
        return one.step(state, dt_s, sample, inputs)
