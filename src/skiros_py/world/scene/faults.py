"""Where in the files something was said: looked for only once it turned out wrong."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence

from skiros_py.errors import FileError
from skiros_py.world.names import Names
from skiros_py.world.ontology.documents import Document

__all__ = ["fault_about", "fault_of_all"]

_MOST_SHOWN = 10
_CURIE = re.compile(r"[\w-]+:[\w-]+")


def fault_about(files: Sequence[Document], names: Names, reason: str, name: str, terms: Sequence[str]) -> FileError:
    """Makes the error for what is wrong with an individual.

    Args:
        files: The files that may speak of it, that which matters most first.
        names: How names become IRIs.
        reason: What is wrong.
        name: The individual.
        terms: Names that the statement in question consists of besides; the last one is pointed at.
    """
    iri, wanted = _iri(names, name), {_iri(names, term) for term in terms}
    said = [(file, said) for file in files for said in _statements(file, iri)]
    exact = [file for file, terms in said if wanted <= set(terms)]
    file = (exact or [file for file, _ in said] or [files[0]])[0]
    return file.fault(reason, iri, _iri(names, terms[-1]) if terms else None)


def fault_of_all(files: Sequence[Document], names: Names, problems: Sequence[tuple[str, str]]) -> FileError:
    """Makes one error of many (individual, what is wrong with it), each with its line, at the line of the first."""
    once = list(dict.fromkeys(problems))
    faults = [_fault(files, names, name or "this", sentence) for name, sentence in once[:_MOST_SHOWN]]
    faults.sort(key=lambda fault: (fault.path != files[0].path, str(fault.path), fault.line or 0))
    first = faults[0]
    if len(once) == 1:
        return first
    shown = [f"{fault.path.name}:{fault.line}: {fault.reason}" if fault.line else fault.reason for fault in faults]
    more = [f"and {len(once) - _MOST_SHOWN} more"] if len(once) > _MOST_SHOWN else []
    return FileError(first.path, "\n  - ".join(["is refused:", *shown, *more]), line=first.line)


def _fault(files: Sequence[Document], names: Names, name: str, sentence: str) -> FileError:
    """The sentence names the predicate that is to blame, if any is."""
    named = set(_CURIE.findall(sentence))
    iri = _iri(names, name)
    predicates = [names.name(said[0]) for file in files for said in _statements(file, iri)]
    return fault_about(files, names, sentence, name, [p for p in predicates if p in named][:1])


def _statements(file: Document, iri: str) -> Iterator[tuple[str, str]]:
    """Yields (predicate, object) of what a file says of an individual."""
    for triple in file.triples:
        if getattr(triple.subject, "value", None) == iri:  # what was written for a name need not be an IRI
            yield triple.predicate.value, getattr(triple.object, "value", "")


def _iri(names: Names, name: str) -> str:
    """The IRI of a name; a name that no prefix was found for is one itself."""
    prefix, colon, _ = name.partition(":")
    return name if colon and prefix not in names.prefixes else names.iri(name)
