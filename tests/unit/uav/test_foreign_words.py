"""Another ontology of robots that fly, with the same prefix, loads beside ours as it is."""

from __future__ import annotations

from pathlib import Path

import pytest

import skiros_uav
from skiros_py.station.session import Options, Session

SCENE = Path(skiros_uav.__file__).parent / "scenes" / "delivery_uav.ttl"
BASIS, WORDS = "http://example.org/2014/9/basis", "http://example.org/2016/9/uav"

HEAD = f"""<?xml version="1.0"?>
<rdf:RDF xmlns="{{iri}}#" xml:base="{{iri}}"
     xmlns:rdf="http://www.w3.org/1999/02/22-rdf-syntax-ns#"
     xmlns:owl="http://www.w3.org/2002/07/owl#"
     xmlns:rdfs="http://www.w3.org/2000/01/rdf-schema#"
     xmlns:basis="{BASIS}#"
     xmlns:uav="{WORDS}#">
"""
BASIS_FILE = f"""{HEAD.format(iri=BASIS)}
    <owl:Ontology rdf:about="{BASIS}"/>
    <owl:ObjectProperty rdf:about="{BASIS}#hasA"/>
    <owl:DatatypeProperty rdf:about="{BASIS}#SkillMgr"/>
    <owl:Class rdf:about="{BASIS}#Robot"/>
    <owl:Class rdf:about="{BASIS}#PropertyCondition"/>
    <owl:NamedIndividual rdf:about="{BASIS}#arm"><rdf:type rdf:resource="{BASIS}#Robot"/></owl:NamedIndividual>
</rdf:RDF>
"""
WORDS_FILE = f"""{HEAD.format(iri=WORDS)}
    <owl:Ontology rdf:about="{WORDS}"><owl:imports rdf:resource="{BASIS}"/></owl:Ontology>
    <owl:Class rdf:about="{WORDS}#Fly"><rdfs:subClassOf rdf:resource="{BASIS}#PropertyCondition"/></owl:Class>
    <owl:Class rdf:about="{WORDS}#Landed"><rdfs:subClassOf rdf:resource="{BASIS}#PropertyCondition"/></owl:Class>
    <owl:Class rdf:about="{WORDS}#LowBattery"><rdfs:subClassOf rdf:resource="{BASIS}#PropertyCondition"/></owl:Class>
    <owl:NamedIndividual rdf:about="{WORDS}#some_uav">
        <rdf:type rdf:resource="{BASIS}#Robot"/>
        <basis:hasA rdf:resource="{BASIS}#arm"/>
        <basis:SkillMgr>/some_uav</basis:SkillMgr>
    </owl:NamedIndividual>
</rdf:RDF>
"""


def test_words_of_others_load_beside_ours(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "basis.owl").write_text(BASIS_FILE)
    (tmp_path / "uav.owl").write_text(WORDS_FILE)
    scene = tmp_path / "scene.ttl"
    ours = "<https://w3id.org/skiros-py/robots/hexacopter>"
    scene.write_text(SCENE.read_text().replace(f"{ours} .", f"{ours} , <{WORDS}> ."))
    monkeypatch.setenv("SKIROS_ONTOLOGIES", str(tmp_path))

    with Session(str(scene), Options(fake=True)) as session:
        ontology = session.world.ontology
        report = session.run()

    assert {"uav2:Fly", "uav2:Landed", "uav2:LowBattery"} <= set(ontology.subclasses("basis:PropertyCondition"))
    assert "uav2:some_uav" in ontology.individuals
    assert ontology.is_a("uav:AerialBase", "sk:Base")
    assert report.reached
