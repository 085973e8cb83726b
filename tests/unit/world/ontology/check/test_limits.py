"""Reasoners are limited in time and memory, and what they cannot judge costs no other finding."""

from __future__ import annotations

import os
import sys
import time
from collections.abc import Callable
from pathlib import Path

import pyoxigraph as ox
import pytest

from skiros_py.errors import MissingExtra
from skiros_py.world.ontology.check.checking import CheckReport
from skiros_py.world.ontology.check.material import FindingKind
from skiros_py.world.ontology.check.owl_reasoner import HermiT, NoAnswer, NotStarted, OwlRlProcess

Check = Callable[..., CheckReport]

_ABOVE = ox.NamedNode("http://www.w3.org/2000/01/rdf-schema#subClassOf")
_APART = ":Ball owl:disjointWith :Doll . :x a :Ball , :Doll ."
_NO_HEAP = "Error occurred during initialization of VM\nCould not reserve enough space for object heap"
_REFUSED = "java.lang.IllegalArgumentException: Non-simple property"


def _ring(size: int) -> list[ox.Triple]:
    classes = [ox.NamedNode(f"http://c#C{number}") for number in range(size)]
    return [ox.Triple(one, _ABOVE, classes[number - 1]) for number, one in enumerate(classes)]


def _children() -> set[str]:
    return {child for task in Path("/proc/self/task").iterdir() for child in (task / "children").read_text().split()}


def _fake_java(folder: Path, errors: str) -> Path:
    program = folder / "java"
    program.write_text(f"#!/bin/sh\necho '{errors}' >&2\nexit 1\n", encoding="utf-8")
    program.chmod(0o755)
    return program


def test_owl_rl_is_killed_at_its_time_limit_and_leaves_no_process() -> None:
    before, start = _children(), time.monotonic()

    with OwlRlProcess(2.0) as reasoner, pytest.raises(NoAnswer, match="OWL-RL reasoner found no answer in the time"):
        reasoner.judge(_ring(3000))

    assert time.monotonic() - start < 8.0
    assert _children() <= before


def test_owl_rl_is_killed_when_it_exceeds_its_memory_limit() -> None:
    before = _children()

    with OwlRlProcess(60.0, memory=64 << 20) as reasoner:
        for _ in range(2):
            with pytest.raises(NoAnswer, match="needs more than 64 MiB of memory"):
                reasoner.judge(_ring(3000))

    assert _children() <= before


def test_one_owl_rl_process_answers_several_requests() -> None:
    with OwlRlProcess(60.0) as reasoner:
        assert reasoner.judge(_ring(3)).consistent
        first = _children()
        assert reasoner.judge(_ring(3), ["http://c#C0"]).consistent
        assert _children() == first


def test_an_aborted_owl_rl_is_a_warning_and_other_findings_are_kept(check: Check) -> None:
    added = ":likes rdfs:range :Nowhere ."

    report = check(added, "owl-rl", time_limit=0.01)

    assert {f.kind for f in check(added).findings} < {f.kind for f in report.findings}
    (silence,) = (f for f in report.findings if f.kind is FindingKind.REASONER)
    assert not silence.is_error
    assert "OWL-RL" in silence.text
    assert report.reasoner is None


def test_a_class_cycle_is_a_finding_and_no_reasoner_runs(check: Check) -> None:
    report = check(":Toy rdfs:subClassOf :Ball . " + _APART, "owl-rl")

    assert [f.kind for f in report.findings] == [FindingKind.CYCLE, FindingKind.REASONER]
    assert report.reasoner is None
    assert "no reasoner was asked" in report.findings[1].text


def test_a_too_deep_hierarchy_is_a_finding_with_its_line_and_no_reasoner_runs(check: Check, head_lines: int) -> None:
    chain = "\n".join(f":C{n} a owl:Class ; rdfs:subClassOf :C{n - 1} ." for n in range(1, 1500))

    report = check(":C0 a owl:Class .\n" + chain, "auto")

    found = [f for f in report.findings if f.kind is FindingKind.DEPTH]
    assert [(f.term, f.line) for f in found] == [("toy:C501", head_lines + 502)]
    assert report.reasoner is None


def test_owl_rl_is_used_if_java_does_not_start(check: Check, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    _fake_java(tmp_path, _NO_HEAP)
    monkeypatch.setenv("PATH", str(tmp_path))

    report = check(_APART, "auto")

    assert (report.reasoner, report.note) == ("OWL-RL", "HermiT does not start")
    assert [f.kind for f in report.findings] == [FindingKind.INCONSISTENT, FindingKind.REASONER]
    assert "HermiT does not start: Error occurred during initialization of VM" in report.findings[1].text


@pytest.mark.parametrize(
    ("errors", "kind", "says"),
    [
        (_NO_HEAP, NotStarted, "does not start: .*object heap"),
        ("", NotStarted, "Java ended with status 1"),
        ("java.lang.OutOfMemoryError: Java heap space", NoAnswer, "needs more memory"),
        (_REFUSED, NoAnswer, "does not take these statements: Non-simple"),
    ],
)
def test_each_reason_why_hermit_gives_no_answer_has_its_own_error(
    tmp_path: Path, errors: str, kind: type[NoAnswer], says: str
) -> None:
    program = _fake_java(tmp_path, errors)

    with pytest.raises(NoAnswer, match=says) as raised:
        HermiT(os.fspath(program), time.monotonic() + 20.0).judge([])

    assert raised.type is kind


@pytest.fixture
def bare_install(monkeypatch: pytest.MonkeyPatch) -> None:
    """Neither owlready2 nor reasonable is installed."""
    for name in ("owlready2", "reasonable"):
        monkeypatch.setitem(sys.modules, name, None)


@pytest.mark.usefixtures("bare_install")
def test_without_reasoner_libraries_the_structure_is_checked_and_the_missing_extra_is_named(check: Check) -> None:
    report = check(_APART, "auto")

    assert (report.reasoner, report.errors) == (None, 0)
    (silence,) = (f for f in report.findings if f.kind is FindingKind.REASONER)
    assert "pip install 'skiros-py[ontology]'" in silence.text


@pytest.mark.usefixtures("bare_install")
@pytest.mark.parametrize("reasoner", ["hermit", "owl-rl"])
def test_requesting_a_reasoner_that_is_not_installed_names_the_missing_extra(check: Check, reasoner: str) -> None:
    with pytest.raises(MissingExtra, match=rf"--reasoner {reasoner} needs the extra 'ontology'"):
        check(_APART, reasoner)
