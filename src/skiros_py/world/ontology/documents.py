"""Reads one ontology or scene file, and remembers how and where it spells names, so that faults can name the line."""

from __future__ import annotations

import re
from collections.abc import Callable, Container, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, fields
from pathlib import Path
from typing import Any

import pyoxigraph as ox

from skiros_py.errors import FileError
from skiros_py.files import RDF_TYPES, read_text
from skiros_py.world.literals import LONGEST_TEXT
from skiros_py.world.names import STANDARD_PREFIXES, Names, split_iri
from skiros_py.world.ontology.formats import check_json, check_turtle, outline_xml, parse_text, parse_xml


@dataclass(frozen=True, slots=True)
class Spelling:
    """How a file writes IRIs.

    Attributes:
        prefixes: IRI by prefix.
        is_turtle: True for Turtle and N-Triples, False for XML and JSON-LD.
        base: What relative IRIs start with in XML and JSON-LD.
        entities: Text by name of entity in XML.
    """

    prefixes: Mapping[str, str]
    is_turtle: bool = True
    base: str = ""
    entities: Mapping[str, str] = field(default_factory=dict)

    def line(self, text: str, subject: str | None, term: str | None) -> int | None:
        """Returns the line of the statements about ``subject``, at ``term`` (IRIs) where it occurs, or None."""
        before = r"(?<![\w:.-])" if self.is_turtle else r"[\"'</>]"
        starts = (r"^[ \t]*", before) if self.is_turtle else (_NAMED,)
        found = (self._find(text, subject, named) for named in starts)
        start = next((offset for offset in found if offset is not None), None)
        offset = self._find(text, term, before, start or 0)
        if offset is None:
            offset = start if self.is_turtle else self._find(text, term, before)
        if offset is None:
            offset = start
        return None if offset is None else text.count("\n", 0, offset) + 1

    def _find(self, text: str, iri: str | None, before: str, start: int = 0) -> int | None:
        """The offset of an IRI after a pattern; a comment's words are skipped by taking it as one match of its own."""
        if not iri:
            return None
        spellings = "|".join(re.escape(spelling) for spelling in dict.fromkeys(self._spellings(iri)) if spelling)
        comment, flags = (r"^[ \t]*#.*$", re.MULTILINE) if self.is_turtle else ("<!--.*?-->", re.MULTILINE | re.DOTALL)
        matches = re.compile(rf"{comment}|{before}({spellings})(?![\w-])", flags).finditer(text, start)
        return next((match.start(1) for match in matches if match.group(1) is not None), None)

    def _spellings(self, iri: str) -> Iterator[str]:
        yield f"<{iri}>" if self.is_turtle else iri
        if self.base and iri.startswith(self.base):
            yield iri.removeprefix(self.base)
            yield iri.removeprefix(self.base).lstrip("#/")
        for prefix, namespace in self.prefixes.items():
            if namespace and iri.startswith(namespace):
                local = iri.removeprefix(namespace)
                yield f"{prefix}:{local}" if prefix or self.is_turtle else local
        for entity, value in self.entities.items():
            if iri.startswith(value):
                yield f"&{entity};{iri.removeprefix(value)}"


_NAMED = r"(?:(?:\bI[DR]I?|:ID|:about|\babbreviatedIRI)\s*=|\"@id\"\s*:)\s*[\"']"
_TYPE = ox.NamedNode(STANDARD_PREFIXES["rdf"] + "type")
_ONTOLOGY = ox.NamedNode(STANDARD_PREFIXES["owl"] + "Ontology")
_IMPORTS = ox.NamedNode(STANDARD_PREFIXES["owl"] + "imports")
_VERSION = ox.NamedNode(STANDARD_PREFIXES["owl"] + "versionIRI")

