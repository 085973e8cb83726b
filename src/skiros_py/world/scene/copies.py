"""Several robots of one kind in a scene: each further one gets its own parts, copied from those of the first.

A scene says ``scene:robot_2 sk:builtLike scene:robot_1`` and, for the parts, only the differences, such as where
base_2 starts.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, MutableMapping

from skiros_py.world.element import Value
from skiros_py.world.ontology import Ontology
from skiros_py.world.terms import Family
from skiros_py.world.vocabulary import POSE, POSE_FRAME, STRUCTURE


class Individual:
    """The combined statements of all files about one individual.

    Attributes:
        types: Names of its classes.
        values: Its properties, the label among them.
        relations: Names of a relation and of the individual at its other end.
    """

    __slots__ = ("relations", "types", "values")

    def __init__(self) -> None:
        self.types: list[str] = []
        self.values: dict[str, Value] = {}
        self.relations: list[tuple[str, str]] = []


# ---------------------------------------------------------------- copies


_NUMBERED = re.compile(r"(.*?)_?(\d+)")


def add_copy(individuals: MutableMapping[str, Individual], copy: str, like: str, ontology: Ontology) -> None:
    """Completes a robot from the description of another one, and creates its parts.

    Existing statements about the copy and its parts are kept. Map poses of parts are not copied: two bases do not
    start in one place.

    Args:
        individuals: All individuals by name; both robots are among them, the one to copy is complete.
        copy: Name of the robot to complete.
        like: Name of the robot to copy from.
        ontology: Defines which relations are structure.
    """
    pieces = [like, *_pieces(individuals, like, ontology)]
    names = {piece: copy if piece == like else _renamed(piece, like, copy) for piece in pieces}
    for piece, name in names.items():
        _complete(individuals.setdefault(name, Individual()), individuals[piece], names, ontology)


def _pieces(individuals: MutableMapping[str, Individual], whole: str, ontology: Ontology) -> Iterator[str]:
    """Yields the parts of a thing, in the order of the files; in a cycle, each part once."""
    below, seen, waiting = ontology.sub_relations(STRUCTURE), {whole}, [whole]
    for name in waiting:
        for relation, piece in individuals[name].relations:
            if relation in below and piece in individuals and piece not in seen:
                seen.add(piece)
                waiting.append(piece)
                yield piece


def _renamed(piece: str, like: str, copy: str) -> str:
    """Returns the copy's name for a part: base_1 of robot_1 is base_2 of robot_2, its lamp is its lamp_2."""
    old, new = (_NUMBERED.fullmatch(name) for name in (like, copy))
    number = new.group(2) if new else copy
    if old is not None and piece.endswith(f"_{old.group(2)}"):
        piece = piece[: -len(old.group(2)) - 1]
    return f"{piece}_{number}"


def _complete(copy: Individual, like: Individual, names: Mapping[str, str], ontology: Ontology) -> None:
    copy.types = copy.types or list(like.types)
    in_frame = any(relation == POSE_FRAME and target in names for relation, target in like.relations)
    for name, value in like.values.items():
        if name != POSE or in_frame:
            copy.values.setdefault(name, value)
    said = {_kind(relation, ontology) for relation, _ in copy.relations} - {Family.STRUCTURE}
    for relation, target in like.relations:
        if _kind(relation, ontology) not in said:
            copy.relations.append((relation, names.get(target, target)))


def _kind(relation: str, ontology: Ontology) -> str:
    """Returns what is copied together or not at all: all placements, all pieces, or one relation."""
    family = ontology.family(relation)
    return family if family in (Family.PLACEMENT, Family.STRUCTURE) else relation
