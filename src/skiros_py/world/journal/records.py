"""Single changes in the tables of a journal."""

from __future__ import annotations

import json
import sqlite3
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from types import MappingProxyType, NoneType
from typing import Any, get_args

from skiros_py.database import COUNTED, Database, Schema
from skiros_py.database_file import DatabaseFile
from skiros_py.errors import FileError
from skiros_py.geometry import Pose
from skiros_py.messages import Message, message_data, read_message
from skiros_py.world.change import (
    Change,
    Edit,
    ElementEdit,
    GoalsEdit,
    PlacementEdit,
    SceneSource,
    SourceEdit,
    Writer,
)
from skiros_py.world.element import Element, Placement
from skiros_py.world.past import subjects_of

_CHANGES = """
CREATE TABLE changes (
    number INTEGER PRIMARY KEY,
    wall REAL NOT NULL,         -- when it was written [s since 1970]
    writer TEXT NOT NULL,
    undoes INTEGER,
    more INTEGER NOT NULL,      -- how many texts of further edits there are
    data TEXT NOT NULL
);
CREATE INDEX changes_by_people ON changes (number) WHERE writer = 'person' OR undoes IS NOT NULL;
CREATE TABLE more_edits (
    number INTEGER NOT NULL,
    part INTEGER NOT NULL,
    edits TEXT NOT NULL,
    UNIQUE (number, part)
);
CREATE TABLE snapshot (
    part INTEGER PRIMARY KEY,
    version INTEGER NOT NULL,
    edits TEXT NOT NULL,        -- what leads from nothing to the state
    stamps TEXT NOT NULL        -- the last change of each element, and when
);
CREATE TABLE given_ids (id TEXT PRIMARY KEY) WITHOUT ROWID;
"""

_MARKS = """
CREATE TABLE marks (
    element TEXT NOT NULL,      -- '' stands for the goals
    number INTEGER NOT NULL,
    PRIMARY KEY (element, number)
) WITHOUT ROWID;
CREATE TEMP VIEW edits AS
    SELECT changes.number AS number, edit.value AS edit FROM changes, json_each(changes.data, '$.edits') AS edit
    UNION ALL
    SELECT more_edits.number, edit.value FROM more_edits, json_each(more_edits.edits) AS edit;
INSERT OR IGNORE INTO marks SELECT json_extract(edit, '$.element'), number FROM edits
    WHERE json_extract(edit, '$.edit') IN ('element', 'placement', 'property');
INSERT OR IGNORE INTO marks SELECT json_extract(edit, '$.subject'), number FROM edits
    WHERE json_extract(edit, '$.edit') = 'relation';
INSERT OR IGNORE INTO marks SELECT json_extract(edit, '$.object'), number FROM edits
    WHERE json_extract(edit, '$.edit') = 'relation';
INSERT OR IGNORE INTO marks SELECT '', number FROM edits WHERE json_extract(edit, '$.edit') = 'goals';
DROP VIEW edits;
"""

SCHEMA = Schema(Message("the journal of a world"), 0x736B696A, (_CHANGES, _MARKS, COUNTED))
"""The schema; its files have the application id "skij"."""


# ---------------------------------------------------------------- JSON


LONGEST_PART = 1000
"""Number of edits in one text: a scene of 100,000 elements is read and written in pieces.

Part of the file format: all texts of a change except the last have that many.
"""

_Json = Mapping[str, Any]


def parts(edits: Sequence[Edit]) -> Iterator[Sequence[Edit]]:
    """Yields the edits in pieces; one empty piece if there are none."""
    for first in range(0, max(len(edits), 1), LONGEST_PART):
        yield edits[first : first + LONGEST_PART]


def encode_change(change: Change) -> list[str]:
    """Returns the texts of a change: the first has everything except the edits beyond the first piece."""
    first, *others = parts(change.edits)
    head = replace(change, edits=tuple(first)).as_json() | {"reason": message_data(change.reason)}
    return [_dump(head), *(encode_edits(part) for part in others)]


def encode_edits(edits: Sequence[Edit]) -> str:
    """Returns the text of some edits."""
    return _dump([edit.as_json() for edit in edits])


def decode_change(text: str, others: Sequence[str] = ()) -> Change:
    """Reads a change from the texts that say it.

    Raises:
        ValueError: They say none.
    """
    data = _load(text)
    with_rest = [*_edits(data), *(edit for other in others for edit in decode_edits(other))]
    try:
        return Change(
            data["number"],
            data["author"],
            read_message(data["reason"]),
            data["time"],
            tuple(with_rest),
            Writer(data["writer"]),
            data["undoes"],
        )
    except (LookupError, TypeError, AttributeError) as error:
        raise ValueError(f"no change: {error}") from None


def decode_edits(text: str) -> list[Edit]:
    """Reads edits.

    Raises:
        ValueError: The text says none.
    """
    return _edits({"edits": _load(text)})


def _edits(data: _Json) -> list[Edit]:
    try:
        return [_edit(edit) for edit in data["edits"]]
    except (KeyError, TypeError, AttributeError) as error:
        raise ValueError(f"no edits: {error}") from None


def _dump(data: object) -> str:
    return json.dumps(data, separators=(",", ":"))


def _load(text: object) -> Any:
    if not isinstance(text, str):  # what a damaged file holds
        raise ValueError(f"no text, but {type(text).__name__}")
    try:
        return json.loads(text)
    except RecursionError:
        raise ValueError("it is nested too deep") from None


def _edit(data: _Json) -> Edit:
    kind = _KINDS[data["edit"]]
    if kind is SourceEdit:
        return SourceEdit(SceneSource(*data["old"]), SceneSource(*data["new"]))
    fields = {name: _value(value) for name, value in data.items() if name != "edit"}
    if kind in _SIDES and not {type(fields["old"]), type(fields["new"])} <= _SIDES[kind]:
        raise TypeError(f"no {kind.kind}: {data!r:.100}")
    return kind(**fields)


