from __future__ import annotations

import json
import pickle
import socket
import sys
from pathlib import Path

import pytest

from skiros_py.errors import FileError
from skiros_py.world.literals import LONGEST_TEXT
from skiros_py.world.ontology.documents import rdf_files, read_document
from skiros_py.world.ontology.formats import DEEPEST, LONGEST_ENTITY

DATA = Path(__file__).parents[3] / "data" / "ontologies"
HEAD = """<?xml version="1.0"?>
<!DOCTYPE rdf:RDF [
    <!ENTITY owl "http://www.w3.org/2002/07/owl#" >
    {entities}
]>
<rdf:RDF xmlns="http://example.org/a#" xml:base="http://example.org/a" xmlns:owl="http://www.w3.org/2002/07/owl#"
     xmlns:rdf="http://www.w3.org/1999/02/22-rdf-syntax-ns#">
"""
END = "</rdf:RDF>"
NO_PREFIX = """<Ontology xmlns="http://www.w3.org/2002/07/owl#" ontologyIRI="http://example.org/a">
<Declaration><Class abbreviatedIRI="b:C"/></Declaration></Ontology>"""
A = '<owl:Class rdf:about="#A"/>'
PREFIX = "@prefix e: <http://example.org/e#> .\n"


def xml(body: str = A, entities: str = "") -> str:
    return HEAD.format(entities=entities) + body + END


def written(folder: Path, name: str, content: str | bytes) -> Path:
    path = folder / name
    path.write_bytes(content if isinstance(content, bytes) else content.encode())
    return path


@pytest.mark.parametrize(
    ("name", "content", "triples"),
    [
        ("a.ttl", PREFIX + "e:a a e:B .", 1),
        ("a.ttl", "\ufeff" + PREFIX + "e:a a e:B .", 1),
        ("turtle.owl", PREFIX + "e:a a e:B .", 1),
        ("iri_first.owl", "<http://example.org/a> a <http://example.org/B> .", 1),
        ("a.owl", xml(), 1),
        ("a.rdf", "\ufeff" + xml(), 1),
        ("a.xml", xml(), 1),
        ("single_quotes.owl", xml('<owl:Class rdf:about="&x;A"/>', "<!ENTITY x 'http://example.org/x#'>"), 1),
        ("declared_ascii.owl", xml().replace('"1.0"', '"1.0" encoding="US-ASCII"'), 1),
        ("many_brackets.ttl", PREFIX + 'e:a e:p [ e:q "[[((" ] .\n' * 2 * DEEPEST, 4 * DEEPEST),
        ("empty.ttl", "", 0),
        ("a.nt", "<http://example.org/a> <http://example.org/p> <http://example.org/B> .\n", 1),
        ("a.jsonld", json.dumps({"@context": {"e": "http://example.org/e#"}, "@id": "e:a", "@type": "e:B"}), 1),
        ("deep.jsonld", json.dumps({"@id": "http://example.org/a"} | {"e:p": {"e:q": [{"@value": "[[["}]}}), 2),
    ],
)
def test_the_syntax_of_a_file_is_detected_from_its_content(
    tmp_path: Path, name: str, content: str, triples: int
) -> None:
    assert len(read_document(written(tmp_path, name, content)).triples) == triples


