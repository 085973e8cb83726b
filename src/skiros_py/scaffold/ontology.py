"""Writes an ontology: classes, relations and properties of a domain, under a prefix of its own."""

from __future__ import annotations

import re
import tempfile
from collections.abc import Collection, Sequence
from dataclasses import dataclass
from pathlib import Path

from skiros_py.errors import FileError, UnknownName, UsageError
from skiros_py.scaffold.declared import class_name, module_name, sentence, words_of
from skiros_py.scaffold.draft import Draft, render
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
class NewOntology:
    """The author's options for an ontology.

    Attributes:
        name: Its name, and its prefix ("scanning").
        help: One sentence; derived from the name if omitted.
        classes: ``NAME:PARENT`` ("Scanner:sk:Device").
        relations: ``NAME:DOMAIN:RANGE`` ("scannedAt:sk:Manipulatable:sk:Station").
        properties: ``NAME:DOMAIN:TYPE`` ("scanned:sk:Manipulatable:boolean").
    """

    name: str
    help: str = ""
    classes: tuple[str, ...] = ()
    relations: tuple[str, ...] = ()
    properties: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True)
class _Word:
    """One word with the words that it is declared by."""

    name: str
    label: str
    help: str
    parent: str = ""
    domain: str = ""
    range: str = ""


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
    words = [_parts(known, prefix, said, text, kind) for kind, text in _said(said)]
    _check_names([word.name for word in words])
    count = len(said.classes), len(said.relations)
    others = {prefix_of(curie) for w in words for curie in (w.parent, w.domain, w.range) if curie} - {prefix}
    package = known.project.package
    text = render(
        "ontology.ttl",
        prefix=prefix,
        iri=f"https://example.org/{package}/{prefix}",
        prefixes=prefix_table(known.ontology, others),
        imports=declaring(known.ontology, others),
        label=words_of(prefix),
        help=sentence(said.help or f"The words of {words_of(prefix)}", "--help-text"),
        classes=words[: count[0]],
        relations=words[count[0] : sum(count)],
        properties=words[sum(count) :],
    )
    _check(known, prefix, text)
    project = known.project
    if not project.entry_points.get("skiros.ontologies"):
        project = project.with_entries("skiros.ontologies", {package: package})
    return Draft(project.root, {f"src/{package}/ontologies/{prefix}.ttl": text}, project.changes(known.project))


def _check(known: Knowledge, prefix: str, text: str) -> None:
    """Loads it together with the others, because their statements may contradict each other."""
    with tempfile.TemporaryDirectory(prefix="skiros-new-") as folder:
        file = Path(folder) / f"{prefix}.ttl"
        file.write_text(text, encoding="utf-8")
        try:
            Ontology.of([*known.ontology.sources, read_document(file)])
        except FileError as error:
            raise UsageError(f"ontology '{prefix}': {error.reason}") from error


def _said(said: NewOntology) -> list[tuple[str, str]]:
    return [
        *(("class", text) for text in said.classes),
        *(("relation", text) for text in said.relations),
        *(("property", text) for text in said.properties),
    ]


_SHAPES = {
    "class": (re.compile(rf"(\w+):({_CURIE})"), "NAME:PARENT", "Scanner:sk:Device"),
    "relation": (re.compile(rf"(\w+):({_CURIE}):({_CURIE})"), "NAME:DOMAIN:RANGE", "scannedAt:sk:Object:sk:Station"),
    "property": (re.compile(rf"(\w+):({_CURIE}):(\w+)"), "NAME:DOMAIN:TYPE", "scanned:sk:Manipulatable:boolean"),
}
"""How a word of each kind is declared in a few letters, in words and by example."""


def _parts(known: Knowledge, prefix: str, said: NewOntology, text: str, kind: str) -> _Word:
    shape, form, example = _SHAPES[kind]
    declared, _, help_ = text.partition(" -- ")
    match = shape.fullmatch(declared.strip())
    if match is None:
        raise UsageError(f"--{kind} '{text}': write {form}, such as {example}")
    name, *others = match.groups()
    own = {f"{prefix}:{declared.partition(':')[0]}" for declared in said.classes}
    label = words_of(name)
    if kind == "class":
        help_ = sentence(help_ or f"A {label}", f"help of {name}")
        return _Word(class_name(name, "class"), label, help_, parent=_class(known, others[0], own))
    if not _LOWER.fullmatch(name):
        raise UsageError(f"{kind} '{name}': letters and digits that begin with a small letter, such as scannedAt")
    domain = _class(known, others[0], own)
    if kind == "relation":
        help_ = sentence(help_ or f"The subject is {label} the object", f"help of {name}")
        return _Word(name, label, help_, domain=domain, range=_class(known, others[1], own))
    help_ = sentence(help_ or f"What is known of it: {label}", f"help of {name}")
    return _Word(name, label, help_, domain=domain, range=_range(name, others[1]))


def _class(known: Knowledge, curie: str, own: Collection[str]) -> str:
    if curie not in own and curie not in known.ontology.classes:
        raise UnknownName("class", curie, [*known.ontology.classes, *own])
    return curie


def _range(name: str, type_: str) -> str:
    if type_ not in _RANGES:
        raise UnknownName("type", type_, _RANGES, where=f"of property '{name}'")
    return _RANGES[type_]


def _check_names(names: Sequence[str]) -> None:
    twice = [name for name in names if names.count(name) > 1]
    if twice:
        raise UsageError(f"'{twice[0]}' is declared twice")
