"""Kinds of document: what they say of themselves."""

from dataclasses import make_dataclass

from skiros_py.behaviours import Behaviour
from skiros_py.behaviours.tree_document import Tree
from skiros_py.skills.plain import Reader


def test_a_palette_names_field_types_as_authors_write_them() -> None:
    fields = [("child", Behaviour), ("rest", tuple[Behaviour, ...]), ("within", "float | None")]
    node = make_dataclass("Node", fields, bases=(Behaviour,))

    (entry,) = Tree().palette(Reader({"node": node}))

    assert entry.fields == {"child": "Behaviour", "rest": "tuple[Behaviour, ...]", "within": "float | None"}
