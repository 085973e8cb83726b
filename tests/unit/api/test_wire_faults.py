"""What is wrong with a field is said in sentences, not in a type checker's words."""

from __future__ import annotations

from typing import Annotated, Any, Literal

import pytest
from pydantic import Field, TypeAdapter, ValidationError

from skiros_py.api.wire import fault_limit, fault_words


def fault(type_: Any, value: object) -> dict[str, Any]:
    with pytest.raises(ValidationError) as raised:
        TypeAdapter(type_).validate_python(value, strict=True)
    return dict(raised.value.errors()[0])


@pytest.mark.parametrize(
    ("type_", "value", "words", "limit"),
    [
        (bool, "perhaps", "must be true or false", None),
        (int, "three", "must be a whole number", None),
        (float, "far", "must be a number", None),
        (str, 3, "must be text", None),
        (list[float], 1.0, "must be a list", None),
        (Annotated[int, Field(ge=1)], 0, "must be at least 1", 1),
        (Annotated[float, Field(le=60.0)], 61.0, "must be at most 60", 60.0),
        (Annotated[str, Field(max_length=2)], "abc", "must have at most 2 characters", 2),
        (Annotated[list[int], Field(min_length=1)], [], "must not be empty", 1),
        (Annotated[str, Field(min_length=1)], "", "must not be empty", 1),
        (Annotated[list[int], Field(min_length=2)], [1], "must have at least 2 entries", 2),
        (Literal["a", "b"], "c", "must be 'a' or 'b'", None),
    ],
)
def test_a_validation_fault_says_what_the_value_must_be(
    type_: Any, value: object, words: str, limit: float | None
) -> None:
    found = fault(type_, value)

    assert fault_words(found) == words
    assert fault_limit(found) == limit


def test_an_unknown_validation_fault_keeps_its_original_message() -> None:
    assert fault_words({"type": "value_error", "msg": "Value error, the gripper is gone"}) == "the gripper is gone"
    assert fault_words({"type": "new_kind", "msg": "Something else"}) == "Something else"
    assert fault_words({"type": "less_than", "msg": "Too much"}) == "Too much"