_LANGUAGES = {".nt": ox.RdfFormat.N_TRIPLES, ".jsonld": ox.RdfFormat.JSON_LD}
"""Formats that are known by the ends of names alone."""
_OTHER_START = re.compile(r"(?:\s|#.*\n)*(?:Prefix|Ontology)(?:\s*\(|:)")
"""How OWL's functional and Manchester syntaxes begin."""
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
        aliases: Further IRIs by which it is imported.
    """

    path: Path
    text: str
    iri: str
    prefixes: Mapping[str, str]
    triples: tuple[ox.Triple, ...]
    spelling: Spelling
    aliases: tuple[str, ...] = ()

    @property
    def is_turtle(self) -> bool:
        """True for Turtle, which people write by hand; False for XML and JSON-LD, which tools write."""
        return self.spelling.is_turtle

    def imports(self) -> tuple[str, ...]:
        """Returns the IRIs that it imports, sorted."""
        return tuple(sorted(self._named(_IMPORTS)))

    def iris(self) -> set[str]:
        """Returns the IRIs by which it can be imported."""
        return {self.iri, *self._named(_VERSION), *self.aliases}

    def _named(self, predicate: ox.NamedNode) -> Iterator[str]:
        found = (t.object for t in self.triples if t.predicate == predicate)
        return (term.value for term in found if isinstance(term, ox.NamedNode))

    def fault(self, reason: str, subject: str | None = None, term: str | None = None) -> FileError:
        """Makes the error for a fault in the statements about ``subject``, at ``term`` (both IRIs) where it occurs."""
        return FileError(self.path, reason, line=self.spelling.line(self.text, subject, term))

    def __reduce__(self) -> tuple[Callable[..., Document], tuple[object, ...]]:
        # Ten times faster than triple by triple.
        packed = ox.serialize(self.triples, format=ox.RdfFormat.N_TRIPLES)
        return _unpacked, (
            packed,
            {each.name: getattr(self, each.name) for each in fields(self) if each.name != "triples"},
        )


def read_document(path: Path) -> Document:
    """Reads one file; nothing is fetched from anywhere.

    A ``.ttl`` file is Turtle, ``.nt`` N-Triples, ``.jsonld`` JSON-LD. Any other is RDF/XML or OWL/XML where it begins
    like XML, else Turtle.

    Raises:
        FileError: It is missing, unreadable, in none of these languages, or made to do harm; with the line where known.
    """
    text = read_text(path)
    base = path.resolve().as_uri()
    language = _LANGUAGES.get(path.suffix, ox.RdfFormat.TURTLE)
    if language == ox.RdfFormat.JSON_LD:
        check_json(path, text)
        prefixes, triples = parse_text(path, text, base, language)
        spelling = Spelling(prefixes, is_turtle=False, base=base)
    elif path.suffix in (".ttl", ".nt") or not _XML_START.match(text):
        if _OTHER_START.match(text):
            form = "OWL's functional or Manchester syntax, which is not read"
            raise FileError(path, f"is in {form}: save it as RDF/XML, OWL/XML or Turtle, as Protégé does")
        check_turtle(path, text)
        prefixes, triples = parse_text(path, text, base, language)
        if not triples and path.suffix not in (".ttl", ".nt"):
            raise FileError(path, "says nothing: it should be RDF/XML or OWL/XML")
        spelling = Spelling(prefixes)
    else:
        outline = outline_xml(path, text)
        prefixes, triples = outline.prefixes, parse_xml(path, text, base, outline)
        spelling = Spelling(prefixes, is_turtle=False, base=outline.base or base, entities=outline.entities)
    document = Document(path, text, _declared_iri(triples) or base, prefixes, triples, spelling)
    _check_literals(document)
    return document


def rdf_files(paths: Iterable[Path]) -> list[Path]:
    """Returns the files named, and for each folder all ontology files below it, sorted; each file once.

    These are the files that end as :data:`~skiros_py.files.RDF_TYPES` says; of those that end in ``.xml`` only what
    speaks of RDF or OWL (robot models and Protégé's catalogues end so too).
    """
    found: dict[Path, Path] = {}
    for path in paths:
        for file in sorted(filter(_is_rdf, path.rglob("*"))) if path.is_dir() else [path]:
            found.setdefault(file.resolve(), file)
    return list(found.values())


def _is_rdf(path: Path) -> bool:
    if path.suffix not in RDF_TYPES or not path.is_file():
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


def _unpacked(packed: bytes, others: Mapping[str, Any]) -> Document:
    triples = tuple([quad.triple for quad in ox.parse(packed, format=ox.RdfFormat.N_TRIPLES)])
    return Document(**others, triples=triples)


# ---------------------------------------------------------------- the common prefix table


_PREFIX = re.compile(r"[A-Za-z]([\w.-]*[\w-])?")
_MEANINGLESS = re.compile(r"v?\d[\d._-]*|ontolog(y|ies)|ontos?|owl|rdf|ns|schemas?|terms", re.IGNORECASE)


def common_names(files: Sequence[Document]) -> Names:
    """Returns the prefix table of all files together.

    - The empty prefix is private to its file.
    - Turtle is written by hand: two Turtle files that mean different things by one prefix are refused.
    - XML is written by tools, which number prefixes or call every ontology alike: what a Turtle file or an earlier XML
      file means by a prefix holds, and another namespace called so goes without.
    - A namespace with terms or individuals that goes without is called after the last word of its IRI that means
      something, in lower case, with a number if that is taken ("http://example.org/2024/Tools.owl#" -> ``tools:``).

    Raises:
        FileError: A prefix stands for two IRIs in Turtle files.
    """
    prefixes = dict(STANDARD_PREFIXES)
    for file in sorted(files, key=lambda file: not file.is_turtle):
        for prefix, iri in file.prefixes.items():
            if not _PREFIX.fullmatch(prefix) or not (file.is_turtle or iri.endswith(("#", "/", ":"))):
                continue
            if prefixes.setdefault(prefix, iri) != iri and file.is_turtle:
                said = f"prefix '{prefix}:' stands for <{iri}> here and for <{prefixes[prefix]}> elsewhere"
                raise FileError(file.path, said)
    for namespace in sorted(_namespaces(files) - set(prefixes.values())):
        prefixes[_made(namespace, prefixes)] = namespace
    return Names(prefixes)


def _namespaces(files: Iterable[Document]) -> set[str]:
    """The namespaces of everything that files give a type."""
    subjects = {
        triple.subject.value
        for file in files
        for triple in file.triples
        if triple.predicate == _TYPE and triple.object != _ONTOLOGY and isinstance(triple.subject, ox.NamedNode)
    }
    return {namespace for namespace, local in map(split_iri, subjects) if namespace and local}


def _made(namespace: str, taken: Container[str]) -> str:
    words = [re.sub(r"\.(owl|rdf|ttl|xml|owx|nt|jsonld)$", "", word) for word in re.split(r"[/#:]+", namespace) if word]
    word = next((word for word in reversed(words) if not _MEANINGLESS.fullmatch(word)), "")
    name = re.sub(r"[^a-z0-9]+", "_", word.lower()).strip("_")
    name = name if name[:1].isalpha() else f"ns{name}"
    number = 2
    unique = name
    while unique in taken:
        unique, number = f"{name}{number}", number + 1
    return unique
