"""Ontologies that distributions bring by entry points, good and bad."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path

import pytest

from skiros_py.catalogue import load_catalogue
from skiros_py.config import ontology_paths
from skiros_py.station.worlds import open_world
from skiros_py.world.ontology import load_installed

Install = Callable[..., None]

GARDEN = """
@prefix garden: <http://example.org/garden#> .
@prefix owl: <http://www.w3.org/2002/07/owl#> .
@prefix rdfs: <http://www.w3.org/2000/01/rdf-schema#> .
@prefix sk: <https://w3id.org/skiros-py/core#> .
<http://example.org/garden> a owl:Ontology .
garden:Spade a owl:Class ; rdfs:subClassOf sk:Manipulatable .
"""
ON_GARDEN = """
@prefix shed: <http://example.org/shed#> .
@prefix garden: <http://example.org/garden#> .
@prefix owl: <http://www.w3.org/2002/07/owl#> .
@prefix rdfs: <http://www.w3.org/2000/01/rdf-schema#> .
shed:Rusty a owl:Class ; rdfs:subClassOf garden:Spade .
"""


@pytest.fixture
def install(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Install:
    """Installs a distribution with one entry point and the files of its package."""
    monkeypatch.syspath_prepend(str(tmp_path))

    def make(name: str, files: Mapping[str, str], value: str | None = None) -> None:
        info = tmp_path / f"{name}-0.3.dist-info"
        info.mkdir()
        (info / "METADATA").write_text(f"Metadata-Version: 2.1\nName: {name}\nVersion: 0.3\n", encoding="utf-8")
        (info / "entry_points.txt").write_text(f"[skiros.ontologies]\n{name} = {value or name}\n", encoding="utf-8")
        for file, text in files.items():
            path = tmp_path / file
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_text(text, encoding="utf-8")

    return make


def reasons(*names: str) -> dict[str, str]:
    faults = load_installed(ontology_paths())[1]
    return {fault.name: fault.reason for fault in faults if fault.name in names}


@pytest.mark.parametrize(
    ("files", "value"),
    [
        ({"sk_a/__init__.py": "", "sk_a/deep/garden.ttl": GARDEN}, "sk_a"),
        ({"sk_b/__init__.py": "", "sk_b/ontologies/garden.ttl": GARDEN, "sk_b/broken.ttl": "no"}, "sk_b"),
        ({"sk_c/__init__.py": "", "sk_c/data.py": "", "sk_c/garden.ttl": GARDEN}, "sk_c.data"),
        ({"sk_d/garden.ttl": GARDEN}, "sk_d"),
        ({"sk_e.py": "import pathlib\nHERE = pathlib.Path(__file__).parent / 'x'", "x/g.ttl": GARDEN}, "sk_e:HERE"),
    ],
    ids=["package", "its folder ontologies", "module in it", "folder without code", "path"],
)
def test_the_files_of_an_entry_point_are_part_of_the_ontology(
    install: Install, files: Mapping[str, str], value: str
) -> None:
    install(value[:4], files, value)

    ontology, faults = load_installed(ontology_paths())

    assert faults == ()
    assert ontology.is_a("garden:Spade", "sk:Manipulatable")
    assert "garden:Spade" in open_world("kitting").ontology.classes


@pytest.mark.parametrize(
    ("name", "files", "value", "says"),
    [
        ("sk_f", {"sk_f/__init__.py": "", "sk_f/a.ttl": "not turtle"}, None, "a.ttl:1: not Turtle"),
        ("sk_g", {"sk_g/__init__.py": ""}, None, "there is no ontology file below"),
        ("sk_h", {"sk_h.py": ""}, None, "name a package"),
        ("sk_i", {"sk_i.py": "X = 5"}, "sk_i:X", "it is a int, nothing for ontologies"),
        ("sk_j", {"sk_j.py": "1 / 0"}, "sk_j:HERE", "ZeroDivisionError"),
        ("sk_k", {"sk_k/a.ttl": ON_GARDEN.replace("garden:S", "garden:T")}, None, "unknown class 'garden:Tpade'"),
        ("sk_l", {"sk_l/a.ttl": "@prefix sk: <http://example.org/sk#> ."}, None, "prefix 'sk:' stands for"),
        ("sk_m", {"sk_m/a.ttl": GARDEN.replace("example.org/garden>", "example.org/other>")}, None, ""),
        ("sk_n", {"sk_n/a.ttl": GARDEN}, None, "declares ontology <http://example.org/garden>, as"),
    ],
)
def test_a_plugin_whose_ontology_is_wrong_is_reported_and_the_rest_is_used(
    install: Install, name: str, files: Mapping[str, str], value: str | None, says: str
) -> None:
    install("sk_garden", {"sk_garden/__init__.py": "", "sk_garden/garden.ttl": GARDEN})
    install(name, files, value)

    ontology, _ = load_installed(ontology_paths())

    assert "garden:Spade" in ontology.classes
    assert says in reasons(name, "sk_garden").get(name, "")
    assert "sk_garden" not in reasons("sk_garden")
    assert (name in {fault.name for fault in load_catalogue().faults}) == bool(says)


def test_plugins_that_need_each_other_are_read_in_any_order(install: Install) -> None:
    install("sk_p", {"sk_p/a.ttl": ON_GARDEN})
    install("sk_q", {"sk_q/a.ttl": GARDEN})

    assert load_installed(ontology_paths())[0].is_a("shed:Rusty", "sk:Manipulatable")


def test_a_plugin_that_needs_a_broken_one_is_reported_too(install: Install) -> None:
    install("sk_r", {"sk_r/a.ttl": ON_GARDEN})
    install("sk_s", {"sk_s/a.ttl": GARDEN + "garden:"})

    found = reasons("sk_r", "sk_s")

    assert "not Turtle" in found["sk_s"]
    assert "unknown class 'garden:Spade'" in found["sk_r"]


def test_a_faulty_file_of_the_installation_is_not_reported_as_a_plug_in_fault(
    install: Install, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    install("sk_t", {"sk_t/a.ttl": GARDEN})
    (tmp_path / "mine.ttl").write_text("no turtle", encoding="utf-8")
    monkeypatch.setenv("SKIROS_ONTOLOGIES", str(tmp_path / "mine.ttl"))

    with pytest.raises(Exception, match=r"mine\.ttl:1: not Turtle"):
        load_installed(ontology_paths())


OWN = GARDEN + "garden:Rake a owl:Class . garden:under a owl:ObjectProperty . garden:note a owl:AnnotationProperty .\n"


@pytest.mark.parametrize(
    ("axiom", "says"),
    [
        ("sk:in rdfs:range sk:Robot .", "'rdfs:range sk:Robot' about sk:in, which belongs to core.ttl"),
        ("sk:in rdfs:domain garden:Spade .", "'rdfs:domain garden:Spade' about sk:in"),
        ("sk:Robot rdfs:subClassOf garden:Spade .", "'rdfs:subClassOf garden:Spade' about sk:Robot"),
        ("sk:Robot rdfs:subClassOf [ owl:unionOf (garden:Rake) ] .", "'rdfs:subClassOf …' about sk:Robot"),
        ("sk:in a owl:TransitiveProperty .", "'rdf:type owl:TransitiveProperty' about sk:in"),
        ("sk:Robot a owl:ObjectProperty .", "'rdf:type owl:ObjectProperty' about sk:Robot"),
        ("sk:in rdfs:subPropertyOf garden:under .", "'rdfs:subPropertyOf garden:under' about sk:in"),
        ('sk:in sk:placeEnd "subject" .', "'sk:placeEnd subject' about sk:in"),
        ('sk:Robot rdfs:label "Automaton" .', "'rdfs:label Automaton' about sk:Robot"),
        ("sk:Robot owl:deprecated true .", "'owl:deprecated true' about sk:Robot"),
        ("garden:Rake owl:equivalentClass sk:Robot .", "'owl:equivalentClass sk:Robot' about sk:Robot"),
        ("garden:Rake owl:disjointWith sk:Robot .", "'owl:disjointWith sk:Robot' about sk:Robot"),
        ("[] a owl:AllDisjointClasses ; owl:members (garden:Rake sk:Robot sk:Gripper) .", "about sk:Robot"),
    ],
)
def test_a_plug_in_that_states_something_about_a_term_of_others_is_left_out_with_the_axiom_named(
    install: Install, axiom: str, says: str
) -> None:
    install("sk_axiom", {"sk_axiom/bad.ttl": OWN.replace("example.org/garden>", "example.org/bad>") + axiom})

    world = open_world("kitting", report=lambda _: None)

    reason = reasons("sk_axiom")["sk_axiom"]
    assert says in reason
    assert f"bad.ttl:{len(OWN.splitlines()) + 1}: " in reason
    assert "garden:Spade" not in world.ontology.classes


@pytest.mark.parametrize(
    "addition",
    [
        "garden:Rake rdfs:subClassOf sk:Robot . garden:under rdfs:subPropertyOf sk:computed ; rdfs:range sk:Location .",
        "sk:Robot a owl:Class .",
        'sk:Robot rdfs:label "Roboter"@de ; rdfs:seeAlso <http://example.org> ; garden:note "fast" .',
        "[] a owl:AllDisjointClasses ; owl:members (garden:Rake garden:Spade) .",
    ],
)
def test_a_plug_in_may_build_on_terms_of_others_repeat_their_declarations_and_translate_them(
    install: Install, addition: str
) -> None:
    install("sk_adds", {"sk_adds/adds.ttl": OWN + addition})

    assert "sk_adds" not in reasons("sk_adds")


def test_a_plug_in_may_not_change_the_terms_of_another_plug_in_whatever_their_order(install: Install) -> None:
    install("sk_aaa", {"sk_aaa/a.ttl": ON_GARDEN + "garden:Spade a owl:Class ; rdfs:subClassOf shed:Rusty ."})
    install("sk_garden", {"sk_garden/garden.ttl": GARDEN})

    found = reasons("sk_aaa", "sk_garden")

    assert "about garden:Spade, which belongs to garden.ttl" in found["sk_aaa"]
    assert "sk_garden" not in found
