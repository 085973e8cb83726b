"""Imported ontologies are found in local folders, and what is missing is said once."""

from __future__ import annotations

import pickle
import socket
from pathlib import Path

import pytest

from skiros_py.errors import FileError
from skiros_py.world.ontology import Ontology
from skiros_py.world.ontology.check.checking import check_ontology
from skiros_py.world.ontology.check.material import FindingKind, Severity
from skiros_py.world.ontology.documents import read_document
from skiros_py.world.ontology.imports import CATALOGUE, with_imports

UPPER = "http://example.org/upper"
OWL = "@prefix owl: <http://www.w3.org/2002/07/owl#> . @prefix rdfs: <http://www.w3.org/2000/01/rdf-schema#> .\n"
MINE = (
    OWL + f"<http://example.org/mine> a owl:Ontology ; owl:imports <{UPPER}>, <http://example.org/more> .\n"
    f"<http://example.org/mine#A> a owl:Class ; rdfs:subClassOf <{UPPER}#B>, <http://example.org/more#C> .\n"
)


def catalogue(*uris: tuple[str, str]) -> str:
    entries = "".join(f'<group><uri id="x" name="{name}" uri="{uri}"/></group>' for name, uri in uris)
    return f'<catalog prefer="public" xmlns="urn:oasis:names:tc:entity:xmlns:xml:catalog">{entries}</catalog>'


@pytest.fixture
def mine(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """An ontology with two imports, and an empty folder for those."""
    (tmp_path / "public").mkdir()
    monkeypatch.setenv("SKIROS_IMPORTS", str(tmp_path / "public"))
    monkeypatch.setattr(socket, "getaddrinfo", lambda *_: pytest.fail("the network is asked"))
    file = tmp_path / "mine.ttl"
    file.write_text(MINE, encoding="utf-8")
    return file


def put(mine: Path, name: str, iri: str, term: str, *imports: str) -> Path:
    file = mine.parent / "public" / name
    imported = "".join(f"<{iri}> owl:imports <{other}> .\n" for other in imports)
    file.write_text(OWL + f"<{iri}> a owl:Ontology .\n{imported}<{term}> a owl:Class .\n", encoding="utf-8")
    return file


def test_imports_are_found_by_the_iris_that_files_declare_also_indirectly_and_nothing_else_is_read(mine: Path) -> None:
    put(mine, "any_name.ttl", UPPER, f"{UPPER}#B", "http://example.org/more")
    put(mine, "more.ttl", "http://example.org/more", "http://example.org/more#C")
    put(mine, "unrelated.ttl", "http://example.org/unrelated", "http://example.org/unrelated#D")

    ontology = Ontology.load([mine])

    assert set(ontology.classes) == {"mine:A", "upper:B", "more:C"}
    assert [file.path.name for file in ontology.sources] == ["mine.ttl", "more.ttl", "any_name.ttl"]


def test_a_version_iri_can_be_imported(mine: Path) -> None:
    put(mine, "more.ttl", "http://example.org/more", "http://example.org/more#C")
    file = put(mine, "upper.ttl", "http://example.org/other", f"{UPPER}#B")
    file.write_text(file.read_text() + f"<http://example.org/other> owl:versionIRI <{UPPER}> .", encoding="utf-8")

    assert "upper:B" in Ontology.load([mine]).classes


@pytest.mark.parametrize("beside", [True, False], ids=["beside the importing file", "in an import folder"])
def test_a_catalogue_as_protege_writes_it_names_files_with_other_iris(mine: Path, beside: bool) -> None:
    put(mine, "up per.ttl", "http://example.org/moved", f"{UPPER}#B")
    put(mine, "more.ttl", "http://example.org/more", "http://example.org/more#C")
    folder = mine.parent if beside else mine.parent / "public"
    uri = "public/up%20per.ttl" if beside else "up%20per.ttl"
    (folder / CATALOGUE).write_text(catalogue((UPPER, uri), ("http://example.org/more", "http://example.org/more")))

    ontology = Ontology.load([mine])

    assert "upper:B" in ontology.classes
    assert not check_ontology([mine], "none").errors
    assert pickle.loads(pickle.dumps(ontology)).sources[-1].iris() == ontology.sources[-1].iris()


def test_a_file_that_a_catalogue_names_and_that_is_not_there_is_named(mine: Path) -> None:
    (mine.parent / CATALOGUE).write_text(catalogue((UPPER, "gone.owl")))

    with pytest.raises(FileError, match=r"gone\.owl: there is no such file"):
        Ontology.load([mine])
    assert "there is no such file" in check_ontology([mine], "none").findings[0].text


def test_a_catalogue_with_an_entity_of_another_file_is_refused(mine: Path) -> None:
    text = catalogue((UPPER, "&x;"))
    (mine.parent / CATALOGUE).write_text(f'<!DOCTYPE c [<!ENTITY x SYSTEM "file:///etc/passwd">]>{text}')

    with pytest.raises(FileError, match="refers to another file"):
        Ontology.load([mine])


def test_a_broken_file_in_an_import_folder_hinders_no_other_import(
    mine: Path, caplog: pytest.LogCaptureFixture
) -> None:
    put(mine, "more.ttl", "http://example.org/more", "http://example.org/more#C")
    put(mine, "upper.ttl", UPPER, f"{UPPER}#B")
    (mine.parent / "public" / "broken.ttl").write_text("no turtle")

    assert "upper:B" in Ontology.load([mine]).classes
    assert "broken.ttl:1: not Turtle" in caplog.text


def test_missing_imports_are_one_error_with_all_terms_that_they_may_declare(mine: Path) -> None:
    text = f"<http://example.org/mine#r> a owl:ObjectProperty ; rdfs:domain <{UPPER}#D> .\n"
    mine.write_text(MINE + text, encoding="utf-8")

    (finding,) = check_ontology([mine], "none").findings

    assert (finding.kind, finding.severity, finding.line) == (FindingKind.IMPORT, Severity.ERROR, 2)
    assert f"imports are missing: <http://example.org/more>, <{UPPER}>: put the files into a folder" in finding.text
    assert "undeclared without them (3): http://example.org/more#C, http://example.org/upper#B" in finding.text


def test_a_missing_import_of_which_nothing_is_used_is_a_warning(mine: Path) -> None:
    mine.write_text(MINE.replace("<http://example.org/more#C>", f"<{UPPER}#B>"), encoding="utf-8")
    put(mine, "upper.ttl", UPPER, f"{UPPER}#B")

    (finding,) = check_ontology([mine], "none").findings

    assert (finding.kind, finding.severity) == (FindingKind.IMPORT, Severity.WARNING)
    assert Ontology.load([mine])


def test_an_ontology_that_is_imported_under_two_iris_is_read_once(mine: Path) -> None:
    put(mine, "both.ttl", "http://example.org/both", f"{UPPER}#B")
    other = ("http://example.org/more", "both.ttl")
    (mine.parent / "public" / CATALOGUE).write_text(catalogue((UPPER, "both.ttl"), other))

    assert [file.path.name for file in with_imports([read_document(mine)])] == ["mine.ttl", "both.ttl"]
