"""Reads one ontology or scene file, and remembers how it spells names, so that faults can name a line."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path

import pyoxigraph as ox

from skiros_py.errors import FileError
from skiros_py.world.datatype import LONGEST_TEXT
from skiros_py.world.names import STANDARD_PREFIXES
from skiros_py.world.ontology.formats import parse_turtle, parse_xml
from skiros_py.world.ontology.guards import check_turtle, outline_xml, read_text
from skiros_py.world.ontology.spelling import TurtleSpelling, XmlSpelling

__all__ = ["Document", "rdf_files", "read_document"]

_TYPE = ox.NamedNode(STANDARD_PREFIXES["rdf"] + "type")
_ONTOLOGY = ox.NamedNode(STANDARD_PREFIXES["owl"] + "Ontology")
_IMPORTS = ox.NamedNode(STANDARD_PREFIXES["owl"] + "imports")

_SUFFIXES = (".ttl", ".owl", ".rdf", ".owx", ".xml")
_XML_SUFFIXES = (".owl", ".rdf", ".owx", ".xml")
_XML_START = re.compile(r"\s*<(?:\?xml|!|[A-Za-z_][\w.-]*(?::[A-Za-z_][\w.-]*)?[\s/>])")


@dataclass(frozen=True, slots=True)
class Document:
    """One parsed file.

    Attributes:
        path: Where it is.
        text: What it says.
        iri: IRI of the ontology it declares, else the file's own.
        prefixes: IRI by prefix, as declared in it.
        triples: Its statements in file order.
        spelling: How it writes IRIs.
    """

    path: Path
    text: str
    iri: str
    prefixes: Mapping[str, str]
    triples: tuple[ox.Triple, ...]
    spelling: TurtleSpelling | XmlSpelling

    @property
    def is_turtle(self) -> bool:
        """True for Turtle, which people write by hand; False for XML, which tools write."""
        return isinstance(self.spelling, TurtleSpelling)

    def imports(self) -> tuple[str, ...]:
        """Returns the IRIs that it imports, sorted."""
        found = (t.object for t in self.triples if t.predicate == _IMPORTS)
        return tuple(sorted(term.value for term in found if isinstance(term, ox.NamedNode)))

    def fault(self, reason: str, subject: str | None = None, term: str | None = None) -> FileError:
        """Makes the error for a fault in the statements about ``subject``, at ``term`` (both IRIs) where it occurs."""
        return FileError(self.path, reason, line=self.spelling.line(self.text, subject, term))

    def __reduce__(self) -> tuple[Callable[..., Document], tuple[object, ...]]:
        # Ten times faster than triple by triple.
        packed = ox.serialize(self.triples, format=ox.RdfFormat.N_TRIPLES)
        return _unpacked, (self.path, self.text, self.iri, self.prefixes, packed, self.spelling)


def read_document(path: Path) -> Document:
    """Reads one file; nothing is fetched from anywhere.

    A ``.ttl`` file is Turtle. Any other is RDF/XML or OWL/XML where it begins like XML, else Turtle.

    Raises:
        FileError: It is missing, unreadable, in none of these languages, or made to do harm; with the line where known.
    """
    text = read_text(path)
    base = path.resolve().as_uri()
    if path.suffix == ".ttl" or not _XML_START.match(text):
        check_turtle(path, text)
        prefixes, triples = parse_turtle(path, text, base)
        if not triples and path.suffix in _XML_SUFFIXES:
            raise FileError(path, "says nothing: it should be RDF/XML or OWL/XML")
        spelling: TurtleSpelling | XmlSpelling = TurtleSpelling(prefixes)
    else:
        outline = outline_xml(path, text)
        prefixes, triples = outline.prefixes, parse_xml(path, text, base, outline)
        spelling = XmlSpelling(prefixes, outline.base or base, outline.entities)
    document = Document(path, text, _declared_iri(triples) or base, prefixes, triples, spelling)
    _check_literals(document)
    return document


def rdf_files(paths: Iterable[Path]) -> list[Path]:
    """Returns the files named, and for each folder all ontology files below it, sorted; each file once.

    These are the files that end in ``.ttl``, ``.owl``, ``.rdf``, ``.owx``, and those that end in ``.xml`` and speak of
    RDF or OWL (robot models and Protégé's catalogues end so too).
    """
    found: dict[Path, Path] = {}
    for path in paths:
        for file in sorted(filter(_is_rdf, path.rglob("*"))) if path.is_dir() else [path]:
            found.setdefault(file.resolve(), file)
    return list(found.values())


def _is_rdf(path: Path) -> bool:
    if path.suffix not in _SUFFIXES or not path.is_file():
        return False
    if path.suffix != ".xml":
        return True
    with path.open("rb") as file:
        head = file.read(8192)
    return STANDARD_PREFIXES["rdf"].encode() in head or STANDARD_PREFIXES["owl"].encode() in head


def _check_literals(document: Document) -> None:
    # Entities make texts longer than the file by a known factor at most, so a short file needs no look.
    if len(document.text) < LONGEST_TEXT and document.is_turtle:
        return
    for triple in document.triples:
        if isinstance(triple.object, ox.Literal) and len(triple.object.value) > LONGEST_TEXT:
            reason = f"a text has {len(triple.object.value)} characters, and may have {LONGEST_TEXT}"
            subject = triple.subject.value if isinstance(triple.subject, ox.NamedNode) else None
            raise document.fault(reason, subject, triple.predicate.value)


def _declared_iri(triples: tuple[ox.Triple, ...]) -> str | None:
    for triple in triples:
        if triple.object == _ONTOLOGY and triple.predicate == _TYPE and isinstance(triple.subject, ox.NamedNode):
            return triple.subject.value
    return None


def _unpacked(
    path: Path, text: str, iri: str, prefixes: Mapping[str, str], packed: bytes, spelling: TurtleSpelling | XmlSpelling
) -> Document:
    triples = tuple([quad.triple for quad in ox.parse(packed, format=ox.RdfFormat.N_TRIPLES)])
    return Document(path, text, iri, prefixes, triples, spelling)
