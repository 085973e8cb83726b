"""What is too deep or says nothing is refused before it costs anything."""

from __future__ import annotations

import time
from pathlib import Path

import pytest

from skiros_py.errors import FileError
from skiros_py.world.ontology import Ontology
from skiros_py.world.ontology.documents import read_document
from skiros_py.world.terms import MOST_ABOVE

_HEAD = """@prefix : <http://c#> . @prefix owl: <http://www.w3.org/2002/07/owl#> .
@prefix rdfs: <http://www.w3.org/2000/01/rdf-schema#> .
"""
_WORDS = [("Class", "subClassOf"), ("ObjectProperty", "subPropertyOf"), ("Class", "equivalentClass")]


def _chain(folder: Path, type_: str, word: str, levels: int) -> Path:
    lines = [f":C0 a owl:{type_} ."]
    prefix = "owl" if word == "equivalentClass" else "rdfs"
    lines += [f":C{n} a owl:{type_} ; {prefix}:{word} :C{n - 1} ." for n in range(1, levels + 1)]
    file = folder / "chain.ttl"
    file.write_text(_HEAD + "\n".join(lines), encoding="utf-8")
    return file


@pytest.mark.parametrize(("type_", "word"), _WORDS)
def test_a_hierarchy_deeper_than_the_limit_is_refused_quickly(tmp_path: Path, type_: str, word: str) -> None:
    start = time.monotonic()

    with pytest.raises(FileError, match=f"has more than {MOST_ABOVE} terms above it") as raised:
        Ontology.load([_chain(tmp_path, type_, word, 5000)])

    assert raised.value.path.name == "chain.ttl"
    assert time.monotonic() - start < 10.0


@pytest.mark.parametrize(("type_", "word"), _WORDS)
def test_a_hierarchy_as_deep_as_the_limit_is_accepted(tmp_path: Path, type_: str, word: str) -> None:
    Ontology.load([_chain(tmp_path, type_, word, MOST_ABOVE)])


@pytest.mark.parametrize("name", ["a.owx", "a.owl", "a.rdf", "a.xml"])
@pytest.mark.parametrize("text", ["", " \n", "# nothing\n", '<?xml version="1.0"?>\n', "<!-- nothing -->"])
def test_an_empty_or_invalid_xml_file_is_refused(tmp_path: Path, name: str, text: str) -> None:
    file = tmp_path / name
    file.write_text(text, encoding="utf-8")

    with pytest.raises(FileError, match=r"says nothing|not XML"):
        read_document(file)


def test_an_empty_turtle_file_is_an_ontology_without_terms(tmp_path: Path) -> None:
    file = tmp_path / "a.ttl"
    file.write_text("", encoding="utf-8")

    assert read_document(file).triples == ()
