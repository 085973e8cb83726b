"""The base class of document kinds: a document is plain data that people edit, and that robots run or orders name."""

from __future__ import annotations

import inspect
import json
import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import Any, ClassVar

from skiros_py.errors import DescriptionError, DocumentError, DocumentFault, SkirosError, UnknownName
from skiros_py.skills.behaviour import Behaviour, check_behaviour, check_nodes, walk
from skiros_py.skills.conditions import ConditionType
from skiros_py.skills.parameters import Kind, Param, check_params
from skiros_py.skills.plain import Reader
from skiros_py.skills.references import check_references
from skiros_py.skills.skill import SkillDescription
from skiros_py.world.view import WorldView


@dataclass(frozen=True, slots=True)
class PaletteEntry:
    """A node that an editor offers.

    Attributes:
        kind: What it is called in a document.
        help: One sentence.
        fields: Its fields with their types, in order.
    """

    kind: str
    help: str
    fields: Mapping[str, str]


@dataclass(frozen=True, slots=True)
class Interface:
    """What a document takes and gives as a module.

    Attributes:
        params: Its parameters.
        outputs: Names of the values that its outcome has; nodes write them with :class:`~skiros_py.behaviours.Out`.
    """

    params: tuple[Param, ...] = ()
    outputs: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True)
class Review:
    """A document compared with the current world.

    Attributes:
        faults: Why it is refused, unless its current revision has the same faults.
        problems: What would not work now; it is accepted nevertheless.
        agents: The subsystems that would run parts of it now, by place.
    """

    faults: tuple[DocumentFault, ...] = ()
    problems: tuple[DocumentFault, ...] = ()
    agents: Mapping[str, str] = field(default_factory=lambda: MappingProxyType({}))


class DocumentKind:
    """A kind of document, found by the entry-point group ``skiros.documents``.

    A document is plain data. It is stored with its revisions and checked whenever it is written. A kind that returns
    a behaviour for it runs as a module called ``{kind}:{id}``, from its next start on.

    Class attributes:
        kind: Name of its entry point.
        formats: Text formats of import and export with their media types; the first one is the default. The API
            accepts no media types of web forms, such as ``text/plain``.
        for_orders: Whether orders name such documents, so that factory systems may read them.
    """

    kind: ClassVar[str]
    formats: ClassVar[Mapping[str, str]] = MappingProxyType({"json": "application/json"})
    for_orders: ClassVar[bool] = False

    def behaviour(self, document: Any, reader: Reader) -> Behaviour | None:
        """Returns what a document does; None if it is not a module.

        Args:
            document: The document, as plain data.
            reader: Reads behaviours in it.

        Raises:
            DescriptionError: Something in it is wrong; the error has the place.
        """

    def interface(self, document: Any) -> Interface:
        """Returns the parameters and outputs that a document declares; by default in ``parameters`` and ``outputs``.

        A parameter is written as ``{"key": "Speed", "type": "number", "help": "…", "unit": "m/s", "default": 0.2}``;
        without a default a run must be given a value.

        Raises:
            DescriptionError: Something in it is wrong; the error has the place.
        """
        if not isinstance(document, Mapping):
            return Interface()
        given, outputs = _listed(document, "parameters"), _listed(document, "outputs")
        params = tuple(_param(index, one) for index, one in enumerate(given))
        check_params(params, "of the document")
        if not all(isinstance(name, str) and name for name in outputs):
            raise DescriptionError(f"names of values, not {outputs!r:.100}", "outputs")
        return Interface(params, tuple(outputs))

    def check(self, document: Any, reader: Reader) -> tuple[DocumentFault, ...]:
        """Returns what is wrong with a document, regardless of the station; empty if nothing is."""
        try:
            interface = self.interface(document)
            found = self.behaviour(document, reader)
            if found is None:
                return ()
            check_behaviour(f"behaviour() of {self.kind}", found)
            check_nodes(found)
            written = {name for node in walk(found) for name in node.uses().writes}
            check_references(found, {*written, *(param.key for param in interface.params)}, "of the document")
            for index, name in enumerate(interface.outputs):
                if name not in written:
                    known = ", ".join(sorted(written)) or "nothing"
                    raise DescriptionError(f"no node writes '{name}'; written is {known}", f"outputs[{index}]")
        except DescriptionError as error:
            return (DocumentFault(error.place, error.text),)
        except DocumentError as error:
            return error.faults
        except SkirosError as error:
            return (DocumentFault("", str(error)),)
        except Exception as error:  # noqa: BLE001 - a plug-in's parser: its error is a fault of this document
            return (DocumentFault("", f"{self.kind} cannot be read: {type(error).__name__}: {error}"),)
        return ()

    def review(
        self,
        document: Any,  # noqa: ARG002
        world: WorldView,  # noqa: ARG002
        skills: Mapping[str, SkillDescription],  # noqa: ARG002
        conditions: Mapping[str, ConditionType],  # noqa: ARG002
    ) -> Review:
        """Compares a document that passed :meth:`check` with the current world; by default nothing is found.

        Args:
            document: The document.
            world: The world.
            skills: The skills offered now, by name.
            conditions: The conditions, by word.
        """
        return Review()

    def palette(self, reader: Reader) -> Sequence[PaletteEntry]:
        """Returns the nodes that an editor offers; by default all kinds of behaviour that are dataclasses."""
        entries = []
        for name in sorted(reader.kinds):
            cls = reader.kinds[name]
            fields = getattr(cls, "__dataclass_fields__", {})
            shown = {key: _written(one.type) for key, one in fields.items() if one.init and key != "kind"}
            entries.append(PaletteEntry(name, (cls.__doc__ or "").strip().partition("\n")[0], shown))
        return tuple(entries)

    def parse(self, text: str, format_: str) -> Any:
        """Imports a document.

        Args:
            text: The text.
            format_: One of ``formats``.

        Raises:
            DocumentError: It is not well-formed.
        """
        try:
            data = json.loads(text)
        except json.JSONDecodeError as error:
            raise DocumentError((DocumentFault("", error.msg, error.lineno, error.colno),)) from error
        seen: set[str] = set()
        for place, line, column in self.places(text, format_):
            if place in seen:
                raise DocumentError((DocumentFault(place, "the key is there twice", line, column),))
            seen.add(place)
        return data

    def places(self, text: str, format_: str) -> Iterator[tuple[str, int, int]]:  # noqa: ARG002
        """Yields the places of a text that :meth:`parse` accepts, each with its 1-based line and column.

        Faults of an imported document are reported with them. By default the text is JSON.
        """
        return places_of_json(text)

    def export(self, document: Any, format_: str) -> str:  # noqa: ARG002
        """Exports a document as text in one of ``formats``."""
        return json.dumps(document, indent=2, ensure_ascii=False)

    @classmethod
    def require_format(cls, format_: str) -> None:
        """Requires that documents of this kind have a format.

        Raises:
            UnknownName: They do not.
        """
        if format_ not in cls.formats:
            raise UnknownName("format", format_, cls.formats, where=f"of {cls.kind} documents")


