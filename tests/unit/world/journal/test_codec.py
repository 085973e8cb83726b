from __future__ import annotations

import math
from types import MappingProxyType

import pytest
from hypothesis import given
from hypothesis import strategies as st

from skiros_py.geometry import Pose
from skiros_py.messages import Message
from skiros_py.world.change import (
    Change,
    Edit,
    ElementEdit,
    GoalsEdit,
    PlacementEdit,
    PropertyEdit,
    RelationEdit,
    Writer,
)
from skiros_py.world.element import Element, Placement, Value
from skiros_py.world.journal import records
from skiros_py.world.journal.records import decode_change, decode_edits, encode_change, encode_edits

NUMBERS = st.floats(allow_nan=False, allow_infinity=False)


def is_one_text(text: str) -> bool:
    """Two halves of a character beside each other are that character."""
    return text.encode("utf-16", "surrogatepass").decode("utf-16", "surrogatepass") == text


HALVES = st.text(st.characters(categories=["Cs", "Cc", "So"]), max_size=5).filter(is_one_text)
TEXTS = st.text(max_size=20) | HALVES
POSES = st.builds(Pose, st.tuples(NUMBERS, NUMBERS, NUMBERS), st.tuples(NUMBERS, NUMBERS, NUMBERS, NUMBERS))
VECTORS = st.lists(NUMBERS, max_size=4).map(tuple)
VALUES = TEXTS | st.booleans() | st.integers() | NUMBERS | POSES | VECTORS
PROPERTIES = st.dictionaries(TEXTS, VALUES, max_size=3).map(lambda p: MappingProxyType(dict(sorted(p.items()))))
ELEMENTS = st.builds(Element, TEXTS, TEXTS, TEXTS, PROPERTIES)
PLACEMENTS = st.builds(Placement, TEXTS, TEXTS)
GOALS = st.lists(TEXTS, max_size=3).map(tuple)
EDITS = st.one_of(
    st.builds(ElementEdit, TEXTS, st.none() | ELEMENTS, st.none() | ELEMENTS),
    st.builds(PlacementEdit, TEXTS, st.none() | PLACEMENTS, st.none() | PLACEMENTS),
    st.builds(RelationEdit, TEXTS, TEXTS, TEXTS, st.booleans(), st.booleans()),
    st.builds(PropertyEdit, TEXTS, TEXTS, st.none() | VALUES, st.none() | VALUES),
    st.builds(GoalsEdit, GOALS, GOALS),
)
CHANGES = st.builds(
    Change,
    st.integers(1),
    TEXTS,
    TEXTS,
    NUMBERS,
    st.lists(EDITS, max_size=4).map(tuple),
    st.sampled_from(Writer),
    st.none() | st.integers(1),
)


def exactly(value: object) -> str:
    """Tells 1 from 1.0 from True, and 0.0 from -0.0, as == does not."""
    return repr(value)


@given(CHANGES)
def test_a_change_that_was_written_is_read_exactly_as_it_was(change: Change) -> None:
    text, *others = encode_change(change)
    again = decode_change(text, others)

    assert again == change
    assert exactly(again) == exactly(change)


@given(VALUES)
def test_a_value_keeps_its_type(value: Value) -> None:
    (edit,) = decode_edits(encode_edits([PropertyEdit("starter_1", "sk:mass", None, value)]))

    assert isinstance(edit, PropertyEdit)
    assert exactly(edit.new) == exactly(value)


@given(st.lists(EDITS, max_size=7))
def test_texts_are_plain_ascii_so_that_every_character_can_be_stored(edits: list[Edit]) -> None:
    assert encode_edits(edits).isascii()


@given(st.lists(EDITS, max_size=20))
def test_many_edits_take_several_texts(edits: list[Edit]) -> None:
    before = records.LONGEST_PART
    records.LONGEST_PART = 3
    try:
        change = Change(1, "scene", "read", 0.0, tuple(edits))
        texts = encode_change(change)
    finally:
        records.LONGEST_PART = before

    assert len(texts) == max(1, math.ceil(len(edits) / 3))
    assert decode_change(texts[0], texts[1:]) == change


@pytest.mark.parametrize(
    "text",
    [
        "",
        "{",
        "7",
        "null",
        "[]",
        "{}",
        '{"edits": []}',
        '{"edits": [7]}',
        '{"edits": [{"edit": "fly"}]}',
        '{"edits": [{"edit": "goals", "old": [], "new": 7}]}',
        '{"edits": [{"edit": "placement", "element": "a", "old": null, "new": {}}]}',
        '{"edits": [{"edit": "element", "element": "a", "old": null, "new": "b"}]}',
        '{"edits": [{"edit": "goals", "old": [], "new": [], "more": 1}]}',
        '{"edits": [{"edit": "property", "element": "a", "property": "b", "old": null, "new": {"position": [1]}}]}',
        '{"number": 1, "author": "", "reason": "", "time": 0, "writer": "dog", "undoes": null, "edits": []}',
        "[" * 100_000,
    ],
)
def test_decoding_an_invalid_change_raises_a_value_error(text: str) -> None:
    with pytest.raises(ValueError):  # noqa: PT011  whatever it says
        decode_change(text)


def test_a_reason_keeps_what_it_is_made_of() -> None:
    lost = Message("{part} is lost", part="ball_1")
    change = Change(7, "ann", Message("undoes change {number}: {reason}", number=6, reason=lost), 1.5, ())

    (text,) = encode_change(change)

    read = decode_change(text).reason
    assert read == "undoes change 6: ball_1 is lost"
    assert isinstance(read, Message)
    assert read.data == change.reason.data


@pytest.mark.parametrize("reason", ['{"template": 5, "values": {}}', '{"values": []}'])
def test_a_damaged_reason_is_no_change(reason: str) -> None:
    (text,) = encode_change(Change(7, "ann", "why", 1.5, ()))

    with pytest.raises(ValueError, match="no change"):
        decode_change(text.replace('"why"', reason))