BAD = [
    ("bomb.owl", xml(entities='<!ENTITY a "aaaa"><!ENTITY b "&a;&a;&a;&a;">'), 4, "entity 'b' must stand for a plain"),
    ("quadratic.owl", xml(entities=f'<!ENTITY a "{"a" * (LONGEST_ENTITY + 1)}">'), 4, "plain text of at most"),
    ("parameter.owl", xml(entities='<!ENTITY % a "b">'), 4, "plain text"),
    (
        "external.owl",
        xml("&x;", '<!ENTITY x SYSTEM "file:///etc/passwd">'),
        4,
        "refers to another file (file:///etc/pa",
    ),
    (
        "dtd.owl",
        '<?xml version="1.0"?>\n<!DOCTYPE a SYSTEM "http://example.org/a.dtd"><a/>',
        2,
        "DOCTYPE refers to another",
    ),
    ("deep.owl", xml("<owl:a><owl:b>" * 5000 + "</owl:b></owl:a>" * 5000), 8, "nested more than"),
    ("deep.ttl", PREFIX + "e:a e:p " + "[ e:p " * 10_000 + "e:x" + "]" * 10_000 + ".", 2, "nested more than"),
    ("lists.ttl", PREFIX + "e:a e:p " + "(\n" * 10_000 + ")" * 10_000 + ".", 2 + DEEPEST, "nested more than"),
    ("truncated.owl", HEAD.format(entities="") + A + "\n<owl:Cl", 9, "not XML at column 1: unclosed token"),
    ("truncated.ttl", PREFIX + 'e:a e:p "x', 2, "not Turtle at column"),
    ("undeclared.owl", xml("\n<owl:Class rdf:about='&nope;A'/>"), 9, "undefined entity"),
    ("utf16.ttl", PREFIX.encode("utf-16"), None, "is UTF-16 text: save it as UTF-8"),
    ("utf16.owl", xml().encode("utf-16"), None, "is UTF-16 text"),
    ("utf16_unmarked.owl", xml().encode("utf-16-le"), 1, "zero byte"),
    ("latin1.ttl", b"# one\n# \xe4", 2, "cannot be read as UTF-8"),
    (
        "long.ttl",
        PREFIX + f'\ne:a e:p "{"x" * 1_000_000}" .',
        3,
        f"has 1000000 characters, and may have {LONGEST_TEXT}",
    ),
    (
        "long.owl",
        xml(f'<owl:Class rdf:about="#A">\n<owl:x>{"x" * 1_000_000}</owl:x></owl:Class>'),
        9,
        "1000000 characters",
    ),
    ("binary.owl", b"\x89PNG\r\n\x1a\n\x00\x00", 1, "UTF-8"),
    ("binary.ttl", bytes(range(128)), 1, "zero byte"),
    (
        "page.xml",
        "<!DOCTYPE html>\n<html></html>",
        None,
        "neither RDF/XML nor OWL/XML: its outermost element is <html>",
    ),
    ("bad_iri.owl", xml('<owl:Class rdf:about="http://a b"/>'), None, "Invalid IRI code point"),
    ("nameless.owx", '<Ontology xmlns="http://www.w3.org/2002/07/owl#"/>', 1, "'ontologyIRI' is missing"),
    ("prefix.owx", NO_PREFIX, 2, "'b' is missing here, as prefix"),
    ("folder.ttl/x", "", None, "cannot be read"),
    ("turtle.nt", PREFIX, 1, "not N-Triples at column 1"),
    ("truncated.jsonld", '{\n"@id": "x"', 2, "not JSON at column 11"),
    ("number.jsonld", f'{{"@id": {"1" * 5000}}}', None, "not JSON"),
    ("deep.jsonld", '{"e:p": [' * 100_000, None, "lists and objects are nested more than"),
    ("closed.jsonld", "[" * (DEEPEST + 1) + "]" * (DEEPEST + 1), None, "nested more than"),
    ("wrong.jsonld", '{"@id": 3}', None, "not JSON-LD"),
    ("graph.jsonld", '{"@id": "e:g", "@graph": [{"@id": "e:a", "e:p": "x"}]}', None, "has a named graph"),
    ("remote.jsonld", '{"@context":\n"https://a.org/c.jsonld"}', 2, "<https://a.org/c.jsonld> is elsewhere"),
    ("listed.jsonld", '{"@context": [{}, "c.jsonld"]}', 1, "context <c.jsonld> is elsewhere, and nothing is fetched"),
    ("imported.jsonld", '{"@context": {"@import": "c.jsonld"}}', 1, "context <c.jsonld> is elsewhere"),
    ("scoped.jsonld", '{"@context": {"x": {"@id": "e:x", "@context": "c.jsonld"}}}', 1, "<c.jsonld> is elsewhere"),
    ("functional.owl", "# SOMA\nPrefix(e:=<http://example.org/e#>)\nOntology(<e>)", None, "save it as RDF/XML"),
    ("manchester.owl", "Prefix: e: <http://example.org/e#>\nOntology: <e>", None, "functional or Manchester syntax"),
]


@pytest.mark.parametrize(("name", "content", "line", "says"), BAD, ids=[case[0] for case in BAD])
def test_a_bad_file_is_refused_with_the_reason_and_the_line(
    tmp_path: Path, name: str, content: str | bytes, line: int | None, says: str
) -> None:
    (tmp_path / name).parent.mkdir(exist_ok=True)
    path = written(tmp_path, name, content)

    with pytest.raises(FileError) as caught:
        read_document(path.parent if name.endswith("/x") else path)

    assert says in caught.value.reason
    assert caught.value.line == line
    assert len(str(caught.value)) < 1000


