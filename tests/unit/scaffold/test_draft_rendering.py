"""What is written is Python, formatted as linters want it."""

from __future__ import annotations

import ast

from hypothesis import given
from hypothesis import strategies as st

from skiros_py.scaffold.draft import call, imports, listed, literal

VALUES = st.recursive(
    st.text() | st.booleans() | st.integers() | st.floats(allow_nan=False, allow_infinity=False),
    lambda inner: st.tuples(inner) | st.tuples(inner, inner),
    max_leaves=4,
)


@given(VALUES)
def test_a_value_is_written_in_the_form_it_is_read(value: object) -> None:
    assert ast.literal_eval(literal(value)) == value


@given(st.lists(st.text("abc", min_size=1, max_size=40), max_size=6), st.integers(0, 3))
def test_a_call_keeps_its_arguments_and_its_width(names: list[str], depth: int) -> None:
    text = call([literal(name) for name in names], "Param", 4 * depth)

    read = ast.parse(text.removesuffix(",")).body[0]
    assert isinstance(read, ast.Expr)
    assert isinstance(read.value, ast.Call)
    assert [ast.literal_eval(argument) for argument in read.value.args] == names
    assert all(len(line) + 4 * depth <= 120 for line in text.splitlines())


@given(st.lists(st.text("abc", min_size=1, max_size=90), min_size=1, max_size=3))
def test_a_tuple_of_one_element_stays_a_tuple(items: list[str]) -> None:
    text = listed([literal(item) for item in items], "")

    assert ast.literal_eval(text.removesuffix(",")) == tuple(items)


def test_imports_are_sorted_and_grouped_by_module() -> None:
    written = imports([("b.c", "two"), ("a", "Two"), ("b.c", "ONE"), ("b.c", "Three"), ("b.c", "two")])

    assert written == "from a import Two\nfrom b.c import ONE, Three, two"
