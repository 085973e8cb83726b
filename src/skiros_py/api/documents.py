"""Documents on the wire: plain data of any kind, with revisions."""

from __future__ import annotations

from typing import Any

from pydantic import Field

from skiros_py.api.wire import Answer, Page, Request


class PaletteNode(Answer):
    """A node that an editor offers."""

    kind: str = Field(examples=["wait"])
    """Its kind, as in documents."""
    help: str = Field(examples=["Lets so many seconds of run time pass."])
    """Description in one sentence."""
    fields: dict[str, str] = Field(examples=[{"seconds": "float"}])
    """Its fields with their types."""


class DocumentKindInfo(Answer):
    """A kind of document."""

    kind: str = Field(examples=["tree"])
    """Its name."""
    help: str = Field(examples=["A tree of behaviours of all kinds."])
    """Description in one sentence."""
    formats: dict[str, str] = Field(examples=[{"json": "application/json"}])
    """Text formats of import and export, with their media types."""
    palette: tuple[PaletteNode, ...]
    """The nodes that an editor offers."""


DocumentKinds = Page[DocumentKindInfo]
"""The kinds of documents, by name."""


class DocumentContent(Request):
    """The content of a document."""

    data: dict[str, Any] = Field(examples=[{"type": "wait", "seconds": 1}])
    """The document, in the form that its kind defines."""


class DocumentProblem(Answer):
    """Something in a document that does not work in the current world."""

    place: str = Field(examples=["steps[2]"])
    """Where in the document; empty for the whole."""
    text: str = Field(examples=["no subsystem has the skill drive any more"])
    """What is wrong, in a sentence."""


class DocumentInfo(Answer):
    """A stored document."""

    kind: str = Field(examples=["tree"])
    """Its kind."""
    id: str = Field(examples=["tidy up"])
    """Its id among those of its kind."""
    revision: int = Field(examples=[7])
    """Its revision, as in its ETag; it is kept with each run."""
    module: str = Field(examples=["tree:tidy up"])
    """The module that runs it, if its kind is run as modules."""
    data: dict[str, Any]
    """Its content."""
    problems: tuple[DocumentProblem, ...]
    """What does not work in the current world; omitted in lists and revisions."""
    agents: dict[str, str] = Field(examples=[{"steps[0]": "base_1"}])
    """The subsystems that would run parts of it now, by place; omitted in lists and revisions."""


Documents = Page[DocumentInfo]
"""The documents of a kind, by id; or the revisions of one, oldest first."""
