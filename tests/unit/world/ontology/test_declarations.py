from __future__ import annotations

import pickle
import re
from collections.abc import Callable
from pathlib import Path

import pytest

from skiros_py.errors import FileError, UnknownName
from skiros_py.world.ontology import Ontology
from skiros_py.world.ontology.statements import Statements
from skiros_py.world.terms import Cardinality

ROOT = Path(__file__).parents[4]
HEAD = """@prefix mine: <http://example.org/mine#> .
@prefix owl: <http://www.w3.org/2002/07/owl#> .
@prefix rdf: <http://www.w3.org/1999/02/22-rdf-syntax-ns#> .
@prefix rdfs: <http://www.w3.org/2000/01/rdf-schema#> .
@prefix xsd: <http://www.w3.org/2001/XMLSchema#> .
@prefix sk: <https://w3id.org/skiros-py/core#> .
mine:A a owl:Class . mine:B a owl:Class . mine:C a owl:Class . mine:r a owl:ObjectProperty .
"""
UNION = "[ owl:unionOf ( mine:B mine:C ) ]"
CYCLE = "mine:A rdfs:subClassOf mine:B . mine:B rdfs:subClassOf mine:C . mine:C rdfs:subClassOf mine:A ."
LINE = HEAD.count("\n") + 1

Load = Callable[..., Ontology]


@pytest.fixture
def load(tmp_path: Path) -> Load:
    def make(text: str, **others: str) -> Ontology:
        files = {"mine": HEAD + text, **others}
        for name, content in files.items():
            (tmp_path / f"{name}.ttl").write_text(content, encoding="utf-8")
        return Ontology.load([ROOT / "ontologies" / "core.ttl", *(tmp_path / f"{name}.ttl" for name in files)])

    return make


# ------------------------------------------------------------ ends


@pytest.mark.parametrize(
    ("text", "domains", "domain"),
    [
        ("", (), None),
        ("mine:r rdfs:domain owl:Thing .", (), None),
        ("mine:r rdfs:domain mine:A .", (("mine:A",),), "mine:A"),
        ("mine:r rdfs:domain mine:B, mine:A .", (("mine:A",), ("mine:B",)), None),
        ("mine:r rdfs:domain [ owl:unionOf ( mine:B mine:A ) ] .", (("mine:A", "mine:B"),), None),
        ("mine:r rdfs:domain [ owl:unionOf ( mine:A ) ] .", (("mine:A",),), "mine:A"),
        ("mine:r rdfs:domain [ owl:unionOf ( mine:A [ owl:unionOf ( mine:B ) ] ) ] .", (("mine:A", "mine:B"),), None),
        (f"mine:r rdfs:domain [ owl:intersectionOf ( mine:A {UNION} ) ] .", (("mine:A",), ("mine:B", "mine:C")), None),
        ("mine:r rdfs:domain [ owl:unionOf ( mine:A [ owl:complementOf mine:B ] ) ] .", (), None),
        ("mine:r rdfs:domain [ owl:unionOf ( mine:A owl:Thing ) ] .", (), None),
        ("mine:r rdfs:domain [ owl:complementOf mine:B ] .", (), None),
    ],
)  # fmt: skip
def test_domains_that_are_unions_or_intersections_of_named_classes_are_kept(
    load: Load, text: str, domains: tuple[tuple[str, ...], ...], domain: str | None
) -> None:
    relation = load(text).relation("mine:r")

    assert (relation.domains, relation.domain) == (domains, domain)


@pytest.mark.parametrize(
    ("range_", "kept"),
    [
        ("", "rdfs:Literal"),
        ("rdfs:range xsd:unsignedInt ;", "xsd:unsignedInt"),
        ("rdfs:range rdfs:Literal ;", "rdfs:Literal"),
        ("rdfs:range rdf:PlainLiteral ;", "rdf:PlainLiteral"),
        ("rdfs:range mine:percent ;", "rdfs:Literal"),
        ("rdfs:range [ a rdfs:Datatype ; owl:oneOf ( 1 2 ) ] ;", "rdfs:Literal"),
        ("rdfs:range xsd:int, xsd:decimal ;", "rdfs:Literal"),
    ],
)
def test_a_range_becomes_a_type_that_values_are_checked_against(load: Load, range_: str, kept: str) -> None:
    ontology = load(f"mine:percent a rdfs:Datatype . mine:p a owl:DatatypeProperty ; {range_} rdfs:domain mine:A .")

    assert ontology.properties["mine:p"].range == kept
    assert ontology.properties["mine:p"].domain == "mine:A"


