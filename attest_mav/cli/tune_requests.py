"""The replays of ``attest-mav tune``: by a filter of the package, or one of one's own, at a point of the search."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any, Final

from attest_mav.cli.config import load
from attest_mav.cli.replay_options import AUTO, configured
from attest_mav.config.changes import value_of
from attest_mav.config.text import value_text
from attest_mav.errors import ConfigError, UsageError
from attest_mav.evaluation.tuning.space import Point, parse_parameter
from attest_mav.filters.own import Parameter as Value
from attest_mav.filters.own import own_filter, own_parameters, search_here
from attest_mav.replay.request import Request

Options = tuple[str | None, tuple[str, ...]]
"""A configuration file, and changes of its values."""


class RequestMaker:
    """Makes the replay by a filter of the package at a point, and tells its parameters.

    texts: the values that each parameter may have, as ``parse_parameter`` takes them.
    """

    def __init__(self, name: str, texts: Sequence[str], options: Options, base: Request) -> None:
        self.name: Final = name
        self.base: Final = base
        self._file, self._changes = options
        known = list(self._configured())
        self.parameters: Final = [parse_parameter(text, known, name) for text in texts]
        """The parameters that are searched."""
        check_names([one.name for one in self.parameters])

    def of(self, point: Point) -> Request:
        """The request; UsageError for a value that the filter cannot have."""
        try:
            filters, pipeline = configured(self.name, self._file, self._all_changes(point))
        except ConfigError as error:
            raise UsageError(f"--param: {str(error).removeprefix('--set: ')}") from None
        return Request(filters, window=self.base.window, pipeline=pipeline)

    def values(self, point: Point) -> dict[str, Any]:
        """The values of the parameters that are searched."""
        every = load(self._file, self._all_changes(point)).filter.parameters(self.name)
        return {one.name: every[one.name] for one in self.parameters}

    def toml(self, point: Point) -> str:
        """The same for a configuration."""
        return _table(f"filter.{self.name}", self.values(point))

    def _configured(self) -> dict[str, Any]:
        """All parameters of the filter without the search."""
        return load(self._file, self._changes).filter.parameters(self.name)

    def _all_changes(self, point: Point) -> tuple[str, ...]:
        """Those of the user and those of the point; none for ``CONFIGURED``."""
        return (*self._changes, *[f"filter.{self.name}.{name}={text}" for name, text in self._texts(point).items()])

    def _texts(self, point: Point) -> dict[str, str]:
        """The value of each parameter at a point; none for ``CONFIGURED``."""
        chosen = zip(self.parameters, point, strict=True) if point else ()
        return {one.name: one.text(position) for one, position in chosen}


class OwnRequestMaker(RequestMaker):
    """The same for a filter of one's own, MODULE:CLASS."""

    def of(self, point: Point) -> Request:
        """The request; UsageError for a value that the filter refuses."""
        _, pipeline = configured(AUTO, self._file, self._changes)
        return Request((own_filter(self.name, self._given(point)),), window=self.base.window, pipeline=pipeline)

    def values(self, point: Point) -> dict[str, Any]:
        """The values of the parameters that are searched; None for one that is given neither here nor by its class."""
        every = {**own_parameters(self.name), **self._given(point)}
        return {one.name: every[one.name] for one in self.parameters}

    def toml(self, point: Point) -> str:
        """The same for a configuration, with the other parameters that it has."""
        parameters = {**self._given(()), **self.values(point)}
        return _table("filter.own", {"class": self.name}) + "\n" + _table("filter.own.parameters", parameters)

    def _configured(self) -> dict[str, Any]:
        search_here(str(Path.cwd()))
        return own_parameters(self.name)

    def _given(self, point: Point) -> dict[str, Value]:
        """The parameters of the configuration's table, if that is this class's, and those of the point."""
        own = load(self._file, self._changes).filter.own
        table = own.parameters if own.filter_class == self.name else {}
        return {**table, **{name: value_of(text) for name, text in self._texts(point).items()}}


def check_names(names: list[str]) -> None:
    """Refuse a parameter that is given twice."""
    for name in names:
        if names.count(name) > 1:
            raise UsageError(f"--param {name}: given twice; expected all of its values in one")


def _table(name: str, values: dict[str, Any]) -> str:
    """A table of TOML."""
    return "\n".join([f"[{name}]", *[f"{key} = {value_text(value)}" for key, value in values.items()], ""])
