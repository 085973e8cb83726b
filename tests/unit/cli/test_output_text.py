"""Text of others shows what is in it, and does nothing to the terminal."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from skiros_py.cli import output
from skiros_py.cli.output import table_lines
from skiros_py.errors import escaped


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


def test_a_table_in_a_terminal_that_is_too_narrow_for_it_has_a_line_for_each_cell(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    columns, rows = ("job", "state", "goal"), [("kit-1", "running", "InKit(Starter, kit_1)"), ("kit-2", "", "x\ny")]
    wide = table_lines(columns, rows)
    monkeypatch.setattr(output, "_FILE_WIDTH", 20)

    assert len(wide) == 3
    assert table_lines(columns, rows) == [
        "job: kit-1", "state: running", "goal: InKit(Starter, kit_1)", "", "job: kit-2", "goal: x\\ny", "",
    ]  # fmt: skip