# ------------------------------------------------------------ classes


def test_equivalent_classes_are_subclasses_of_each_other_and_share_values(load: Load) -> None:
    ontology = load(
        "mine:A owl:equivalentClass mine:B . mine:B rdfs:subClassOf mine:C ; mine:p 3 ."
        " mine:p a owl:DatatypeProperty ; rdfs:range xsd:integer ."
    )

    assert ontology.is_a("mine:A", "mine:B")
    assert ontology.is_a("mine:B", "mine:A")
    assert ontology.is_a("mine:A", "mine:C")
    assert not ontology.is_a("mine:C", "mine:A")
    assert ontology.class_value("mine:A", "mine:p") == 3
    assert ontology.classes["mine:A"].parents == ()  # the tree of first parents stays a tree


def test_a_class_value_overrides_the_value_of_its_superclass(load: Load) -> None:
    ontology = load(
        "mine:p a owl:DatatypeProperty ; rdfs:range xsd:integer . mine:C mine:p 1 . mine:B rdfs:subClassOf mine:C ;"
        " mine:p 2 . mine:A rdfs:subClassOf mine:B . mine:D a owl:Class ; rdfs:subClassOf mine:A ; mine:p 4 ."
    )

    assert [ontology.class_value(f"mine:{name}", "mine:p") for name in "CBAD"] == [1, 2, 2, 4]
    with pytest.raises(UnknownName):
        ontology.class_value("mine:X", "mine:p")


@pytest.mark.parametrize(
    ("restriction", "expected"),
    [
        ("owl:maxCardinality 2", Cardinality("mine:r", 0, 2, None)),
        ("owl:minCardinality 1", Cardinality("mine:r", 1, None, None)),
        ("owl:cardinality 3", Cardinality("mine:r", 3, 3, None)),
        ("owl:maxQualifiedCardinality 2 ; owl:onClass mine:B", Cardinality("mine:r", 0, 2, "mine:B")),
        ("owl:maxQualifiedCardinality 2 ; owl:onClass owl:Thing", Cardinality("mine:r", 0, 2, None)),
        ("owl:maxQualifiedCardinality 2 ; owl:onClass [ owl:complementOf mine:B ]", None),
        ("owl:someValuesFrom mine:B", None),
        ("owl:hasValue mine:x", None),
    ],
)
@pytest.mark.parametrize(
    "frame", ["rdfs:subClassOf [ {} ]", "owl:equivalentClass [ owl:intersectionOf ( mine:B [ {} ] ) ]"]
)
def test_cardinality_restrictions_are_read_and_other_restrictions_are_ignored(
    load: Load, frame: str, restriction: str, expected: Cardinality | None
) -> None:
    inner = f"a owl:Restriction ; owl:onProperty mine:r ; {restriction}"
    ontology = load(f"mine:A {frame.format(inner)} . mine:D a owl:Class ; rdfs:subClassOf mine:A .")

    assert ontology.cardinalities("mine:D") == (() if expected is None else (expected,))


def test_rdfs_classes_and_untyped_object_properties_are_accepted(load: Load) -> None:
    ontology = load("mine:D a rdfs:Class . mine:s a owl:TransitiveProperty . mine:s owl:inverseOf mine:r .")

    assert "mine:D" in ontology.classes
    assert ontology.relation("mine:s").transitive
    assert ontology.relation("mine:r").inverse == "mine:s"


# ------------------------------------------------------------ languages

TEXTS = """
mine:A rdfs:label "thing" , "Ding"@de , "chose"@fr ; rdfs:comment "A thing."@en , "Ein Ding."@de .
mine:B rdfs:label "Knopf"@de , "button"@en-GB .
mine:C rdfs:label "Zug"@de , "Zugfahrt"@de-CH .
mine:r rdfs:label "near" , "nahe"@DE . mine:p a owl:DatatypeProperty ; rdfs:comment "Masse"@de .
"""


