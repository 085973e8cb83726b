"""Contradictions are found and explained; HermiT and the OWL-RL reasoner agree on what both can see."""

from __future__ import annotations

import shutil
import time
from collections.abc import Callable, Iterator
from contextlib import nullcontext
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from support.programs import needs

from skiros_py.errors import UsageError
from skiros_py.world.ontology.check import checking
from skiros_py.world.ontology.check.checking import CheckReport, check_ontology
from skiros_py.world.ontology.check.material import Finding, FindingKind
from skiros_py.world.ontology.check.owl_reasoner import OwlRlProcess

Check = Callable[..., CheckReport]

needs_java = needs(shutil.which("java"), "HermiT is a Java program")
REASONERS = [pytest.param("hermit", marks=needs_java), "owl-rl"]

_APART = ":Ball owl:disjointWith :Doll . "
_BOTH = ":A a owl:Class ; rdfs:subClassOf :Ball , :Doll ."
_SOME = "[ a owl:Restriction ; owl:onProperty :likes ; owl:someValuesFrom {} ]"

IMPOSSIBLE = {
    "two disjoint superclasses": (_APART + ":A a owl:Class ; rdfs:subClassOf :Ball , :Doll .", 3),
    "disjoint through superclasses": (
        _APART + ":B a owl:Class ; rdfs:subClassOf :Ball . :A a owl:Class ; rdfs:subClassOf :B , :Doll .",
        4,
    ),
    "disjoint as one of many": (
        "[] a owl:AllDisjointClasses ; owl:members ( :Box :Ball :Doll ) . " + _BOTH,
        3,
    ),
    "a complement": (":A a owl:Class ; rdfs:subClassOf :Ball , [ a owl:Class ; owl:complementOf :Toy ] .", 3),
    "the empty class": (":A a owl:Class ; rdfs:subClassOf owl:Nothing .", 1),
    "a value of the wrong range": (
        ":Box owl:disjointWith :Toy . :A a owl:Class ; rdfs:subClassOf " + _SOME.format(":Box") + " .",
        3,
    ),
    "a subject of the wrong domain": (
        ":Box owl:disjointWith :Doll . :A a owl:Class ; rdfs:subClassOf :Box , " + _SOME.format(":Toy") + " .",
        4,
    ),
    "some, and none allowed": (
        ":A a owl:Class ; rdfs:subClassOf "
        + _SOME.format(":Toy")
        + " ,\n [ a owl:Restriction ; owl:onProperty :likes ;"
        " owl:maxCardinality '0'^^xsd:nonNegativeInteger ] .",
        2,
    ),
    "some and only": (
        _APART
        + ":A a owl:Class ; rdfs:subClassOf "
        + _SOME.format(":Ball")
        + " ,\n [ a owl:Restriction ; owl:onProperty"
        " :likes ; owl:allValuesFrom :Doll ] .",
        3,
    ),
    "two things that must be one": (
        _APART + ":A a owl:Class ; rdfs:subClassOf " + _SOME.format(":Ball") + " , " + _SOME.format(":Doll") + " ,\n"
        " [ a owl:Restriction ; owl:onProperty :likes ; owl:maxCardinality '1'^^xsd:nonNegativeInteger ] .",
        4,
    ),
}

CONTRADICTIONS = {
    "the same among all different": (
        ":a a :Ball ; owl:sameAs :b . :b a :Ball . [] a owl:AllDifferent ; owl:distinctMembers ( :a :b ) .",
        2,
    ),
    "two disjoint classes": (_APART + ":x a :Ball , :Doll .", 3),
    "a subject of a class apart from the domain": (_APART + ":x a :Ball . :y a :Toy . :x :likes :y .", 4),
    "different and the same": (":x a :Ball ; owl:sameAs :y . :y a :Ball ; owl:differentFrom :x .", 2),
    "two of what there is one of": (
        ":likes a owl:FunctionalProperty . :x a :Doll ; :likes :y , :z . :y a :Ball ; owl:differentFrom :z .",
        4,
    ),
    "both ways": (":likes a owl:AsymmetricProperty . :x a :Doll ; :likes :y . :y a :Doll ; :likes :x .", 3),
    "to itself": (":likes a owl:IrreflexiveProperty . :x a :Doll ; :likes :x .", 2),
    "denied": (
        (
            ":x a :Doll ; :likes :y . :y a :Ball .\n[] a owl:NegativePropertyAssertion ; "
            "owl:sourceIndividual :x ; owl:assertionProperty :likes ; owl:targetIndividual :y ."
        ),
        2,
    ),
    "of a class that nothing can be of": (_APART + ":A a owl:Class ; rdfs:subClassOf :Ball , :Doll . :x a :A .", 4),
    "in a scene of the file": (_APART + "scene:x a :Ball , :Doll .", 3),
}


