"""The settings in force: those of the configuration, with the values of our parameters that stations have set."""

from dataclasses import replace
from typing import Final

from attest_mav.estimation.pipeline import PipelineSettings
from attest_mav.mavlink.component.companion import Companion
from attest_mav.mavlink.component.own_parameters import RATE
from attest_mav.service.assembly import retuned
from attest_mav.service.settings import ServiceSettings


class Tuning:
    """Holds the settings, and puts the rate of the attitude in force; the others are for the pipelines."""

    def __init__(self, companion: Companion, settings: ServiceSettings) -> None:
        self.settings = settings
        self._companion: Final = companion

    @property
    def pipeline(self) -> PipelineSettings:
        """The settings of a pipeline."""
        return self.settings.pipeline

    def use(self, settings: ServiceSettings) -> None:
        """Take other settings of the same links. A parameter of ours that a station has set stays as it was set."""
        parameters = self._companion.own_parameters
        parameters.configure(settings.companion.parameters)
        pipeline = retuned(settings.pipeline, parameters) if parameters.table else settings.pipeline
        self.settings = replace(settings, pipeline=pipeline)
        hz = parameters.value(RATE.name) if parameters.table else settings.companion.publish_hz
        for port, port_settings in zip(self._companion.ports, settings.ports, strict=True):
            port.use(port_settings, hz)

    def take_change(self) -> bool:
        """Take the values of our own parameters, where they have changed; whether they have."""
        parameters = self._companion.own_parameters
        if not parameters.take_change():
            return False
        self.settings = replace(self.settings, pipeline=retuned(self.settings.pipeline, parameters))
        for port in self._companion.ports:
            port.set_rate(parameters.value(RATE.name))
        return True
