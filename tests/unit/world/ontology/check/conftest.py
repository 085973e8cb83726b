"""Small ontologies to check, each built on the shipped core."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest

from skiros_py.world.ontology.check.checking import CheckReport, ReasonerChoice, check_ontology

CORE = Path(__file__).parents[5] / "ontologies" / "core.ttl"
HEAD = """@prefix : <http://example.org/toys#> .
@prefix toy: <http://example.org/toys#> .
@prefix scene: <https://w3id.org/skiros-py/scene#> .
@prefix sk: <https://w3id.org/skiros-py/core#> .
@prefix owl: <http://www.w3.org/2002/07/owl#> .
@prefix rdf: <http://www.w3.org/1999/02/22-rdf-syntax-ns#> .
@prefix rdfs: <http://www.w3.org/2000/01/rdf-schema#> .
@prefix xsd: <http://www.w3.org/2001/XMLSchema#> .
<http://example.org/toys> a owl:Ontology .
:Toy a owl:Class ; rdfs:subClassOf sk:Manipulatable . :Ball a owl:Class ; rdfs:subClassOf :Toy .
:Doll a owl:Class ; rdfs:subClassOf :Toy . :Box a owl:Class ; rdfs:subClassOf sk:Container .
:likes a owl:ObjectProperty ; rdfs:domain :Doll ; rdfs:range :Toy .
:price a owl:DatatypeProperty ; rdfs:range xsd:decimal .
"""
LINES = HEAD.count("\n")
"""What a test adds begins in the line after these."""

Check = Callable[..., CheckReport]


@pytest.fixture
def check(tmp_path: Path) -> Check:
    """Checks what is added to the toys, with the core."""

    def run(added: str, reasoner: ReasonerChoice = "none", time_limit: float = 60.0) -> CheckReport:
        file = tmp_path / "toys.ttl"
        file.write_text(HEAD + added, encoding="utf-8")
        return check_ontology([CORE, file], reasoner, time_limit)

    return run


@pytest.fixture
def head_lines() -> int:
    return LINES
