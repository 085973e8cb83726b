"""Text of documents: which JSON is refused, and where its places are."""

from __future__ import annotations

import pytest

from skiros_py.behaviours import Wait
from skiros_py.behaviours.document_kind import places_of_json
from skiros_py.behaviours.tree_document import Tree
from skiros_py.errors import DocumentError
from skiros_py.skills.plain import Reader


@pytest.mark.parametrize(
    ("text", "place"),
    [
        ('{"type": "wait",\n "type": "sequence"}', ("type", 2, 2)),
        ('{"a": [1, {"b\\"}": 1,\n\n  "c": "{", "b\\"}": 2}]}', ('a[1].b"}', 3, 13)),
    ],
)
def test_a_key_that_is_there_twice_is_refused_with_its_place(text: str, place: tuple[str, int, int]) -> None:
    with pytest.raises(DocumentError) as refused:
        Tree().parse(text, "json")

    (fault,) = refused.value.faults
    assert (fault.place, fault.line, fault.column) == place
    assert "twice" in fault.text


def test_equal_keys_of_different_objects_are_fine() -> None:
    assert Tree().parse('{"a": {"x": 1}, "b": [{"x": 1}, {"x": [], "y": {}}]}', "json")


def test_each_place_of_a_text_has_its_line_and_column() -> None:
    text = '{"x": [1,\n  {"y": null}]\n}'

    assert list(places_of_json(text)) == [
        ("", 1, 1), ("x", 1, 2), ("x[0]", 1, 8), ("x[1]", 2, 3), ("x[1].y", 2, 4),
    ]  # fmt: skip


@pytest.mark.parametrize("key", ["parameters", "outputs"])
def test_a_text_where_a_list_is_expected_is_refused_as_a_whole(key: str) -> None:
    (fault,) = Tree().check({key: "seen", "body": {"type": "wait", "seconds": 1}}, Reader({"wait": Wait}))

    assert (fault.place, fault.text) == (key, "it must be a list, not 'seen'")