@pytest.mark.parametrize(
    ("name", "subject", "term", "text"),
    [
        ("robots.owl", "robots.owl#RobotBase", None, '<owl:Class rdf:about="#RobotBase">'),
        ("robots.owl", "robots.owl#Robot", "upper.owl#Device", 'rdf:resource="&upper;Device"'),
        ("robots.owl", "robots.owl#pioneer", "robots.owl#degreesOfFreedom", "<degreesOfFreedom"),
        ("upper.owl", "upper.owl#Region", None, 'rdf:ID="Region"'),
        ("bridge.ttl", "upper.owl#Region", None, "upper:Region rdfs:subClassOf sk:Location"),
        ("../formats/tools.jsonld", "tools#Wrench", None, '"@id": "tools:Wrench"'),
        ("../formats/tools.jsonld", "tools#Wrench", "tools#turns", '"tools:turns": "nuts"'),
        ("../formats/tools.nt", "tools#Wrench", None, "tools#Wrench> <http://www.w3.org/1999"),
    ],
)
def test_a_fault_names_the_line_of_its_statement(name: str, subject: str, term: str | None, text: str) -> None:
    document = read_document(DATA / name)
    there = None if term is None else f"http://example.org/robotics/{term}"

    fault = document.fault("wrong", f"http://example.org/robotics/{subject}", there)

    assert fault.line is not None
    assert text in document.text.splitlines()[fault.line - 1]


def test_owl_xml_gives_the_same_triples_as_turtle(tmp_path: Path) -> None:
    tools = read_document(DATA / "tools.owx")

    assert tools.iri == "http://example.org/tools"
    assert tools.imports() == ("https://w3id.org/skiros-py/core",)
    assert tools.prefixes["sk"] == "https://w3id.org/skiros-py/core#"
    turtle = "<http://example.org/tools#Hammer> <http://www.w3.org/2000/01/rdf-schema#label> 'hammer'@en ."
    assert set(read_document(written(tmp_path, "same.ttl", turtle)).triples) < set(tools.triples)


def test_imports_are_never_fetched(monkeypatch: pytest.MonkeyPatch) -> None:
    def no_network(*_: object) -> None:
        raise AssertionError("somebody asked the network")

    monkeypatch.setattr(socket.socket, "connect", no_network)

    for name in ("robots.owl", "tools.owx", "bridge.ttl"):
        assert read_document(DATA / name).imports()


def test_equal_blank_node_labels_in_two_files_stay_distinct(tmp_path: Path) -> None:
    one = read_document(written(tmp_path, "one.ttl", PREFIX + "_:b e:p e:x ."))
    other = read_document(written(tmp_path, "other.ttl", PREFIX + "_:b e:p e:x ."))

    assert one.triples[0].subject != other.triples[0].subject


def test_owl_xml_without_its_library_names_the_extra(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "owlready2.owlxml_2_ntriples", None)

    with pytest.raises(FileError, match=r"tools\.owx: OWL/XML needs the extra 'ontology'"):
        read_document(DATA / "tools.owx")


@pytest.mark.parametrize("name", ["robots.owl", "tools.owx", "bridge.ttl"])
def test_a_document_is_the_same_in_another_process(name: str) -> None:
    document = read_document(DATA / name)

    assert pickle.loads(pickle.dumps(document)) == document


def test_a_folder_is_searched_for_all_rdf_and_owl_files(tmp_path: Path) -> None:
    catalog = '<catalog xmlns="urn:oasis:names:tc:entity:xmlns:xml:catalog"/>'
    for name, text in (
        ("b.ttl", ""),
        ("deep/a.owl", ""),
        ("c.rdf", ""),
        ("d.owx", ""),
        ("e.xml", xml()),
        ("catalog-v001.xml", catalog),
        ("notes.txt", ""),
    ):
        (tmp_path / name).parent.mkdir(exist_ok=True)
        written(tmp_path, name, text)

    found = [str(path.relative_to(tmp_path)) for path in rdf_files([tmp_path, tmp_path / "b.ttl"])]

    assert found == ["b.ttl", "c.rdf", "d.owx", "deep/a.owl", "e.xml"]


@pytest.mark.parametrize("name", ["long.ttl", "long.rdf"])
def test_a_text_longer_than_a_parser_can_hold_is_refused_with_the_limit(name: str, tmp_path: Path) -> None:
    long = "x" * 20_000_000
    content = (
        PREFIX + f'e:x e:p "{long}" .'
        if name == "long.ttl"
        else xml(f'<owl:Class rdf:about="#A"><p>{long}</p></owl:Class>')
    )

    with pytest.raises(FileError, match=rf"{name}.*{LONGEST_TEXT}"):
        read_document(written(tmp_path, name, content))
