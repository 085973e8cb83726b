"""Writes a Python module of an ontology's words, so that a wrong or renamed one fails at type-check time."""

from __future__ import annotations

import re
import textwrap
import unicodedata
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import groupby

from skiros_py.errors import UnknownName
from skiros_py.world.names import STANDARD_PREFIXES, local_name
from skiros_py.world.ontology.ontology import Ontology
from skiros_py.world.ontology.statements import Statements

_WIDTH = 120
_KINDS = {
    "CLASS": ("ClassName", "classes"),
    "RELATION": ("RelationName", "relations"),
    "PROPERTY": ("PropertyName", "properties"),
    "INDIVIDUAL": ("IndividualName", "individuals"),
}
"""What a name ends with where two kinds share it; the type of such words; what people call many of them."""
_FOR_ALL = ("rdfs:label", "rdfs:comment")
"""Properties that every element may have; they go with the upper ontology."""


@dataclass(frozen=True, slots=True)
class _Word:
    """One word: its name in the world model, its kind and what its ontology says of it."""

    name: str
    kind: str
    comment: str

    @property
    def prefix(self) -> str:
        """The prefix of its namespace."""
        return self.name.partition(":")[0]


def constants_module(ontology: Ontology, namespaces: Sequence[str] = ()) -> str:
    """Returns the text of a module with one typed constant per class, relation, property and individual.

    Constants are in upper case (``sk:heldBy`` is ``HELD_BY``), grouped by kind and sorted. Where several words would
    have one name, all of them say their kind (``SKILL_CLASS``), then their prefix, too.

    Args:
        ontology: The ontology.
        namespaces: Prefixes of the words to write; all but the standard ones where left out.

    Raises:
        UnknownName: No file declares a prefix.
    """
    prefixes = tuple(namespaces) or namespaces_of(ontology)
    for prefix in prefixes:
        if prefix not in ontology.names.prefixes:
            raise UnknownName("prefix", prefix, namespaces_of(ontology))
    words = sorted(_words(ontology, prefixes), key=lambda word: (list(_KINDS).index(word.kind), word.name))
    return "\n".join([*_head(prefixes, namespaces, words), *_body(words)]) + "\n"


def namespaces_of(ontology: Ontology) -> tuple[str, ...]:
    """Returns the prefixes that have words of their own, sorted."""
    everything = _words(ontology, tuple(ontology.names.prefixes))
    return tuple(sorted({word.prefix for word in everything} - {*STANDARD_PREFIXES} | {"sk"}))


# ---------------------------------------------------------------- the words


def _words(ontology: Ontology, prefixes: Sequence[str]) -> Iterator[_Word]:
    statements = Statements(ontology.sources, ontology.names)
    terms: Mapping[str, Mapping[str, str]] = {
        "CLASS": {name: term.comment for name, term in ontology.classes.items()},
        "RELATION": {name: term.comment for name, term in ontology.relations.items()},
        "PROPERTY": {name: term.comment for name, term in ontology.properties.items() if name not in _FOR_ALL},
        "INDIVIDUAL": {name: statements.text(name, "rdfs:comment") for name in ontology.individuals},
    }
    for kind, comments in terms.items():
        yield from (word for n, c in comments.items() if (word := _Word(n, kind, c)).prefix in prefixes)
    if "sk" in prefixes:
        yield _Word("rdfs:label", "PROPERTY", "What people call it.")
        yield _Word("rdfs:comment", "PROPERTY", "What people note about it.")


# ---------------------------------------------------------------- their constants


def _identifiers(words: Sequence[_Word]) -> list[str]:
    """A name for each word; those that collide say ever more, all of them, until no two are the same."""
    levels = [0] * len(words)
    while True:
        names = [_identifier(word, level) for word, level in zip(words, levels, strict=True)]
        count = Counter(names)
        clashing = [index for index, name in enumerate(names) if count[name] > 1]
        if not clashing:
            return names
        for rank, index in enumerate(clashing):
            levels[index] += 1 + (rank if levels[index] >= 2 else 0)


def _identifier(word: _Word, level: int) -> str:
    base = _upper_snake(local_name(word.name))
    if not base.isidentifier() or len(base) == 1:  # "3D", or "O", which looks like a nought
        base = f"{word.kind}_{base}" if not base.isidentifier() else f"{base}_{word.kind}"
    if level == 0:
        return base
    said = base if base.endswith(f"_{word.kind}") else f"{base}_{word.kind}"
    if level == 1:
        return said
    return f"{_upper_snake(word.prefix)}_{said}" + (f"_{level - 1}" if level > 2 else "")


def _upper_snake(local: str) -> str:
    text = unicodedata.normalize("NFKC", local)
    text = re.sub(r"(?<=[a-z0-9])(?=[A-Z])|(?<=[A-Z])(?=[A-Z][a-z])", "_", text)
    return unicodedata.normalize("NFKC", re.sub(r"\W+", "_", text).upper()).strip("_")


# ---------------------------------------------------------------- the text


def _head(prefixes: Sequence[str], asked: Sequence[str], words: Sequence[_Word]) -> Iterator[str]:
    options = "".join(f" --namespace {prefix}" for prefix in asked)
    yield f"# Generated by `skiros ontology constants{options}`; do not edit."
    if not "".join(word.comment for word in words).isascii():  # some letters look like others to a linter
        yield "# ruff: noqa: RUF001, RUF100"
    listed = ", ".join(f"``{prefix}:``" for prefix in prefixes)
    yield f'"""The words of {listed} as typed constants, with what their ontology says of them."""'
    yield ""
    yield "from __future__ import annotations"
    if words:
        types = sorted({_KINDS[word.kind][0] for word in words})
        yield from ("", "from typing import Final", "", f"from skiros_py.world.names import {', '.join(types)}")


def _body(words: Sequence[_Word]) -> Iterator[str]:
    named = zip(_identifiers(words), words, strict=True)
    for kind, group in groupby(named, key=lambda pair: pair[1].kind):
        yield from ("", f"# {'-' * 64} {_KINDS[kind][1]}", "")
        for identifier, word in group:
            yield from _constant(identifier, word)


def _constant(identifier: str, word: _Word) -> Iterator[str]:
    start, value = f"{identifier}: Final = {_KINDS[word.kind][0]}(", f'"{word.name}"'
    if len(start) + len(value) + 1 <= _WIDTH:
        yield f"{start}{value})"
    else:
        yield from (start, f"    {value}", ")")
    text = " ".join(word.comment.replace("\\", "\\\\").replace('"""', "'''").split())
    if text:
        yield from _docstring(text)


def _docstring(text: str) -> list[str]:
    closing = ' """' if text.endswith('"') else '"""'
    opening = f'"""{" " if text.startswith(chr(34)) else ""}'
    lines = textwrap.wrap(opening + text, _WIDTH - len(closing), break_long_words=False, break_on_hyphens=False)
    return [*lines[:-1], lines[-1] + closing]
