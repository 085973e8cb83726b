"""The values of all parameters of one call."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import Any

from skiros_py.errors import UnknownName, UsageError
from skiros_py.skills.parameters.param import Kind, Param
from skiros_py.skills.parameters.values import read_value
from skiros_py.world.view import WorldView

Arguments = Mapping[str, Any]
"""Value by key of every parameter; None where it is not specified."""


def read_arguments(params: Sequence[Param], given: Mapping[str, Any], view: WorldView) -> Arguments:
    """Checks the values that somebody gives for a call, and adds the defaults.

    Args:
        params: The parameters.
        given: Values by key: from Python, from JSON, or texts of a command line; None is like left out.
        view: Where elements and classes are looked up.

    Raises:
        UnknownName: The one thing wrong is an unknown parameter, element or class.
        UsageError: Something in them is wrong; with several things the message says each.
    """
    faults: list[UsageError] = []
    by_key = {param.key: param for param in params}
    values = {param.key: param.default for param in params}
    for key, value in given.items():
        if value is None and key in by_key:
            continue
        try:
            values[key] = _read(key, value, by_key, view)
        except UsageError as fault:
            faults.append(fault)
    if len(faults) > 1:
        raise UsageError("; ".join(str(fault).rstrip(".") for fault in faults))
    if faults:
        raise faults[0]
    return values


def missing(params: Iterable[Param], values: Mapping[str, Any]) -> tuple[str, ...]:
    """Returns the keys of required parameters that are not specified: a module does not run before all are."""
    return tuple(param.key for param in params if param.kind.is_required and values.get(param.key) is None)


def _read(key: str, value: Any, by_key: Mapping[str, Param], view: WorldView) -> Any:
    if key not in by_key:
        raise UnknownName("parameter", key, by_key)
    param = by_key[key]
    if param.kind is Kind.CONFIG:
        raise UsageError(f"parameter {key} is fixed when the module is loaded: it cannot be given at a call")
    return read_value(param, value, view)
