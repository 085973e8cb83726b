"""Reads one Turtle file, and remembers where in it things stand, so that faults can name a line."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path

import pyoxigraph as ox

from skiros_py.errors import FileError
from skiros_py.world.names import STANDARD_PREFIXES

__all__ = ["Document", "rdf_files", "read_document"]

_TYPE = ox.NamedNode(STANDARD_PREFIXES["rdf"] + "type")
_ONTOLOGY = ox.NamedNode(STANDARD_PREFIXES["owl"] + "Ontology")
_IMPORTS = ox.NamedNode(STANDARD_PREFIXES["owl"] + "imports")


@dataclass(frozen=True, slots=True)
class Document:
    """One parsed file.

    Attributes:
        path: Where it is.
        text: What it says.
        iri: IRI of the ontology it declares, else the file's own.
        prefixes: IRI by prefix, as declared in it.
        triples: Its statements in file order.
    """

    path: Path
    text: str
    iri: str
    prefixes: Mapping[str, str]
    triples: tuple[ox.Triple, ...]

    def imports(self) -> tuple[str, ...]:
        """Returns the IRIs that it imports, sorted."""
        found = (t.object for t in self.triples if t.predicate == _IMPORTS)
        return tuple(sorted(term.value for term in found if isinstance(term, ox.NamedNode)))

    def fault(self, reason: str, subject: str | None = None, term: str | None = None) -> FileError:
        """Makes the error for a fault in the statements about ``subject``, at ``term`` (both IRIs) where it occurs."""
        return FileError(self.path, reason, line=self._line_of(subject, term))

    def _line_of(self, subject: str | None, term: str | None) -> int | None:
        start = self._find(subject, 0, at_line_start=True) if subject else None
        if start is None:
            start = self._find(subject, 0) if subject else None
        found = self._find(term, start or 0) if term else None
        offset = found if found is not None else start
        return None if offset is None else self.text.count("\n", 0, offset) + 1

    def _find(self, iri: str, start: int, *, at_line_start: bool = False) -> int | None:
        spelt = "|".join(re.escape(name) for name in self._spellings(iri))
        before = r"^[ \t]*" if at_line_start else r"(?<![\w:.-])"
        # A comment's words are skipped by taking it as one match of its own.
        for match in re.compile(rf"(^[ \t]*#.*$)|{before}({spelt})(?![\w-])", re.MULTILINE).finditer(self.text, start):
            if match.group(2) is not None:
                return match.start(2)
        return None

    def _spellings(self, iri: str) -> Iterator[str]:
        yield f"<{iri}>"
        for prefix, namespace in self.prefixes.items():
            if iri.startswith(namespace):
                yield f"{prefix}:{iri.removeprefix(namespace)}"


def read_document(path: Path) -> Document:
    """Reads one file; nothing is fetched from anywhere.

    Raises:
        FileError: It is missing, unreadable or not Turtle; with the line.
    """
    try:
        text = path.read_text(encoding="utf-8")
        base = path.resolve().as_uri()
        parser = ox.parse(text.encode(), format=ox.RdfFormat.TURTLE, base_iri=base)
        triples = tuple(quad.triple for quad in parser)
    except FileNotFoundError:
        raise FileError(path, "there is no such file") from None
    except (OSError, UnicodeDecodeError) as error:
        raise FileError(path, f"cannot be read as UTF-8 text: {error}") from error
    except SyntaxError as error:
        reason = re.sub(r"^Parser error at line \d+.*?: ", "", error.msg)
        raise FileError(path, f"not Turtle at column {error.offset}: {reason}", line=error.lineno) from None
    return Document(path, text, _declared_iri(triples) or base, dict(parser.prefixes), triples)


def rdf_files(paths: Iterable[Path]) -> list[Path]:
    """Returns the files named, and for each folder all ``*.ttl`` below it, sorted; each file once."""
    found: dict[Path, Path] = {}
    for path in paths:
        for file in sorted(path.rglob("*.ttl")) if path.is_dir() else [path]:
            found.setdefault(file.resolve(), file)
    return list(found.values())


def _declared_iri(triples: tuple[ox.Triple, ...]) -> str | None:
    for triple in triples:
        if triple.predicate == _TYPE and triple.object == _ONTOLOGY and isinstance(triple.subject, ox.NamedNode):
            return triple.subject.value
    return None
