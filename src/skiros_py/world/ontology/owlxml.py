"""Reads OWL/XML by owlready2's converter, which needs no database, follows no import and asks no network."""

from __future__ import annotations

import io
import itertools
import re
from pathlib import Path

import pyoxigraph as ox

from skiros_py.errors import FileError

__all__ = ["parse_owl_xml"]


def parse_owl_xml(path: Path, text: str) -> tuple[ox.Triple, ...]:
    """Returns the statements of an OWL/XML text; keys and rules are passed over.

    Raises:
        FileError: It does not mean anything; with the line.
    """
    # Imported here: it takes a third of a second, and few ontologies need it.
    from owlready2.owlxml_2_ntriples import OwlReadyOntologyParsingError, parse

    sink = _Sink()
    try:
        parse(io.BytesIO(text.encode()), sink.relation, sink.value, sink.new_blank)
    except OwlReadyOntologyParsingError as error:
        raise _fault(path, str(error), error.__cause__) from None
    return tuple(sink.triples)


class _Sink:
    """Takes what the converter finds, as texts, and makes triples of it."""

    def __init__(self) -> None:
        self.triples: list[ox.Triple] = []
        self._blanks: dict[str, ox.BlankNode] = {}
        self._numbers = itertools.count()

    def new_blank(self) -> str:
        name = f"_:{next(self._numbers)}"
        self._blanks[name] = ox.BlankNode()
        return name

    def relation(self, subject: str, predicate: str, object_: str) -> None:
        self.triples.append(ox.Triple(self._node(subject), ox.NamedNode(predicate), self._node(object_)))

    def value(self, subject: str, predicate: str, value: object, type_: str = "") -> None:
        text = value if isinstance(value, str) else str(value)
        if type_.startswith("@"):
            literal = ox.Literal(text, language=type_.removeprefix("@"))
        else:
            literal = ox.Literal(text, datatype=ox.NamedNode(type_)) if type_ else ox.Literal(text)
        self.triples.append(ox.Triple(self._node(subject), ox.NamedNode(predicate), literal))

    def _node(self, name: str) -> ox.NamedNode | ox.BlankNode:
        return self._blanks[name] if name in self._blanks else ox.NamedNode(name)


def _fault(path: Path, message: str, cause: BaseException | None) -> FileError:
    line = re.search(r"line (\d+)", message)
    if isinstance(cause, KeyError):
        what = f"'{cause.args[0]}' is missing here, as prefix or as attribute"
    else:
        what = str(cause or message)
    return FileError(path, f"not OWL/XML: {what[:300]}", line=int(line.group(1)) if line else None)