@pytest.fixture(scope="module", autouse=True)
def _one_process_for_all_checks() -> Iterator[None]:
    """Starting one for each check takes most of the time; that it is ended is claimed by the tests of limits."""
    with OwlRlProcess(time_limit=600.0) as process, pytest.MonkeyPatch.context() as patch:
        patch.setattr(checking, "OwlRlProcess", lambda _time_limit: nullcontext(process))
        yield


def _of(report: CheckReport, kind: FindingKind) -> list[Finding]:
    return [finding for finding in report.findings if finding.kind is kind]


@pytest.mark.parametrize("reasoner", REASONERS)
@pytest.mark.parametrize(("added", "needed"), IMPOSSIBLE.values(), ids=IMPOSSIBLE)
def test_an_unsatisfiable_class_is_found_with_a_minimal_explanation(
    check: Check, added: str, needed: int, reasoner: str
) -> None:
    report = check(added, reasoner)

    assert [f.term for f in _of(report, FindingKind.UNSATISFIABLE)] == ["toy:A"]
    assert not _of(report, FindingKind.INCONSISTENT)
    (why,) = (f.explanation for f in _of(report, FindingKind.UNSATISFIABLE))
    assert len(why) == needed
    assert all("toys.ttl:" in line for line in why)


@pytest.mark.parametrize("reasoner", REASONERS)
@pytest.mark.parametrize(("added", "needed"), CONTRADICTIONS.values(), ids=CONTRADICTIONS)
def test_a_contradiction_among_individuals_is_found_with_a_minimal_explanation(
    check: Check, added: str, needed: int, reasoner: str
) -> None:
    found = _of(check(added, reasoner), FindingKind.INCONSISTENT)

    assert len(found) == 1
    assert len(found[0].explanation) == needed
    assert found[0].file is not None
    assert found[0].file.name == "toys.ttl"


@pytest.mark.parametrize("reasoner", REASONERS)
def test_an_explanation_lists_each_contradicting_statement_with_its_line(
    check: Check, head_lines: int, reasoner: str
) -> None:
    report = check(_APART + "\n:A a owl:Class ; rdfs:subClassOf :Ball ,\n :Doll .", reasoner)

    (finding,) = report.findings
    said = [(line.split(" (")[0], line.rpartition(":")[2]) for line in finding.explanation]
    assert finding.text == "nothing can be a toy:A: these statements exclude it"
    assert said == [
        ("nothing is both toy:Ball and toy:Doll", f"{head_lines + 1})"),
        ("every toy:A is toy:Ball", f"{head_lines + 2})"),
        ("every toy:A is toy:Doll", f"{head_lines + 3})"),
    ]


@pytest.mark.parametrize("reasoner", REASONERS)
def test_a_subclass_of_an_unsatisfiable_class_refers_to_it(check: Check, reasoner: str) -> None:
    report = check(
        _APART + ":A a owl:Class ; rdfs:subClassOf :Ball , :Doll . :B a owl:Class ; rdfs:subClassOf :A .", reasoner
    )

    below = next(f for f in report.findings if f.term == "toy:B")
    assert "because nothing can be a toy:A" in below.text
    assert below.explanation == ()


@pytest.mark.parametrize("reasoner", REASONERS)
def test_independent_contradictions_are_all_found(check: Check, reasoner: str) -> None:
    report = check(
        _APART + ":x a :Ball , :Doll . :y a :Ball , :Doll .\n:A a owl:Class ; rdfs:subClassOf :Ball , :Doll .", reasoner
    )

    assert sorted(f.term for f in _of(report, FindingKind.INCONSISTENT)) == ["toy:x", "toy:y"]
    assert [f.term for f in _of(report, FindingKind.UNSATISFIABLE)] == ["toy:A"]


@pytest.mark.parametrize("reasoner", REASONERS)
def test_class_level_values_and_annotations_cause_no_contradiction(check: Check, reasoner: str) -> None:
    report = check(
        "sk:mass a owl:FunctionalProperty . :Toy sk:mass 1.0 . :Ball sk:mass 2.0 ; rdfs:label 'ball' .", reasoner
    )

    assert report.errors == 0


@needs_java
def test_hermit_finds_and_explains_a_contradiction_that_needs_case_analysis(check: Check) -> None:
    added = (
        _APART + ":A a owl:Class ; rdfs:subClassOf [ a owl:Class ; owl:unionOf ( :Ball :Doll ) ] ,\n"
        " [ a owl:Class ; owl:complementOf :Ball ] , [ a owl:Class ; owl:complementOf :Doll ] ."
    )

    assert check(added, "owl-rl").findings == ()
    (finding,) = check(added, "hermit").findings
    assert len(finding.explanation) == 3
    assert "every toy:A is (toy:Ball or toy:Doll)" in " ".join(finding.explanation)