_TOKEN = re.compile(r'"(?:[^"\\]|\\.)*"|[][{},]|[^]\s[{},:"]+')


def places_of_json(text: str) -> Iterator[tuple[str, int, int]]:
    """Yields all places of a JSON text, in order; one of an object is where its key begins.

    Args:
        text: The text, which is well-formed.

    Yields:
        The place, as in faults ("children[1].seconds"), with its 1-based line and column.
    """
    steps: list[str | int | None] = []  # into each open object and list; None before a key
    line, start = 1, 0
    for token in _TOKEN.finditer(text):
        said = token[0]
        if said in "}]":
            steps.pop()
            continue
        if said == ",":
            steps[-1] = steps[-1] + 1 if isinstance(steps[-1], int) else None
            continue
        is_key = bool(steps) and steps[-1] is None
        if is_key:
            steps[-1] = json.loads(said)
        if is_key or not steps or isinstance(steps[-1], int):
            line, start = line + text.count("\n", start, token.start()), token.start()
            place = "".join(f"[{step}]" if isinstance(step, int) else f".{step}" for step in steps)
            yield place.lstrip("."), line, start - text.rfind("\n", 0, start)
        if said in "{[":
            steps.append(None if said == "{" else 0)


def _written(type_: Any) -> str:
    """Returns the type of a field as its author writes it."""
    return type_ if isinstance(type_, str) else re.sub(r"(\w+\.)+(?=\w)", "", inspect.formatannotation(type_))


def _listed(document: Mapping[str, Any], key: str) -> Sequence[Any]:
    value = document.get(key, ())
    if not isinstance(value, list | tuple):
        raise DescriptionError(f"it must be a list, not {value!r:.100}", key)
    return value


_OPTIONS = ("key", "type", "help", "default", "unit", "length")


def _param(index: int, data: Any) -> Param:
    place = f"parameters[{index}]"
    if not isinstance(data, Mapping) or not {"key", "type", "help"} <= data.keys():
        raise DescriptionError(f"a parameter has a key, a type and a help, not {data!r:.100}", place)
    if unknown := [key for key in data if key not in _OPTIONS]:
        raise DescriptionError(f"unknown: {', '.join(unknown)}; there is {', '.join(_OPTIONS)}", place)
    return Param(**data, kind=Kind.OFFLINE if "default" in data else Kind.ONLINE)
