"""Every fault of the declarations is found, and nothing else."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest

from skiros_py.world.ontology.check.checking import CheckReport, check_ontology
from skiros_py.world.ontology.check.material import FindingKind, Severity

Check = Callable[..., CheckReport]

FAULTS = {
    "a superclass that nobody declares": (
        ":A a owl:Class ; rdfs:subClassOf :Bal .",
        "undeclared",
        "Did you mean 'toy:Ball'",
    ),
    "a type that nobody declares": (":x a :Bal .", "undeclared", "unknown class 'toy:Bal'"),
    "a relation that nobody declares": (
        ":x a :Ball ; :lieks :x .",
        "undeclared",
        "'toy:lieks'. Did you mean 'toy:likes'",
    ),
    "an annotation that nobody declares": (":Ball :colour 'red' .", "undeclared", "'toy:colour'"),
    "a data type that nobody declares": (":p a owl:DatatypeProperty ; rdfs:range :euro .", "range", "'toy:euro'"),
    "a word of the standard, misspelt": (
        ":A a owl:Class ; rdfs:subclassOf :Ball .",
        "undeclared",
        "rdfs:subclassOf is no word",
    ),
    "a class in a restriction": (
        ":A a owl:Class ; rdfs:subClassOf [ a owl:Restriction ; owl:onProperty :likes ; owl:someValuesFrom :Bal ] .",
        "undeclared",
        "'toy:Bal'",
    ),
    "a class in a list": ("[] a owl:AllDisjointClasses ; owl:members ( :Ball :Dol ) .", "undeclared", "'toy:Dol'"),
    "a relation in a restriction": (
        ":A a owl:Class ; rdfs:subClassOf [ a owl:Restriction ; owl:onProperty :lieks ; owl:someValuesFrom :Ball ] .",
        "undeclared",
        "'toy:lieks'",
    ),
    "a relation as a superclass": (
        ":A a owl:Class ; rdfs:subClassOf :likes .",
        "wrong-kind",
        "toy:likes is a relation, not a class",
    ),
    "a text as a superclass": (
        ":A a owl:Class ; rdfs:subClassOf 'Ball' .",
        "wrong-kind",
        "needs a class, got the text 'Ball'",
    ),
    "one word of two kinds": (":Ball a owl:ObjectProperty .", "wrong-kind", "declared as class and as relation"),
    "a domain that is no class": (
        ":r a owl:ObjectProperty ; rdfs:domain :likes .",
        "domain",
        "toy:likes is a relation, not a class",
    ),
    "a domain that nobody declares": (
        ":r a owl:ObjectProperty ; rdfs:domain :Bal .",
        "domain",
        "'toy:Bal'. Did you mean",
    ),
    "a range that is a data type": (":r a owl:ObjectProperty ; rdfs:range xsd:string .", "range", "not a class"),
    "a property with a class as range": (":r a owl:DatatypeProperty ; rdfs:range :Ball .", "range", "not a data type"),
    "a range that is a text": (":r a owl:ObjectProperty ; rdfs:range 'Ball' .", "range", "got the text 'Ball'"),
    "a class above itself": (
        ":A a owl:Class ; rdfs:subClassOf :B . :B a owl:Class ; rdfs:subClassOf :A .",
        "cycle",
        "a cycle",
    ),
    "a relation above itself": (
        ":r a owl:ObjectProperty ; rdfs:subPropertyOf :r .",
        "cycle",
        "toy:r is a sub-property of toy:r",
    ),
    "a thing built of itself": (
        "scene:a a :Box ; sk:hasA scene:b . scene:b a :Box ; sk:hasA scene:a .",
        "cycle",
        "a is built of b",
    ),
    "a thing placed in itself": (
        "scene:a a :Box ; sk:in scene:b . scene:b a :Box ; sk:on scene:a .",
        "cycle",
        "is placed at",
    ),
    "a placement without a place": (
        ":r a owl:ObjectProperty ; rdfs:subPropertyOf sk:placement .",
        "placement",
        "needs sk:placeEnd",
    ),
    "a placement with a wrong place": (
        ":r a owl:ObjectProperty ; rdfs:subPropertyOf sk:placement ; sk:placeEnd 'end' .",
        "placement",
        "got end",
    ),
    "a relation of two families": (
        ":r a owl:ObjectProperty ; rdfs:subPropertyOf sk:structure , sk:computed .",
        "placement",
        "sk:structure and sk:computed",
    ),
    "a primary parent that is none": (":Ball sk:primaryParent :Doll .", "parent", "none of its superclasses"),
    "a subject not of the domain": (":x a :Ball ; :likes :y . :y a :Ball .", "domain", "toy:x is toy:Ball"),
    "an object not of the range": (":x a :Doll ; :likes :y . :y a :Box .", "range", "toy:y is toy:Box"),
    "a value that does not fit": (":x a :Ball ; :price 'cheap' .", "range", "needs a finite number"),
    "a thing where a value belongs": (":x a :Ball ; :price :x .", "range", "needs a value, got a thing"),
    "a class-level value of another's property": (":Ball sk:maxGap 0.1 .", "domain", "sk:maxGap has domain sk:Gripper"),
}


@pytest.mark.parametrize(("added", "kind", "says"), FAULTS.values(), ids=FAULTS)
def test_each_structural_fault_is_an_error_with_its_line_and_reason(
    check: Check, head_lines: int, added: str, kind: str, says: str
) -> None:
    report = check(added)

    found = [f for f in report.findings if f.kind == kind and says in f.text]
    assert found, report.findings
    assert found[0].is_error
    assert found[0].file is not None
    assert found[0].file.name == "toys.ttl"
    assert found[0].line == head_lines + 1 or added.startswith(":Ball")


@pytest.mark.parametrize("added", [added for added, _, _ in FAULTS.values()], ids=FAULTS)
def test_each_fault_is_reported_once(check: Check, added: str) -> None:
    findings = check(added).findings

    assert len(findings) == len({(f.kind, f.text) for f in findings})
    assert sum(f.is_error for f in findings) == 1


def test_all_faults_are_reported(check: Check) -> None:
    together = [fault for fault in FAULTS.values() if fault[0].startswith(":A ")]

    findings = check("\n".join(added for added, _, _ in together)).findings

    assert len(together) > 5
    for _, kind, says in together:
        assert any(f.kind == kind and says in f.text for f in findings), says


def test_a_clean_ontology_has_no_findings(check: Check) -> None:
    report = check(":A a owl:Class ; rdfs:subClassOf :Ball . :x a :Doll ; :likes :y ; :price 2.5 . :y a :A .")

    assert report.findings == ()
    assert report.reasoner is None


def test_a_missing_import_is_named_once_with_terms_that_it_may_declare(check: Check) -> None:
    report = check(
        "<http://example.org/toys> owl:imports <http://example.org/more> . :A a owl:Class ; rdfs:subClassOf :B ."
    )

    (finding,) = report.findings
    assert (finding.kind, finding.severity) == (FindingKind.IMPORT, Severity.ERROR)
    assert "<http://example.org/more>: put the files into a folder" in finding.text
    assert finding.text.endswith("undeclared without them (1): toy:B")


def test_a_vocabulary_without_any_declaration_is_a_warning(check: Check) -> None:
    report = check("@prefix dc: <http://purl.org/dc/terms/> . :Ball dc:creator 'me' . :Doll dc:date 'now' .")

    assert [(f.severity, f.kind) for f in report.findings] == [(Severity.WARNING, FindingKind.UNDECLARED)]
    assert "<http://purl.org/dc/terms/>" in report.findings[0].text


def test_terms_without_label_or_comment_are_warnings_in_files_that_build_on_the_core(check: Check) -> None:
    quiet = check(":A a owl:Class .")
    loud = check("<http://example.org/toys> owl:imports <https://w3id.org/skiros-py/core> . :A a owl:Class .")

    assert not quiet.findings
    assert {f.kind for f in loud.findings} == {FindingKind.UNEXPLAINED}
    assert "toy:A has no rdfs:label and no rdfs:comment" in [f.text for f in loud.findings]
    assert not loud.errors


def test_a_domain_outside_that_of_the_super_relation_is_a_warning(check: Check) -> None:
    report = check(":r a owl:ObjectProperty ; rdfs:subPropertyOf :likes ; rdfs:domain :Box .")

    assert [(f.severity, f.kind) for f in report.findings] == [(Severity.WARNING, FindingKind.DOMAIN)]


def test_an_unreadable_file_is_a_finding_and_the_other_files_are_checked(tmp_path: Path) -> None:
    (tmp_path / "a.ttl").write_text("this is no Turtle", encoding="utf-8")
    (tmp_path / "b.ttl").write_text(
        "@prefix : <http://b#> . @prefix rdfs: <http://www.w3.org/2000/01/rdf-schema#> .\n"
        ":B a <http://www.w3.org/2002/07/owl#Class> ; rdfs:subClassOf :C .",
        encoding="utf-8",
    )

    report = check_ontology([tmp_path], "none")

    assert [(f.kind, f.file and f.file.name) for f in report.findings] == [
        (FindingKind.UNREADABLE, "a.ttl"),
        (FindingKind.UNDECLARED, "b.ttl"),
    ]


def test_one_prefix_for_two_namespaces_in_two_files_is_a_finding(tmp_path: Path) -> None:
    for name in "ab":
        (tmp_path / f"{name}.ttl").write_text(
            f"@prefix x: <http://{name}#> . x:C a <http://www.w3.org/2002/07/owl#Class> .", encoding="utf-8"
        )

    report = check_ontology([tmp_path], "none")

    assert "prefix 'x:'" in report.findings[0].text


def test_a_cycle_is_explained_edge_by_edge_and_starts_at_its_first_name(check: Check) -> None:
    report = check(
        ":C a owl:Class ; rdfs:subClassOf :A . :A a owl:Class ; rdfs:subClassOf :B .\n"
        ":B a owl:Class ; rdfs:subClassOf :C ."
    )

    (finding,) = report.findings
    assert "toy:A is a subclass of toy:B is a subclass of toy:C is a subclass of toy:A" in finding.text
    assert [line.split(" (")[0] for line in finding.explanation] == [
        "toy:A is a subclass of toy:B",
        "toy:B is a subclass of toy:C",
        "toy:C is a subclass of toy:A",
    ]
    assert all("toys.ttl:" in line for line in finding.explanation)
