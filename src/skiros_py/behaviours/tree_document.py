"""The document kind for behaviour trees."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, ClassVar

from skiros_py.behaviours.document_kind import DocumentKind
from skiros_py.errors import DescriptionError
from skiros_py.skills.behaviour import Behaviour
from skiros_py.skills.plain import Reader


class Tree(DocumentKind):
    """A tree of behaviours of all kinds, written down as they are: ``{"type": "sequence", "children": […]}``.

    A tree with parameters or outputs stands in ``body``: ``{"parameters": […], "outputs": […], "body": {…}}``.
    """

    kind: ClassVar[str] = "tree"

    def behaviour(self, document: Any, reader: Reader) -> Behaviour:
        """Reads the tree."""
        if isinstance(document, Mapping) and "body" in document:
            unknown = sorted(document.keys() - {"parameters", "outputs", "body"})
            if unknown:
                raise DescriptionError("a tree has parameters, outputs and a body, and nothing else", unknown[0])
            return reader.behaviour(document["body"], "body")
        return reader.behaviour(document)
