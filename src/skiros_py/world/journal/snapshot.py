"""A whole state as texts, piece by piece: so it is read without doing everything again that led to it."""

from __future__ import annotations

import json
from collections.abc import Iterable, Iterator

from skiros_py.world.change import Edit, ElementEdit, GoalsEdit, PlacementEdit, RelationEdit
from skiros_py.world.element import Stamp, is_abstract, is_learned
from skiros_py.world.index import Index
from skiros_py.world.journal.codec import decode_edits, encode_edits
from skiros_py.world.journal.content import Content

__all__ = ["read_piece", "snapshot_pieces"]

_ELEMENTS_IN_PIECE = 1000


def snapshot_pieces(index: Index) -> Iterator[tuple[str, str]]:
    """Yields the texts of edits that lead from nothing to the state, with the stamps of what they are about.

    The individuals of the ontology are not in it: they come from the ontology's files.
    """
    yield encode_edits([GoalsEdit((), index.goals)]), "{}"
    relations = _relations(index)
    names = sorted(name for name in index.ids() if is_learned(name) or not is_abstract(name))
    for first in range(0, len(names), _ELEMENTS_IN_PIECE):
        piece = names[first : first + _ELEMENTS_IN_PIECE]
        edits = [edit for name in piece for edit in _edits(index, name, relations.get(name, ()))]
        yield encode_edits(edits), _stamps(index, piece)


def read_piece(content: Content, edits: str, stamps: str) -> None:
    """Adds what a piece says.

    Raises:
        ValueError: It is not what :func:`snapshot_pieces` writes.
    """
    try:
        content.apply(decode_edits(edits))
        content.stamp({name: Stamp(int(change), float(time)) for name, (change, time) in json.loads(stamps).items()})
    except (KeyError, TypeError, AttributeError) as error:
        raise ValueError(f"no snapshot: {error}") from None


def _edits(index: Index, name: str, relations: Iterable[RelationEdit]) -> Iterator[Edit]:
    yield ElementEdit(name, None, index.element(name))
    placement = index.placement(name)
    if placement is not None:
        yield PlacementEdit(name, None, placement)
    yield from relations


def _relations(index: Index) -> dict[str, list[RelationEdit]]:
    """Every relation but placements, by its subject."""
    found: dict[str, list[RelationEdit]] = {}
    for subject, relation, object_ in index.statements():
        if not index.ontology.is_placement(relation) and (is_learned(subject) or not is_abstract(subject)):
            edit = RelationEdit(subject, relation, object_, old=False, new=True)
            found.setdefault(subject, []).append(edit)
    return found


def _stamps(index: Index, names: Iterable[str]) -> str:
    stamps = {name: index.stamp(name) for name in names}
    return json.dumps({name: [stamp.change, stamp.time] for name, stamp in stamps.items() if stamp.change})
