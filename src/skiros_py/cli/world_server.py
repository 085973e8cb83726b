"""The world of a server for commands: its responses are converted to the types of a world in this process."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator, Mapping, Sequence
from decimal import Decimal
from functools import partial
from itertools import islice
from pathlib import Path
from typing import Any

from pydantic import ValidationError

from skiros_py.api.queries import Query
from skiros_py.api.wire import fault_words
from skiros_py.api.world import Change as ChangeInfo
from skiros_py.api.world import ElementDetails, ElementPatch, Learned, NewElement, Written
from skiros_py.cli.world_open import History, Shown
from skiros_py.client import Client
from skiros_py.errors import UsageError
from skiros_py.files import RDF_TYPES, read_text
from skiros_py.geometry import Pose
from skiros_py.world.change import Change
from skiros_py.world.element import Element, Stamp, Value
from skiros_py.world.journal.records import Entry, decode_change
from skiros_py.world.queries.answering import Binding, Constructed, Result, Table, Text

_PAGE = 1000
_CHANGES = 200
"""Changes of one page."""
_LONGEST_AUTHOR = 100


class ServedWorld:
    """The world of a server.

    Args:
        client: Reaches the server.
    """

    def __init__(self, client: Client) -> None:
        self._client = client

    def show(self, element: str) -> Shown:
        """Returns an element with its relations."""
        found = self._client.elements.get(element)
        own = {name: known.value for name, known in found.properties.items() if known.origin == "own"}
        is_whole = found.relations_total == len(found.relations)
        relations = found.relations if is_whole else _all(partial(self._client.elements.relations, element))
        statements = [(r.subject, r.relation, r.object) for r in relations]
        return Shown(_element(found, own), statements, Stamp(found.version, found.changed_at))

    def history(self, element: str | None, last: int | None) -> History:
        """Returns the changes of an element, or all."""
        topics = self._client
        read = topics.world.changes if element is None else partial(topics.elements.history, element)
        limit = _CHANGES if last is None else min(last, _CHANGES)
        entries: list[Entry] = []
        for one in islice(_all(partial(read, newest_first=True), limit), last):
            change = self._whole(one)
            entries.append(Entry(change, one.written.timestamp(), len(change.edits)))
        return History(topics.world.get().remembered_from, entries[::-1])

    def undo(self, author: str) -> Change:
        """Undoes the last edit of a person."""
        self._write_as(author)
        return self._whole(self._client.world.undo())

    def learned(self) -> Sequence[Element]:
        """Returns the learned concepts."""
        return [_element(one, one.properties) for one in _all(self._client.learned.list)]

    def forget(self, concept: str, author: str) -> Change:
        """Deletes a learned concept with its parts."""
        self._write_as(author)
        change = self._written(self._client.learned.forget(concept))
        assert change is not None
        return change

    def forget_runs(self, of: Mapping[str, str], author: str) -> Change | None:
        """Deletes what was learned from runs; None if there is nothing."""
        self._write_as(author)
        return self._written(self._client.learned.forget_runs(**of))

    def teach(self, new: NewElement, author: str) -> Change | None:
        """Adds a learned concept."""
        self._write_as(author)
        return self._written(self._client.learned.add(new))

    def edit_learned(self, concept: str, patch: ElementPatch, author: str) -> Change | None:
        """Changes a learned concept; None if it is so already."""
        self._write_as(author)
        return self._written(self._client.learned.edit(concept, patch))

    def import_learned(self, file: Path, author: str, *, replace: bool) -> Change | None:
        """Adds the learned concepts of a file; None if there is nothing new in it."""
        self._write_as(author)
        kind = RDF_TYPES.get(file.suffix, "text/turtle")
        reason = f"imports {file.name}"
        return self._written(
            self._client.learned.load(read_text(file), media_type=kind, replace=replace, reason=reason)
        )

    def learned_turtle(self) -> str:
        """Returns the learned concepts as the text of a Turtle file."""
        return self._client.learned.export()

    def scene_turtle(self) -> str:
        """Returns the scene as the text of a Turtle file."""
        return self._client.scenes.turtle()

    def query(self, sparql: str, bindings: Mapping[str, Binding], *, entailed: bool, time_limit: float) -> Result:
        """Runs a SPARQL query; a server has lower limits of time and rows."""
        answer = self._client.queries.ask(_question(sparql, bindings, entailed=entailed, time_limit=time_limit))
        return _result(answer.model_dump())

    def _write_as(self, author: str) -> None:
        name = "".join(c for c in author if c.isprintable())[:_LONGEST_AUTHOR].strip()
        self._client.http.headers.update([(b"X-Skiros-User", name.encode())])

    def _written(self, found: Written) -> Change | None:
        return None if found.change is None else self._whole(found.change)

    def _whole(self, found: ChangeInfo) -> Change:
        """Returns a change with all its edits."""
        data, following = found.model_dump(), found.next
        while following is not None:
            more = self._client.world.change(found.number, limit=_PAGE, cursor=following)
            data["edits"] += more.edits
            following = more.next
        del data["written"]
        return decode_change(json.dumps(data))


def _all(read: Callable[..., Any], limit: int = _PAGE) -> Iterator[Any]:
    """Yields the items of all pages; further pages are requested when needed."""
    cursor = None
    while True:
        page = read(limit=limit, cursor=cursor)
        yield from page.items
        if page.next is None:
            return
        cursor = page.next


def _element(found: ElementDetails | Learned, values: Mapping[str, Any]) -> Element:
    return Element(found.id, found.class_, found.label, {name: _value(value) for name, value in values.items()})


def _value(found: Any) -> Value:
    """Returns a value that came as plain data."""
    if isinstance(found, dict):
        return Pose(tuple(found["position"]), tuple(found["orientation"]))
    value: Value = tuple(found) if isinstance(found, list) else found
    return value


# ---------------------------------------------------------------- queries


def _question(sparql: str, bindings: Mapping[str, Binding], *, entailed: bool, time_limit: float) -> Query:
    bound = {name: _bound(value) for name, value in bindings.items()}
    try:
        return Query.model_validate(
            {"query": sparql, "bindings": bound, "entailed": entailed, "time_limit": time_limit}
        )
    except ValidationError as error:
        first = error.errors()[0]
        where = first["loc"][0]
        raise UsageError(
            f"{where}: {fault_words(first)} (a server owns the data directory, and takes no more)"
        ) from None


def _bound(value: Binding) -> object:
    if isinstance(value, Text):
        return {"text": str(value)}
    return {"decimal": f"{value:f}"} if isinstance(value, Decimal) else value


def _result(answer: Mapping[str, Any]) -> Result:
    if answer["form"] == "ASK":
        return bool(answer["answer"])
    if answer["form"] == "SELECT":
        rows = [{name: None if v is None else _value(v) for name, v in row.items()} for row in answer["rows"]]
        return Table(tuple(answer["variables"]), rows)
    statements = tuple((subject, predicate, _value(value)) for subject, predicate, value in answer["statements"])
    return Constructed(statements, answer["turtle"])
