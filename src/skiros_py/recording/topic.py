"""Topics of a recording: a name, a schema and an encoder each.

The built-in topics are defined where their messages are made: ``recorder.py`` (runs, log, tasks, trace, world and
devices), ``pictures.py`` and ``station/recordings/topics.py`` (pictures and points). Plug-ins bring further ones.
"""

from __future__ import annotations

import dataclasses
import enum
import logging
import math
from collections.abc import Callable, Mapping
from functools import partial
from typing import TYPE_CHECKING, Any, get_args, get_origin, get_type_hints

import numpy as np

from skiros_py.plugins.loading import attempt, load_plugins
from skiros_py.plugins.plugin import PluginFault
from skiros_py.recording.foxglove import Json, Schema

if TYPE_CHECKING:
    from skiros_py.recording.recorder import Recorder

_log = logging.getLogger(__name__)

GROUP = "skiros.topics"
"""Entry points of this group name functions that take a :class:`~skiros_py.recording.Recorder` which has started."""

_DIGITS = 6


def plain(value: Any) -> Any:
    """Returns a value as plain data: dataclasses as objects, enumerations as their values, numbers rounded to 1e-6."""
    if isinstance(value, enum.Enum):
        return value.value
    if isinstance(value, float):
        return round(value, _DIGITS) if math.isfinite(value) else None
    if value is None or isinstance(value, bool | int | str):
        return value
    if dataclasses.is_dataclass(value):
        return {field.name: plain(getattr(value, field.name)) for field in dataclasses.fields(value)}
    if isinstance(value, Mapping):
        return {str(key): plain(one) for key, one in value.items()}
    if isinstance(value, np.generic | np.ndarray):
        return plain(value.tolist())
    if isinstance(value, list | tuple | set | frozenset):
        return [plain(one) for one in value]
    return str(value)


@dataclasses.dataclass(frozen=True)
class Topic:
    """One kind of message in a recording.

    Attributes:
        name: Its name ("/runs").
        schema: JSON schema of its messages.
        encode: Makes a message of a time in the recording [s] and a value; called in the writer's thread, so values
            must not change any more.
        every: Where room runs short, only one message in so many seconds is kept of the older ones [s]; None for
            messages of which all are needed.
    """

    name: str
    schema: Schema
    encode: Callable[[float, Any], Json] = lambda _time, value: plain(value)
    every: float | None = None


def own_schema(kind: type) -> Schema:
    """Returns the schema of a dataclass's messages as :func:`plain` makes them."""
    return Schema(f"skiros.{kind.__name__}", _object(kind))


def _object(kind: type) -> dict[str, Any]:
    hints = get_type_hints(kind)
    found = {field.name: _property(hints[field.name]) for field in dataclasses.fields(kind)}
    properties = {name: schema for name, schema in found.items() if schema is not None}
    return {"type": "object", "properties": properties, "required": list(properties)}


def _property(hint: Any) -> Json | None:
    """Returns the schema of a field; None for what Foxglove cannot read, such as a value that may be None."""
    origin, arguments = get_origin(hint) or hint, get_args(hint)
    if not isinstance(origin, type):
        return None
    if dataclasses.is_dataclass(origin):
        return _object(origin)
    if issubclass(origin, enum.Enum):
        return _property(type(next(iter(origin)).value))
    if issubclass(origin, Mapping):
        return {"type": "object"}
    if issubclass(origin, tuple | list | frozenset | set):
        items = _property(arguments[0]) if len({*arguments} - {...}) == 1 else None
        return None if items is None or items.get("type") == "array" else {"type": "array", "items": items}
    return next(({"type": name} for known, name in _TYPES if issubclass(origin, known)), None)


_TYPES = ((bool, "boolean"), (int, "integer"), (float, "number"), (str, "string"))


def record_plugins(recorder: Recorder) -> None:
    """Lets the plug-ins of the group ``skiros.topics`` add their topics; one that fails is reported in the log."""
    plugins, broken = load_plugins(GROUP)
    faults = list(broken)
    for plugin in plugins:
        with recorder.runtime.cycle.guest(f"topic '{plugin.name}' of {plugin.distribution}"):
            tried = attempt(plugin, partial(plugin.value, recorder))
        if isinstance(tried, PluginFault):
            faults.append(tried)
    for fault in faults:
        _log.warning("%s", fault)
