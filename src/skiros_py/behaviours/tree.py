"""Documents that are trees of behaviours."""

from __future__ import annotations

from typing import Any, ClassVar

from skiros_py.behaviours.document import DocumentKind
from skiros_py.skills.behaviour import Behaviour
from skiros_py.skills.plain import Reader


class Tree(DocumentKind):
    """A tree of behaviours of all kinds, written down as they are: ``{"type": "sequence", "children": […]}``."""

    kind: ClassVar[str] = "tree"

    def behaviour(self, document: Any, reader: Reader) -> Behaviour:
        """Reads the tree."""
        return reader.behaviour(document)
