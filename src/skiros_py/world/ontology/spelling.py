"""Finds where in a file an IRI is written, so that a fault can name the line."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field


@dataclass(frozen=True, slots=True)
class TurtleSpelling:
    """How a Turtle file writes IRIs.

    Attributes:
        prefixes: IRI by prefix.
    """

    prefixes: Mapping[str, str]

    def line(self, text: str, subject: str | None, term: str | None) -> int | None:
        """Returns the line of the statements about ``subject``, at ``term`` (IRIs) where it occurs, or None."""
        start = _find(text, self._pattern(subject, r"^[ \t]*"), 0)
        if start is None:
            start = _find(text, self._pattern(subject), 0)
        return _line_at(text, start, _find(text, self._pattern(term), start or 0))

    def _pattern(self, iri: str | None, before: str = r"(?<![\w:.-])") -> str | None:
        # A comment's words are skipped by taking it as one match of its own.
        return rf"^[ \t]*#.*$|{before}({_any(self._spellings(iri))})(?![\w-])" if iri else None

    def _spellings(self, iri: str) -> Iterator[str]:
        yield f"<{iri}>"
        for prefix, namespace in self.prefixes.items():
            if iri.startswith(namespace):
                yield f"{prefix}:{iri.removeprefix(namespace)}"


@dataclass(frozen=True, slots=True)
class XmlSpelling:
    """How an RDF/XML or OWL/XML file writes IRIs.

    Attributes:
        prefixes: IRI by prefix.
        base: What its relative IRIs start with.
        entities: Text by name of entity.
    """

    prefixes: Mapping[str, str]
    base: str = ""
    entities: Mapping[str, str] = field(default_factory=dict)

    def line(self, text: str, subject: str | None, term: str | None) -> int | None:
        """Returns the line of the statements about ``subject``, at ``term`` (IRIs) where it occurs, or None."""
        named = r"(?:\bI[DR]I?|:ID|:about|\babbreviatedIRI)\s*=\s*[\"']"
        start = _find(text, self._pattern(subject, named), 0)
        found = _find(text, self._pattern(term), start or 0)
        return _line_at(text, start, found if found is not None else _find(text, self._pattern(term), 0))

    def _pattern(self, iri: str | None, before: str = r"[\"'</>]") -> str | None:
        return rf"<!--.*?-->|{before}({_any(self._spellings(iri))})(?![\w-])" if iri else None

    def _spellings(self, iri: str) -> Iterator[str]:
        yield iri
        if self.base and iri.startswith(self.base):
            yield iri.removeprefix(self.base)
            yield iri.removeprefix(self.base).lstrip("#/")
        for prefix, namespace in self.prefixes.items():
            if namespace and iri.startswith(namespace):
                yield f"{prefix}:{iri.removeprefix(namespace)}" if prefix else iri.removeprefix(namespace)
        for entity, value in self.entities.items():
            if iri.startswith(value):
                yield f"&{entity};{iri.removeprefix(value)}"


def _any(spellings: Iterator[str]) -> str:
    return "|".join(re.escape(spelling) for spelling in dict.fromkeys(spellings) if spelling)


def _find(text: str, pattern: str | None, start: int) -> int | None:
    if pattern is None:
        return None
    for match in re.compile(pattern, re.MULTILINE | (re.DOTALL if "<!--" in pattern else 0)).finditer(text, start):
        if match.group(1) is not None:
            return match.start(1)
    return None


def _line_at(text: str, start: int | None, found: int | None) -> int | None:
    offset = found if found is not None else start
    return None if offset is None else text.count("\n", 0, offset) + 1