def test_terms_keep_labels_and_comments_in_all_their_languages(load: Load) -> None:
    ontology = load(TEXTS)

    thing = ontology.classes["mine:A"]
    assert (thing.label, thing.labels) == ("thing", {"de": "Ding", "fr": "chose"})
    assert (thing.comment, thing.comments) == ("A thing.", {"de": "Ein Ding."})
    assert ontology.relation("mine:r").labels == {"de": "nahe"}
    assert ontology.properties["mine:p"].comments == {"de": "Masse"}
    assert ontology.languages == ("en", "de", "de-ch", "en-gb", "fr")
    assert pickle.loads(pickle.dumps(ontology)).classes == ontology.classes


@pytest.mark.parametrize(
    ("term", "language", "label"),
    [
        ("mine:A", "en", "thing"),
        ("mine:A", "de", "Ding"),
        ("mine:A", "DE-at", "Ding"),
        ("mine:A", "it", "thing"),
        ("mine:B", "it", "button"),
        ("mine:B", "en-US", "button"),
        ("mine:C", "de-CH", "Zugfahrt"),
        ("mine:C", "de", "Zug"),
        ("mine:C", "fr", "Zug"),
        ("sk:Robot", "fr", "robot"),
    ],
)
def test_a_term_is_said_in_a_language_else_in_english_else_in_any(
    load: Load, term: str, language: str, label: str
) -> None:
    assert load(TEXTS).classes[term].in_language(language).label == label


def test_of_label_and_comment_each_is_said_in_the_language_that_it_has(load: Load) -> None:
    said = load(TEXTS).classes["mine:A"].in_language("fr")

    assert (said.label, said.comment) == ("chose", "A thing.")


@pytest.mark.parametrize("tag", ["de_DE", "deutschland", ""])
def test_a_damaged_language_tag_is_refused_with_its_line(load: Load, tag: str) -> None:
    with pytest.raises(FileError) as caught:
        load(f'mine:A rdfs:label "Ding"@{tag} .')

    assert caught.value.line == LINE


def test_a_fault_in_a_declaration_names_its_file_not_one_that_translates_the_term(tmp_path: Path) -> None:
    prefixes = HEAD.partition("mine:A")[0]
    (tmp_path / "a.ttl").write_text(f'{prefixes}mine:r rdfs:label "an"@de .')
    (tmp_path / "b.ttl").write_text(f"{prefixes}mine:r a owl:ObjectProperty ; rdfs:subPropertyOf sk:placement .")

    with pytest.raises(FileError, match="mine:r is a placement and needs sk:placeEnd") as caught:
        Ontology.load([ROOT / "ontologies" / "core.ttl", tmp_path])

    assert caught.value.path.name == "b.ttl"


def test_every_term_of_the_shipped_ontologies_has_a_german_label_and_comment(ontology: Ontology) -> None:
    terms = (*ontology.classes.values(), *ontology.relations.values(), *ontology.properties.values())

    assert [term.curie for term in terms if not (term.labels.get("de") and term.comments.get("de"))] == []


@pytest.mark.parametrize("detail", [r"\[[^]]*\]", r"\w+:\w+", r"\d[.,]\d+", r"\w+_\d"])
def test_german_comments_name_the_same_units_terms_numbers_and_examples(ontology: Ontology, detail: str) -> None:
    terms = (*ontology.classes.values(), *ontology.relations.values(), *ontology.properties.values())
    found = {
        term.curie: [sorted(re.findall(detail, text.replace(",", "."))) for text in (term.comment, term.comments["de"])]
        for term in terms
    }

    assert {term: both for term, both in found.items() if both[0] != both[1]} == {}


def test_a_file_of_translations_is_about_declared_terms_only(ontology: Ontology) -> None:
    (german,) = (one for one in ontology.sources if one.path.name == "german.ttl")
    subjects = {ontology.names.name(triple.subject.value) for triple in german.triples}
    declared = {term for terms in Statements(ontology.sources, ontology.names).declared.values() for term in terms}

    assert subjects - declared == {german.iri}


# ------------------------------------------------------------ what is refused