def _value(data: Any) -> Any:
    if data is None or type(data) in _JSON_VALUES:
        return data
    if isinstance(data, list):
        return tuple(data)
    if "position" in data:
        return Pose(tuple(data["position"]), tuple(data["orientation"]))
    if "place" in data:
        return Placement(data["relation"], data["place"])
    properties = {name: _value(value) for name, value in data["properties"].items()}
    return Element(data["id"], data["type"], data["label"], MappingProxyType(properties))


_JSON_VALUES = frozenset({str, bool, int, float})
_KINDS: Mapping[str, type[Edit]] = {kind.kind: kind for kind in get_args(Edit)}
_SIDES: Mapping[type[Edit], frozenset[type]] = {
    ElementEdit: frozenset({Element, NoneType}),
    PlacementEdit: frozenset({Placement, NoneType}),
    GoalsEdit: frozenset({tuple}),
}
"""The types of both sides, where not every value is one."""


# ---------------------------------------------------------------- tables


_SELECT = (
    "SELECT number, wall, more, data, (SELECT json_array_length(edits) FROM more_edits"
    " WHERE more_edits.number = changes.number AND part = changes.more - 1) FROM changes WHERE "
)
_AT_ONCE = 500


@dataclass(frozen=True, slots=True)
class Entry:
    """A change as stored in the journal.

    Attributes:
        change: The change, possibly with its first thousand edits only.
        wall: When it was written [s since 1970, UTC].
        edits: Number of all its edits.
    """

    change: Change
    wall: float
    edits: int


def insert(connection: sqlite3.Connection, change: Change, wall: float) -> None:
    """Writes a change, the elements that it marks, and the ids that it used."""
    first, *more = encode_change(change)
    number = change.number
    row = (number, wall, change.writer.value, change.undoes, len(more), first)
    connection.execute("INSERT INTO changes VALUES (?, ?, ?, ?, ?, ?)", row)
    if more:
        rows = ((number, part, edits) for part, edits in enumerate(more))
        connection.executemany("INSERT INTO more_edits VALUES (?, ?, ?)", rows)
    marks = [(subject, number) for subject in sorted(subjects_of(change))]
    connection.executemany("INSERT INTO marks VALUES (?, ?)", marks)
    given = [(edit.element,) for edit in change.edits if isinstance(edit, ElementEdit) and edit.new is not None]
    if given:
        connection.executemany("INSERT OR IGNORE INTO given_ids VALUES (?)", given)


def delete(connection: sqlite3.Connection, condition: str, number: int) -> None:
    """Deletes the changes whose number meets a condition (``number > ?``); their ids are still not reused."""
    for table in ("changes", "more_edits", "marks"):
        connection.execute(f"DELETE FROM {table} WHERE {condition}", (number,))  # noqa: S608  all ours


def select(
    database: Database | DatabaseFile, condition: str, values: Sequence[object] = (), *, whole: bool = True
) -> list[Entry]:
    """Reads the changes that meet a condition (SQL after WHERE).

    Args:
        database: The journal.
        condition: The condition.
        values: What is bound to its question marks.
        whole: False to read at most the first thousand edits of each: then one query is enough, and writers wait only
            for that, not until all rows are decoded.

    Raises:
        FileError: The file cannot be read, or a change cannot be understood.
    """
    return [_entry(database, *row, whole=whole) for row in database.rows(_SELECT + condition, values)]


def select_after(database: Database | DatabaseFile, version: int) -> Iterator[Entry]:
    """Reads all changes after a version, in order, in pages.

    Raises:
        FileError: The file cannot be read, or a change is missing or cannot be understood.
    """
    while True:
        entries = select(database, "number > ? ORDER BY number LIMIT ?", (version, _AT_ONCE))
        for entry in entries:
            if entry.change.number != version + 1:
                raise FileError(database.path, f"the file is damaged: change {version + 1} is missing")
            yield entry
            version += 1
        if len(entries) < _AT_ONCE:
            return


def select_edits(database: Database, number: int, start: int, most: int) -> list[Edit]:
    """Reads some edits of a change after the first thousand, which are in its head.

    Args:
        database: The journal.
        number: Number of the change.
        start: The first edit to read, from :data:`~skiros_py.world.journal.records.LONGEST_PART` on.
        most: Maximum number of edits.

    Raises:
        FileError: The file cannot be read.
    """
    first, last = start // LONGEST_PART - 1, (start + most - 1) // LONGEST_PART - 1
    sql = "SELECT edits FROM more_edits WHERE number = ? AND part BETWEEN ? AND ? ORDER BY part"
    found = [edit for (text,) in database.rows(sql, (number, first, last)) for edit in decode_edits(text)]
    skipped = start - (first + 1) * LONGEST_PART
    return found[skipped : skipped + most]


def _entry(
    database: Database | DatabaseFile, number: int, wall: float, more: int, data: str, last: int | None, *, whole: bool
) -> Entry:
    sql = "SELECT edits FROM more_edits WHERE number = ? ORDER BY part"
    others: list[Any] = [edits for (edits,) in database.rows(sql, (number,))] if more and whole else []
    try:
        change = decode_change(data, others)
    except ValueError as error:
        raise FileError(database.path, f"the file is damaged: change {number} cannot be understood: {error}") from None
    if change.number != number or (whole and len(others) != more):
        raise FileError(database.path, f"the file is damaged: change {number} is not whole")
    return Entry(change, wall, more * LONGEST_PART + (last or 0) if more else len(change.edits))
