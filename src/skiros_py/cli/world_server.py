"""The world of a server for commands: its responses are converted to the types of a world in this process."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator, Mapping, Sequence
from decimal import Decimal
from itertools import islice
from typing import TYPE_CHECKING, Any, Protocol, TypeVar

from skiros_py.cli.world_open import History, Shown
from skiros_py.errors import UsageError

if TYPE_CHECKING:
    from skiros_py.api.queries import Query
    from skiros_py.api.world import Change as ChangeInfo
    from skiros_py.api.world import ChangePage, ElementDetails, Learned, Relation
    from skiros_py.client import Client
    from skiros_py.world.change import Change
    from skiros_py.world.element import Element, Value
    from skiros_py.world.journal import Entry
    from skiros_py.world.ontology import Ontology
    from skiros_py.world.queries import Binding, Result

_PAGE = 1000
_CHANGES = 200
"""Changes of one page."""
_LONGEST_AUTHOR = 100
_Item = TypeVar("_Item", covariant=True)


class ServedWorld:
    """The world of a server.

    Args:
        client: Reaches the server.
    """

    def __init__(self, client: Client) -> None:
        self._client = client

    def show(self, element: str) -> Shown:
        """Returns an element with its relations."""
        from skiros_py.world.element import Stamp

        found = self._client.elements.get(element)
        statements = [(r.subject, r.relation, r.object) for r in self._relations(found)]
        return Shown(_element(found), statements, Stamp(found.version, found.changed_at))

    def _relations(self, found: ElementDetails) -> Iterator[Relation]:
        if found.relations_total == len(found.relations):
            return iter(found.relations)
        return _all(lambda cursor: self._client.elements.relations(found.id, limit=_PAGE, cursor=cursor))

    def history(self, element: str | None, last: int | None) -> History:
        """Returns the changes of an element, or all."""
        from skiros_py.world.journal import Entry

        limit = _CHANGES if last is None else min(last, _CHANGES)
        page = self._changes(element, limit, None)
        found = [*islice(_all(lambda cursor: self._changes(element, limit, cursor), page), last)]
        entries: list[Entry] = []
        for one in reversed(found):
            assert one.written is not None
            change = self._whole(one)
            entries.append(Entry(change, one.written.timestamp(), len(change.edits)))
        return History(page.remembered_from, entries)

    def _changes(self, element: str | None, limit: int, cursor: str | None) -> ChangePage:
        if element is None:
            return self._client.world.changes(newest_first=True, limit=limit, cursor=cursor)
        return self._client.elements.history(element, newest_first=True, limit=limit, cursor=cursor)

    def ontology(self) -> Ontology:
        """Returns the ontology of this installation, which is also the server's."""
        from skiros_py.config import ontology_paths
        from skiros_py.world.ontology import load_installed

        return load_installed(ontology_paths())[0]

    def undo(self, author: str) -> Change:
        """Undoes the last edit of a person."""
        self._write_as(author)
        return self._whole(self._client.world.undo())

    def learned(self) -> Sequence[Element]:
        """Returns the learned concepts."""
        found = _all(lambda cursor: self._client.learned.list(limit=_PAGE, cursor=cursor))
        return [_learned(one) for one in found]

    def forget(self, concept: str, author: str) -> Change:
        """Deletes a learned concept with its parts."""
        self._write_as(author)
        change = self._client.learned.forget(concept).change
        assert change is not None
        return self._whole(change)

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

    def _whole(self, found: ChangeInfo) -> Change:
        """Returns a change with all its edits."""
        from skiros_py.world.journal.records import decode_change

        data, following = found.model_dump(), found.next
        while following is not None:
            more = self._client.world.change(found.number, limit=_PAGE, cursor=following)
            data["edits"] += more.edits
            following = more.next
        del data["written"]
        return decode_change(json.dumps(data))


class _Page(Protocol[_Item]):
    """Some of a list."""

    @property
    def items(self) -> Sequence[_Item]:
        """What is on it."""
        ...

    @property
    def next(self) -> str | None:
        """Cursor of the next one."""
        ...


def _all(read: Callable[[str | None], _Page[_Item]], first: _Page[_Item] | None = None) -> Iterator[_Item]:
    """Yields the items of all pages; further pages are requested when needed."""
    page = read(None) if first is None else first
    while True:
        yield from page.items
        if page.next is None:
            return
        page = read(page.next)


def _element(found: ElementDetails) -> Element:
    from skiros_py.world.element import Element

    own = {name: _value(said.value) for name, said in found.properties.items() if said.origin == "own"}
    return Element(found.id, found.class_, found.label, own)


def _learned(found: Learned) -> Element:
    from skiros_py.world.element import Element

    return Element(
        found.id, found.class_, found.label, {name: _value(value) for name, value in found.properties.items()}
    )


def _value(found: Any) -> Value:
    """Returns a value that came as plain data."""
    from skiros_py.geometry import Pose

    if isinstance(found, dict):
        return Pose(tuple(found["position"]), tuple(found["orientation"]))
    value: Value = tuple(found) if isinstance(found, list) else found
    return value


# ---------------------------------------------------------------- queries


def _question(sparql: str, bindings: Mapping[str, Binding], *, entailed: bool, time_limit: float) -> Query:
    from pydantic import ValidationError

    from skiros_py.api.queries import Query
    from skiros_py.api.wire import fault_words

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
    from skiros_py.world.queries import Text

    if isinstance(value, Text):
        return {"text": str(value)}
    return {"decimal": f"{value:f}"} if isinstance(value, Decimal) else value


def _result(answer: Mapping[str, Any]) -> Result:
    from skiros_py.world.queries import Constructed, Table

    if answer["form"] == "ASK":
        return bool(answer["answer"])
    if answer["form"] == "SELECT":
        rows = [{name: None if v is None else _value(v) for name, v in row.items()} for row in answer["rows"]]
        return Table(tuple(answer["variables"]), rows)
    statements = tuple((subject, predicate, _value(value)) for subject, predicate, value in answer["statements"])
    return Constructed(statements, answer["turtle"])
