"""Configuration of modules: values that hold for every run of a module, given as "module.key"."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from skiros_py.errors import UnknownName
from skiros_py.skills.parameters import Kind, params_of, read_value
from skiros_py.skills.primitive import Primitive
from skiros_py.world.view import WorldView


def configuration_of(
    module: str, cls: type[Primitive[Any]], given: Mapping[str, Any], view: WorldView
) -> dict[str, Any]:
    """Reads what is given for the configuration parameters of a primitive.

    Args:
        module: Name of the primitive.
        cls: The primitive.
        given: All values that were given, by "module.key".
        view: The world, for elements and classes.

    Raises:
        UnknownName: It has no such configuration parameter.
        UsageError: A value is not of the parameter's type.
    """
    params = {p.key: p for p in params_of(cls.Params) if p.kind is Kind.CONFIG}
    own = {key: value for of, key, value in _split(given) if of == module}
    for key in own:
        if key not in params:
            raise UnknownName("configuration parameter", key, params, where=f"of {module}")
    return {key: read_value(params[key], value, view) for key, value in own.items()}


def check_configuration(
    given: Mapping[str, Any], primitives: Mapping[str, type[Primitive[Any]]], view: WorldView
) -> None:
    """Refuses what no module would ever read: a slip of the pen must not leave a robot with the values it had.

    Args:
        given: All values that were given, by "module.key".
        primitives: All primitives by name; those that something is given for are loaded.
        view: The world, for elements and classes.

    Raises:
        UnknownName: There is no such module, or it has no such configuration parameter.
        UsageError: A value is not of the parameter's type.
    """
    for module in dict.fromkeys(module for module, _, _ in _split(given)):
        if module not in primitives:
            raise UnknownName("primitive", module, primitives, where="in the configuration")
        configuration_of(module, primitives[module], given, view)


def _split(given: Mapping[str, Any]) -> list[tuple[str, str, Any]]:
    """Takes "module.key" apart; names of modules have no dot."""
    parts = {name: name.partition(".") for name in given}
    return [(module, key, given[name]) for name, (module, _, key) in parts.items()]
