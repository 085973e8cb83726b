"""Sentences for people: English texts that keep what they are made of, so that a page can say them in its language."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping, Sequence
from functools import reduce
from types import NoneType
from typing import Any, Self

_FIELD = re.compile(r"\{(\w+):?([^{}]*)\}")


class Message(str):
    """An English sentence, with the template and the values that it is made of.

    It is a text like any other for whatever does not know of messages, such as logs and the command line. The template
    identifies it to translators, as in gettext. ``str`` of a message, or of an exception whose text is one, returns
    the message itself. Other operations on texts (``+``, f-strings) return a plain text, which stays English.

    Args:
        template: The sentence, with fields as for ``str.format``: ``"{part} is {width:.3f} m wide"``.
        values: The values of the fields: ids and names, numbers, other messages; of anything else its text.

    Attributes:
        template: The sentence with its fields.
        values: The values by field.
    """

    __slots__ = ("template", "values")

    template: str
    values: Mapping[str, object]

    def __new__(cls, template: str, /, **values: object) -> Self:
        """Writes the sentence."""
        self = str.__new__(cls, template.format_map(values))
        self.template = template
        self.values = {name: one if isinstance(one, str | int | float) else str(one) for name, one in values.items()}
        return self

    def __str__(self) -> str:
        return self

    def __reduce__(self) -> tuple[Any, ...]:
        return _restored, (self.template, self.values)

    @property
    def data(self) -> dict[str, Any]:
        """The template, without formats of numbers, and the values: texts, or data of messages."""
        fields = _FIELD.findall(self.template)
        said = {name: format(self.values[name], spec) if spec else str(self.values[name]) for name, spec in fields}
        values = {name: text.data if isinstance(text, Message) else text for name, text in said.items()}
        return {"template": _FIELD.sub(r"{\1}", self.template), "values": values}


def _restored(template: str, values: Mapping[str, Any]) -> Message:
    return Message(template, **values)


def read_message(data: Mapping[str, Any] | str) -> str:
    """Returns the message of which this is the :attr:`~Message.data`; a text as it is."""
    if isinstance(data, str):
        return data
    return Message(data["template"], **{name: read_message(one) for name, one in data["values"].items()})


def message_data(text: str) -> dict[str, Any] | str:
    """Returns what :func:`read_message` reads: the data of a message; another text as it is."""
    return text.data if isinstance(text, Message) else text


def with_values(text: object, values: Mapping[str, object]) -> object:
    """Returns the message of a template and its values; a text without values as it is."""
    return Message(str(text), **values) if values else text


def cut(text: str, most: int) -> str:
    """Returns at most so many characters of a text; a message that is short enough stays one."""
    return text if len(text) <= most else text[:most]


_WITHOUT_MESSAGES = (str, int, float, bytes, NoneType)
"""Most of what an answer holds; recognized faster than an abstract class."""


def messages_in(value: object) -> dict[str, dict[str, Any]]:
    """Returns the data of all messages in a value made of mappings and lists, by their English text."""
    found: dict[str, dict[str, Any]] = {}
    _find_messages(value, found)
    return found


def _find_messages(value: object, found: dict[str, dict[str, Any]]) -> None:
    if isinstance(value, Message):
        found[value] = value.data
    elif isinstance(value, _WITHOUT_MESSAGES):
        return
    elif isinstance(value, Iterable):
        for one in value.values() if isinstance(value, Mapping) else value:
            _find_messages(one, found)


def joined(separator: str, texts: Iterable[str]) -> Message:
    """Returns texts in a row as one message."""
    parts = {f"part{number}": text for number, text in enumerate(texts)}
    return Message(separator.join(f"{{{name}}}" for name in parts), **parts)


_SHOWN = 4
"""How many names a list shows at most."""


def listed(names: Iterable[str], *, either: bool = False) -> str:
    """Returns names as a readable list, "a, b and c"; if there are very many, only the first.

    Args:
        names: The names.
        either: True for "a, b or c".
    """
    all_ = list(names)
    shown = all_ if len(all_) <= _SHOWN else [*all_[:_SHOWN], Message("{count} more", count=len(all_) - _SHOWN)]
    if len(shown) < 2:
        return shown[0] if shown else ""
    rest, last = joined(", ", shown[:-1]), shown[-1]
    return Message("{rest} or {last}", rest=rest, last=last) if either else all_of((rest, last))


def all_of(texts: Sequence[str]) -> str:
    """Returns texts joined by "and"."""
    first, *others = texts or ("",)
    return reduce(lambda rest, last: Message("{rest} and {last}", rest=rest, last=last), others, first)
