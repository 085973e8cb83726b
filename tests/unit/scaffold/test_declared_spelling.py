"""Names: what is accepted can be written as code, and what is refused says why."""

from __future__ import annotations

import keyword

import pytest
from hypothesis import given
from hypothesis import strategies as st

from skiros_py.errors import UsageError
from skiros_py.scaffold.declared import (
    class_name,
    constant_name,
    joined,
    module_name,
    sentence,
    snake_case,
    words_of,
)


@given(st.text(max_size=50))
def test_every_accepted_name_is_a_valid_python_name(text: str) -> None:
    for check in (module_name, class_name):
        try:
            name = check(text, "skill")
        except UsageError:
            continue
        assert name == text
        assert name.isidentifier()
        assert not keyword.iskeyword(name)
        assert constant_name(name).isidentifier()
        assert joined(name).isidentifier()


@given(st.text(max_size=120))
def test_a_sentence_is_valid_in_a_docstring_and_ends_with_a_full_stop(text: str) -> None:
    try:
        said = sentence(text, "help")
    except UsageError:
        return
    assert eval(f'"""{said}"""') == said
    assert said[-1] in ".!?"


@pytest.mark.parametrize(
    ("name", "words", "module", "class_"),
    [
        ("RobotAtLocation", "robot at location", "robot_at_location", "RobotAtLocation"),
        ("read_code", "read code", "read_code", "ReadCode"),
        ("scan-part", "scan part", "scan_part", "ScanPart"),
    ],
)
def test_words_module_name_and_class_name_are_derived_from_one_name(
    name: str, words: str, module: str, class_: str
) -> None:
    assert (words_of(name), snake_case(name), joined(name)) == (words, module, class_)


@pytest.mark.parametrize(
    ("name", "hint"),
    [("Scan-Part", "such as 'scan_part'"), ("1st", "small letters"), ("", "small letters"), ("class", "Python itself")],
)
def test_an_invalid_name_is_refused_with_a_valid_one(name: str, hint: str) -> None:
    with pytest.raises(UsageError, match=hint):
        module_name(name, "skill")
