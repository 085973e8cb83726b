"""Documents that robots run, on the wire: trees, nets and graphs of whatever kind plug-ins bring."""

from __future__ import annotations

import json
from typing import Annotated, Any

from pydantic import AfterValidator, Field

from skiros_py.api.wire import Answer, Request

_LONGEST = 200_000


def _plain(value: Any) -> Any:
    """Refuses what JSON does not carry back, and what nobody would draw."""
    try:
        text = json.dumps(value, allow_nan=False, ensure_ascii=False)
        text.encode()
    except (ValueError, RecursionError) as error:
        raise ValueError(f"no value that can be written down again: {type(error).__name__}") from None
    if len(text) > _LONGEST:
        raise ValueError(f"at most {_LONGEST} characters of JSON, not {len(text)}")
    return value


class PaletteNode(Answer):
    """A node that an editor offers."""

    kind: str = Field(description="What it is called in a document.", examples=["wait"])
    help: str = Field(description="One sentence.", examples=["Lets so many seconds of run time pass."])
    fields: dict[str, str] = Field(description="Its fields with their types.", examples=[{"seconds": "float"}])


class DocumentKindInfo(Answer):
    """A kind of document."""

    kind: str = Field(description="Its name.", examples=["tree"])
    formats: tuple[str, ...] = Field(description="Text formats of import and export.", examples=[["json"]])
    palette: tuple[PaletteNode, ...] = Field(description="The nodes that an editor offers.")


class DocumentKinds(Answer):
    """All kinds of documents."""

    kinds: tuple[DocumentKindInfo, ...] = Field(description="By name.")


class DocumentContent(Request):
    """What a document says."""

    data: Annotated[dict[str, Any], AfterValidator(_plain)] = Field(
        description="The document, as its kind wants it.", examples=[{"type": "wait", "seconds": 1}]
    )


class DocumentInfo(Answer):
    """A document as it is kept."""

    kind: str = Field(description="Its kind.", examples=["tree"])
    id: str = Field(description="Its id among those of its kind.", examples=["tidy up"])
    revision: int = Field(description="Its revision, as in its ETag; it is kept with each run.", examples=[7])
    module: str = Field(description="The module that runs it.", examples=["tree:tidy up"])
    data: dict[str, Any] = Field(description="What it says.")


class Documents(Answer):
    """The documents of a kind, or the revisions of one."""

    documents: tuple[DocumentInfo, ...] = Field(description="By id; revisions the oldest first.")