@needs_java
def test_hermit_checks_data_values(check: Check) -> None:
    report = check(":price a owl:FunctionalProperty . :x a :Ball ; :price 1.0 , 2.0 .", "hermit")

    assert len(_of(report, FindingKind.INCONSISTENT)[0].explanation) == 3


@needs_java
def test_a_reasoner_that_runs_out_of_time_is_an_error_and_leaves_nothing_behind(tmp_path: Path) -> None:
    file = tmp_path / "a.ttl"
    file.write_text("<http://a#A> a <http://www.w3.org/2002/07/owl#Class> .", encoding="utf-8")
    start = time.monotonic()

    report = check_ontology([file], "hermit", time_limit=0.01)

    assert [f.kind for f in report.findings] == [FindingKind.REASONER]
    assert report.errors == 1
    assert report.reasoner is None
    assert time.monotonic() - start < 5.0


@needs_java
def test_owl_rl_judges_an_ontology_that_hermit_rejects_and_the_report_notes_it(check: Check) -> None:
    added = (
        ":likes a owl:TransitiveProperty . :A a owl:Class ; rdfs:subClassOf [ a owl:Restriction ;"
        " owl:onProperty :likes ; owl:maxCardinality '1'^^xsd:nonNegativeInteger ] .\n"
        + _APART
        + ":x a :Ball , :Doll ."
    )

    report = check(added, "auto")

    assert report.reasoner == "OWL-RL"
    assert report.note == "HermiT gave no answer"
    assert [f.kind for f in report.findings] == [FindingKind.INCONSISTENT, FindingKind.REASONER]
    assert "non-simple" in report.findings[1].text.lower()


def test_without_java_owl_rl_runs_and_the_report_notes_it(check: Check, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("PATH", "")

    report = check(_APART + ":x a :Ball , :Doll .", "auto")

    assert report.reasoner == "OWL-RL"
    assert report.note.startswith("no Java")
    assert report.errors == 1


def test_requesting_hermit_without_java_is_a_usage_error(check: Check, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("PATH", "")

    with pytest.raises(UsageError, match="needs Java"):
        check("", "hermit")


@needs_java
def test_with_java_hermit_runs_and_the_report_notes_it(check: Check) -> None:
    report = check("", "auto")

    assert (report.reasoner, report.note) == ("HermiT", "Java is there")


@pytest.mark.parametrize("reasoner", REASONERS)
def test_the_shipped_ontologies_are_clean(root: Path, reasoner: str) -> None:
    folders = [root / "ontologies", root / "robots/src/skiros_robots"]

    report = check_ontology(folders, reasoner)  # type: ignore[arg-type]

    assert report.findings == ()
    assert set(report.files) == {file for folder in folders for file in folder.glob("*.ttl")}


@pytest.mark.parametrize("reasoner", REASONERS)
def test_the_same_files_give_the_same_findings(check: Check, reasoner: str) -> None:
    added = " ".join(added for added, _ in IMPOSSIBLE.values()) + CONTRADICTIONS["two disjoint classes"][0]

    assert check(added, reasoner).findings == check(added, reasoner).findings


_NAMES = [f":C{number}" for number in range(6)]


@settings(max_examples=60, deadline=None)
@given(
    above=st.lists(
        st.tuples(st.sampled_from(_NAMES), st.sampled_from(_NAMES)).filter(lambda p: p[0] > p[1]), max_size=8
    ),
    apart=st.lists(st.tuples(st.sampled_from(_NAMES), st.sampled_from(_NAMES)), max_size=3),
)
def test_exactly_the_unsatisfiable_classes_of_random_hierarchies_are_found(
    tmp_path_factory: pytest.TempPathFactory, above: list[tuple[str, str]], apart: list[tuple[str, str]]
) -> None:
    lines = [f"{name} a owl:Class ." for name in _NAMES]
    lines += [f"{below} rdfs:subClassOf {upper} ." for below, upper in above]
    lines += [f"{one} owl:disjointWith {other} ." for one, other in apart]
    prefixes = "@prefix : <http://c#> . @prefix owl: <http://www.w3.org/2002/07/owl#> .\n"
    prefixes += "@prefix rdfs: <http://www.w3.org/2000/01/rdf-schema#> .\n"
    file = tmp_path_factory.mktemp("classes") / "c.ttl"
    file.write_text(prefixes + "\n".join(lines), encoding="utf-8")

    report = check_ontology([file], "owl-rl")

    line: dict[str, set[str]] = {}
    for name in _NAMES:
        line[name] = {name}.union(*(line[upper] for below, upper in above if below == name))
    impossible = [name for name in _NAMES if any({one, other} <= line[name] for one, other in apart)]
    assert sorted(f.term for f in _of(report, FindingKind.UNSATISFIABLE)) == [f"c{name}" for name in impossible]
    for finding in report.findings:
        assert finding.explanation or "because" in finding.text