@pytest.mark.parametrize(
    ("text", "line", "says"),
    [
        ("mine:A\n  rdfs:subClassOf mine:Bb .", 1, "mine:A refers to unknown class 'mine:Bb'. Did you mean 'mine:B'"),
        ("mine:r\n  rdfs:range mine:Bb .", 1, "unknown class 'mine:Bb'"),
        ("mine:r rdfs:range [ owl:unionOf ( mine:A\n mine:Bb ) ] .", 1, "unknown class 'mine:Bb'"),
        ("mine:r\n rdfs:subPropertyOf mine:rr .", 1, "unknown relation 'mine:rr'"),
        (CYCLE, None, "above itself by rdfs:subClassOf: mine:"),
        ("mine:A mine:wieght 3 .", 0, "unknown property 'mine:wieght'"),
        ("mine:x a mine:D .", 0, "mine:x is of an unknown class 'mine:D'"),
        ("mine:p a owl:DatatypeProperty ; rdfs:range xsd:sting .", 0, "Did you mean 'xsd:string'"),
        ("mine:p a owl:DatatypeProperty . mine:A mine:p 3, 4 .", 0, "needs one value of mine:p, got 2"),
        ("mine:A rdfs:subClassOf [ owl:onProperty mine:r ; owl:maxCardinality 'two' ] .", 0, "a whole number from 0"),
        ("<http://example.org/mine#> a owl:Class .", 0, "needs a name after the last '#' or '/'"),
    ],
)  # fmt: skip
def test_an_ambiguous_declaration_is_refused_with_its_line(load: Load, text: str, line: int | None, says: str) -> None:
    with pytest.raises(FileError) as caught:
        load(text)

    assert says in caught.value.reason
    assert line is None or caught.value.line == LINE + line


def test_an_undeclared_term_is_reported_with_the_missing_import_that_may_declare_it(load: Load) -> None:
    text = "<http://example.org/m> a owl:Ontology ; owl:imports <http://example.org/gone> ."

    with pytest.raises(
        FileError, match=r"an ontology that is imported and missing: <http://example\.org/gone>: put the files into"
    ):
        load(text + "mine:A rdfs:subClassOf mine:Gone .")


def test_a_fault_names_the_file_with_the_faulty_statement(load: Load) -> None:
    with pytest.raises(FileError) as caught:
        load("", bridge=HEAD.replace("mine:A a owl:Class .", "\nmine:A rdfs:subClassOf sk:Nothing ."))

    assert (caught.value.path.name, caught.value.line) == ("bridge.ttl", LINE)


def test_terms_of_undeclared_vocabularies_are_ignored(load: Load) -> None:
    ontology = load(
        "mine:A <http://purl.org/dc/terms/creator> 'me' . mine:x a <http://www.w3.org/2004/02/skos/core#Concept> ."
    )

    assert "mine:A" in ontology.classes
    assert ontology.individuals == ()


# ------------------------------------------------------------ prefixes


def test_a_namespace_without_a_prefix_gets_one_from_its_last_path_segment(load: Load) -> None:
    ontology = load(
        "<http://example.org/2024/Machine-Tools.owl#Lathe> a owl:Class . <urn:acme:shop:Till> a owl:Class ."
        "<http://example.org/mine/Shaft> a owl:Class . <http://www.w3.org/ns/plan/v2/Step> a owl:Class ."
    )

    assert {"machine_tools:Lathe", "shop:Till", "mine2:Shaft", "plan:Step"} <= set(ontology.classes)
    assert ontology.names.iri("machine_tools:Lathe") == "http://example.org/2024/Machine-Tools.owl#Lathe"


def test_generated_prefixes_depend_only_on_the_content_of_the_files(load: Load) -> None:
    one = "<http://b.org/x#A> a <http://www.w3.org/2002/07/owl#Class> ."
    other = "<http://a.org/x#A> a <http://www.w3.org/2002/07/owl#Class> ."

    forth, back = load("", one=one, other=other), load("", other=other, one=one)

    assert forth.names.iri("x:A") == back.names.iri("x:A") == "http://a.org/x#A"
    assert forth.names.iri("x2:A") == "http://b.org/x#A"
