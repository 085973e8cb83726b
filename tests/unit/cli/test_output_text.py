"""Text of others shows what is in it, and does nothing to the terminal."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from skiros_py.cli.output import escaped


@given(st.text())
def test_escaped_text_contains_only_printable_characters(text: str) -> None:
    assert escaped(text).isprintable()


@given(st.text().filter(str.isprintable))
def test_printable_text_is_unchanged(text: str) -> None:
    assert escaped(text) == text


@pytest.mark.parametrize(
    ("text", "shown"), [("\x1b[31m", "\\x1b[31m"), ("a\r\nb", "a\\r\\nb"), ("\0", "\\x00"), ("\u202e", "\\u202e")]
)
def test_control_characters_are_escaped(text: str, shown: str) -> None:
    assert escaped(text) == shown
