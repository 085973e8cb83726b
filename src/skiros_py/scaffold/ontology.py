"""Writes an ontology: classes, relations and properties of a domain, under a prefix of its own."""

from __future__ import annotations

import re
import tempfile
from collections.abc import Collection
from dataclasses import dataclass
from pathlib import Path

from skiros_py.errors import FileError, UnknownName, UsageError
from skiros_py.scaffold.declared import class_name, module_name, sentence, words_of
from skiros_py.scaffold.draft import Draft, render
from skiros_py.scaffold.orders import NewOntology
from skiros_py.scaffold.project import Knowledge
from skiros_py.world.names import STANDARD_PREFIXES
from skiros_py.world.ontology import Ontology
from skiros_py.world.ontology.documents import read_document


def prefix_of(curie: str) -> str:
    """Returns the prefix of a name ("sk:Arm" is of "sk")."""
    return curie.partition(":")[0]


def prefix_table(ontology: Ontology, prefixes: Collection[str]) -> list[tuple[str, str]]:
    """Returns (prefix, IRI) of those prefixes that are not the same in every file, sorted."""
    return [(p, ontology.names.prefixes[p]) for p in sorted(set(prefixes) - set(STANDARD_PREFIXES))]


def declaring(ontology: Ontology, prefixes: Collection[str]) -> list[str]:
    """Returns the IRIs of the files that a file with words of some prefixes must import: the upper ontology first."""
    spaces = {iri for _, iri in prefix_table(ontology, prefixes)}
    own = sorted(file.iri for file in ontology.sources if {f"{file.iri}#", f"{file.iri}/"} & spaces)
    return ["https://w3id.org/skiros-py/core", *own]


_RANGES = {
    "boolean": "xsd:boolean",
    "number": "xsd:decimal",
    "integer": "xsd:integer",
    "text": "xsd:string",
    "pose": "sk:poseLiteral",
    "vector": "sk:vectorLiteral",
    "class": "sk:className",
}
"""Data type of a property by its common name."""

_LOWER = re.compile(r"[a-z][A-Za-z0-9]{0,39}")
_CURIE = r"[A-Za-z][\w.-]*:\w+"


@dataclass(frozen=True, slots=True)
class _Kind:
    """A kind of word: the option for it, the form of its declaration, its RDF type and its default help."""

    option: str
    form: str
    example: str
    shape: re.Pattern[str]
    type: str
    help: str


_CLASS = _Kind("--class", "NAME:PARENT", "Scanner:sk:Device", re.compile(rf"(\w+):({_CURIE})"), "owl:Class", "A {}")
_RELATION = _Kind(
    "--relation",
    "NAME:DOMAIN:RANGE",
    "scannedAt:sk:Object:sk:Station",
    re.compile(rf"(\w+):({_CURIE}):({_CURIE})"),
    "owl:ObjectProperty",
    "The subject is {} the object",
)
_PROPERTY = _Kind(
    "--property",
    "NAME:DOMAIN:TYPE",
    "scanned:sk:Manipulatable:boolean",
    re.compile(rf"(\w+):({_CURIE}):(\w+)"),
    "owl:DatatypeProperty",
    "What is known of it: {}",
)


def draft_ontology(known: Knowledge, said: NewOntology) -> Draft:
    """Writes an ontology file; all in the folder ``ontologies`` of a package are found by one entry point.

    Raises:
        UsageError: An option is not valid; the text explains what would be.
    """
    prefix = module_name(said.name, "ontology")
    if prefix in known.ontology.names.prefixes:
        iri = known.ontology.names.prefixes[prefix]
        raise UsageError(f"ontology '{prefix}': the prefix {prefix}: stands for <{iri}> already; choose another name")
    if not (said.classes or said.relations or said.properties):
        raise UsageError(f"ontology '{prefix}': give a --class, --relation or --property: it has no word yet")
    classes = {*known.ontology.classes, *(f"{prefix}:{text.partition(':')[0]}" for text in said.classes)}
    words = [
        _word(kind, text, classes)
        for kind, texts in ((_CLASS, said.classes), (_RELATION, said.relations), (_PROPERTY, said.properties))
        for text in texts
    ]
    names = [word["name"] for word in words]
    if twice := next((name for name in names if names.count(name) > 1), None):
        raise UsageError(f"'{twice}' is declared twice")
    curies = [word[key] for word in words for key in ("parent", "domain", "range")]
    others = {prefix_of(curie) for curie in curies if curie} - {prefix}
    package = known.project.package
    text = render(
        "ontology.ttl",
        prefix=prefix,
        iri=f"https://example.org/{package}/{prefix}",
        prefixes=prefix_table(known.ontology, others),
        imports=declaring(known.ontology, others),
        label=words_of(prefix),
        help=sentence(said.help or f"The words of {words_of(prefix)}", "--help-text"),
        words=words,
    )
    _check(known, prefix, text)
    new = {f"src/{package}/ontologies/{prefix}.ttl": text}
    return known.project.with_folder("ontologies").draft(new, known.project)


def _check(known: Knowledge, prefix: str, text: str) -> None:
    """Loads it together with the others, because their statements may contradict each other."""
    with tempfile.TemporaryDirectory(prefix="skiros-new-") as folder:
        file = Path(folder) / f"{prefix}.ttl"
        file.write_text(text, encoding="utf-8")
        try:
            Ontology.of([*known.ontology.sources, read_document(file)])
        except FileError as error:
            raise UsageError(f"ontology '{prefix}': {error.reason}") from error


def _word(kind: _Kind, text: str, classes: Collection[str]) -> dict[str, str]:
    """Returns the values of a word for the template."""
    declared, _, help_ = text.partition(" -- ")
    match = kind.shape.fullmatch(declared.strip())
    if match is None:
        raise UsageError(f"{kind.option} '{text}': write {kind.form}, such as {kind.example}")
    name, first, *others = match.groups()
    if kind is _CLASS:
        class_name(name, "class")
    elif not _LOWER.fullmatch(name):
        what = kind.option.removeprefix("--")
        raise UsageError(f"{what} '{name}': letters and digits that begin with a small letter, such as scannedAt")
    if unknown := next((curie for curie in (first, *others) if ":" in curie and curie not in classes), None):
        raise UnknownName("class", unknown, classes)
    if kind is _PROPERTY and others[0] not in _RANGES:
        raise UnknownName("type", others[0], _RANGES, where=f"of property '{name}'")
    label = words_of(name)
    help_ = sentence(help_ or kind.help.format(label), f"help of {name}")
    parent, domain = ("", first) if others else (first, "")
    range_ = "".join(_RANGES.get(other, other) for other in others)
    ends = {"parent": parent, "domain": domain, "range": range_}
    return {"type": kind.type, "name": name, "label": label, "help": help_, **ends}
