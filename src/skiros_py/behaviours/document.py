"""Kinds of document: trees, nets and graphs that people edit and robots run."""

from __future__ import annotations

import json
from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, ClassVar

from skiros_py.errors import DescriptionError, SkirosError, UnknownName, UsageError
from skiros_py.skills.behaviour import Behaviour, check_behaviour, check_nodes, walk
from skiros_py.skills.parameters import Kind, Param, check_params
from skiros_py.skills.plain import Reader
from skiros_py.skills.references import check_references


@dataclass(frozen=True, slots=True)
class DocumentFault:
    """Something that is wrong with a document.

    Attributes:
        place: Where in the document ("children[1].module"); empty for the whole.
        text: What is wrong, in a sentence.
    """

    place: str
    text: str

    def __str__(self) -> str:
        return f"{self.place}: {self.text}" if self.place else self.text


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


class DocumentKind(ABC):
    """A kind of document, found by the entry-point group ``skiros.documents``.

    A document is plain data; it is stored with its revisions, checked whenever it is written, and runs as a module
    called ``{kind}:{id}`` from its next start on.

    Class attributes:
        kind: Name of its entry point.
        formats: In which text formats it is imported and exported.
    """

    kind: ClassVar[str]
    formats: ClassVar[tuple[str, ...]] = ("json",)

    @abstractmethod
    def behaviour(self, document: Any, reader: Reader) -> Behaviour:
        """Returns what a document does.

        Args:
            document: The document, as plain data.
            reader: Reads behaviours in it.

        Raises:
            DescriptionError: Something in it is wrong; the text begins with the place.
        """

    def interface(self, document: Any) -> Interface:
        """Returns the parameters and outputs that a document declares; by default in ``parameters`` and ``outputs``.

        A parameter is written as ``{"key": "Speed", "type": "number", "help": "…", "unit": "m/s", "default": 0.2}``;
        without a default a run must be given a value.

        Raises:
            DescriptionError: Something in it is wrong; the text begins with the place.
        """
        if not isinstance(document, Mapping):
            return Interface()
        given, outputs = document.get("parameters", ()), document.get("outputs", ())
        params = tuple(_param(index, one) for index, one in enumerate(given))
        check_params(params, "of the document")
        if not all(isinstance(name, str) and name for name in outputs):
            raise DescriptionError(f"outputs: names of values, not {outputs!r:.100}")
        return Interface(params, tuple(outputs))

    def check(self, document: Any, reader: Reader) -> tuple[DocumentFault, ...]:
        """Returns what is wrong with a document; nothing where it can run."""
        try:
            interface = self.interface(document)
            found = self.behaviour(document, reader)
            check_behaviour(f"behaviour() of {self.kind}", found)
            check_nodes(found)
            written = {name for node in walk(found) for name in node.uses().writes}
            check_references(found, {*written, *(param.key for param in interface.params)}, "of the document")
            for index, name in enumerate(interface.outputs):
                if name not in written:
                    known = ", ".join(sorted(written)) or "nothing"
                    raise DescriptionError(f"outputs[{index}]: no node writes '{name}'; written is {known}")
        except DescriptionError as error:
            place, colon, text = str(error).partition(": ")
            return (DocumentFault(place, text) if colon else DocumentFault("", place),)
        except SkirosError as error:
            return (DocumentFault("", str(error)),)
        except Exception as error:  # noqa: BLE001 - a plug-in's parser: its error is a fault of this document
            return (DocumentFault("", f"{self.kind} cannot be read: {type(error).__name__}: {error}"),)
        return ()

    def palette(self, reader: Reader) -> Sequence[PaletteEntry]:
        """Returns the nodes that an editor offers; by default all kinds of behaviour that are dataclasses."""
        entries = []
        for name in sorted(reader.kinds):
            cls = reader.kinds[name]
            fields = getattr(cls, "__dataclass_fields__", {})
            shown = {key: str(one.type) for key, one in fields.items() if one.init and key != "kind"}
            entries.append(PaletteEntry(name, (cls.__doc__ or "").strip().partition("\n")[0], shown))
        return tuple(entries)

    def parse(self, text: str, format_: str = "json") -> Any:
        """Imports a document.

        Raises:
            UsageError: It is not well-formed; the text names line and column.
        """
        self._require_format(format_)
        try:
            return json.loads(text)
        except json.JSONDecodeError as error:
            raise UsageError(f"line {error.lineno}, column {error.colno}: {error.msg}") from error

    def export(self, document: Any, format_: str = "json") -> str:
        """Exports a document as text.

        Raises:
            UnknownName: There is no such format.
        """
        self._require_format(format_)
        return json.dumps(document, indent=2, ensure_ascii=False)

    def _require_format(self, format_: str) -> None:
        if format_ not in self.formats:
            raise UnknownName("format", format_, self.formats, where=f"of {self.kind} documents")


_OPTIONS = ("key", "type", "help", "default", "unit", "length")


def _param(index: int, data: Any) -> Param:
    place = f"parameters[{index}]"
    if not isinstance(data, Mapping) or not {"key", "type", "help"} <= data.keys():
        raise DescriptionError(f"{place}: a parameter has a key, a type and a help, not {data!r:.100}")
    if unknown := [key for key in data if key not in _OPTIONS]:
        raise DescriptionError(f"{place}: unknown: {', '.join(unknown)}; there is {', '.join(_OPTIONS)}")
    return Param(**data, kind=Kind.OFFLINE if "default" in data else Kind.ONLINE)


class Tree(DocumentKind):
    """A tree of behaviours of all kinds, written down as they are: ``{"type": "sequence", "children": […]}``.

    A tree with parameters or outputs stands in ``body``: ``{"parameters": […], "outputs": […], "body": {…}}``.
    """

    kind: ClassVar[str] = "tree"

    def behaviour(self, document: Any, reader: Reader) -> Behaviour:
        """Reads the tree."""
        if isinstance(document, Mapping) and "body" in document:
            unknown = sorted(document.keys() - {"parameters", "outputs", "body"})
            if unknown:
                raise DescriptionError(f"{unknown[0]}: a tree has parameters, outputs and a body, and nothing else")
            document = document["body"]
        return reader.behaviour(document)
