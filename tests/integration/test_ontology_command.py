"""``skiros ontology`` as people type it, and what type checkers and linters say of what it writes."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
from pathlib import Path

import mypy.api
import pytest
from support import warm_python

ROOT = Path(__file__).parents[2]
BIN = Path(sys.executable).parent
BAD = """@prefix : <http://bad#> . @prefix owl: <http://www.w3.org/2002/07/owl#> .
@prefix rdfs: <http://www.w3.org/2000/01/rdf-schema#> .
:A a owl:Class . :B a owl:Class ; owl:disjointWith :A .
:C a owl:Class ; rdfs:subClassOf :A , :B .
"""


def skiros(*arguments: str, **environment: str) -> subprocess.CompletedProcess[str]:
    return warm_python.run([*warm_python.SKIROS, "ontology", *arguments], env={**os.environ, **environment})


def test_the_installed_ontologies_check_clean_and_the_reasoner_is_named() -> None:
    result = skiros("check")

    expected = "HermiT" if shutil.which("java") else "OWL-RL"
    assert result.returncode == 0
    assert "0 errors, 0 warnings" in result.stdout
    assert f"reasoner: {expected}" in result.stdout


def test_without_java_owl_rl_runs_and_the_report_notes_it() -> None:
    result = skiros("check", PATH="")

    assert result.returncode == 0
    assert "reasoner: OWL-RL (no Java" in result.stdout


def test_findings_are_printed_with_place_and_reason_and_end_with_status_one(tmp_path: Path) -> None:
    file = tmp_path / "bad.ttl"
    file.write_text(BAD, encoding="utf-8")

    result = skiros("check", str(file))

    assert result.returncode == 1
    lines = result.stdout.splitlines()
    assert lines[0] == f"{file}:4: error: nothing can be a bad:C: these statements exclude it [unsatisfiable]"
    assert f"    nothing is both bad:B and bad:A ({file}:3)" in lines
    assert "1 file, 1 error, 0 warnings" in lines


def test_findings_as_json_are_one_object(tmp_path: Path) -> None:
    file = tmp_path / "bad.ttl"
    file.write_text(BAD, encoding="utf-8")

    answer = json.loads(skiros("check", str(file), "--reasoner", "owl-rl", "--json").stdout)

    assert (answer["status"], answer["errors"], answer["reasoner"]) == (1, 1, "OWL-RL")
    assert answer["findings"][0]["kind"] == "unsatisfiable"
    assert len(answer["findings"][0]["explanation"]) == 3


@pytest.mark.parametrize(
    "arguments",
    [
        ("check", "no-such-file.ttl"),
        ("check", str(Path(__file__).parent)),
        ("check", "--reasoner", "pellet"),
        ("check", "--time-limit", "0"),
        ("constants", "--namespace", "kiting"),
        ("constants", "-o", "a.py", "--check", str(Path(__file__))),
    ],
)
def test_wrong_usage_ends_with_status_two_and_no_traceback(arguments: tuple[str, ...]) -> None:
    result = skiros(*arguments)

    assert result.returncode == 2
    assert "Traceback" not in result.stderr
    assert result.stdout == ""


def test_hermit_without_java_is_wrong_usage() -> None:
    result = skiros("check", "--reasoner", "hermit", PATH="")

    assert result.returncode == 2
    assert "no 'java' on PATH" in result.stderr


def test_files_are_listed_with_what_they_declare() -> None:
    answer = json.loads(skiros("list", "--json").stdout)

    core = next(item for item in answer["files"] if item["iri"] == "https://w3id.org/skiros-py/core")
    assert core["classes"] > 20
    assert core["statements"] > 300


def test_constants_are_written_completely_and_compared(tmp_path: Path) -> None:
    file = tmp_path / "words.py"

    assert skiros("constants", "--namespace", "kitting", "-o", str(file)).returncode == 0
    assert skiros("constants", "--namespace", "kitting", "--check", str(file)).returncode == 0
    assert [entry.name for entry in tmp_path.iterdir()] == ["words.py"]
    file.write_text(file.read_text(encoding="utf-8").replace("STARTER", "STARTERS"), encoding="utf-8")
    stale = skiros("constants", "--namespace", "kitting", "--check", str(file))

    assert stale.returncode == 1
    assert "-STARTERS: Final" in stale.stdout
    assert "+STARTER: Final" in stale.stdout
    assert f"{file} is not current" in stale.stderr


def test_an_unwritable_folder_is_reported_and_leaves_no_files(tmp_path: Path) -> None:
    result = skiros("constants", "-o", str(tmp_path / "nowhere" / "words.py"))

    assert result.returncode == 2
    assert "nowhere" in result.stderr


def _mypy(folder: Path, text: str) -> tuple[str, int]:
    """What mypy says of a module that uses the words."""
    file = folder / "uses_words.py"
    file.write_text(text, encoding="utf-8")
    cache = f"--cache-dir={folder.parent / 'mypy'}"  # shared by the tests: most of it is the standard library
    out, errors, status = mypy.api.run(["--strict", cache, "--follow-imports=silent", "--config-file=", str(file)])
    return out + errors, status


def test_misspelt_constants_and_relations_used_as_classes_fail_type_checking(tmp_path: Path) -> None:
    good = (
        "from skiros_py.world.vocabulary import ARM, HELD_BY\n"
        "from skiros_py.world.names import ClassName\n\nA: ClassName = {}\n"
    )

    assert _mypy(tmp_path, good.format("ARM"))[1] == 0
    said, status = _mypy(tmp_path, good.format("ARM").replace("HELD_BY", "HELD_BYE"))
    assert status == 1
    assert 'has no attribute "HELD_BYE"' in said
    said, status = _mypy(tmp_path, good.format("HELD_BY"))
    assert status == 1
    assert 'has type "RelationName"' in said


def test_constants_generated_from_an_unusual_ontology_pass_linter_formatter_and_type_checker(tmp_path: Path) -> None:
    source, target = tmp_path / "odd.ttl", tmp_path / "odd.py"
    long = "a" * 90
    source.write_text(
        "@prefix o: <http://odd#> . @prefix owl: <http://www.w3.org/2002/07/owl#> .\n"
        "@prefix rdfs: <http://www.w3.org/2000/01/rdf-schema#> .\n"
        f"o:O a owl:Class . o:l a owl:Class . o:A10 a owl:Class . o:A9 a owl:Class . o:{long} a owl:Class .\n"
        'o:Q a owl:Class ; rdfs:comment "\\"quoted\\"" . o:B a owl:Class ; rdfs:comment "back\\\\slash" .\n'
        f'o:L a owl:Class ; rdfs:comment "{"long words " * 40}" .\n'
        'o:M a owl:Class ; rdfs:comment "m/s² \u2013 2 \u00d7 \u2018x\u2019" .\n'
        "o:import a owl:ObjectProperty . o:Import a owl:Class . o:Final a owl:Class . o:ClassName a owl:Class .",
        encoding="utf-8",
    )

    assert skiros("constants", str(source), "-o", str(target)).returncode == 0

    config = ["--config", str(ROOT / "pyproject.toml")]
    for command in (["check", "--no-cache"], ["format", "--check", "--no-cache"]):
        result = subprocess.run(
            [str(BIN / "ruff"), *command, *config, str(target)], capture_output=True, text=True, check=False
        )
        assert result.returncode == 0, result.stdout
    assert _mypy(tmp_path, target.read_text(encoding="utf-8"))[1] == 0


OWN = """@prefix own: <http://own.example#> . @prefix owl: <http://www.w3.org/2002/07/owl#> .
@prefix rdfs: <http://www.w3.org/2000/01/rdf-schema#> . @prefix xsd: <http://www.w3.org/2001/XMLSchema#> .
@prefix sk: <https://w3id.org/skiros-py/core#> .
<http://own.example> a owl:Ontology .
own:Crate a owl:Class ; rdfs:subClassOf sk:Object ; rdfs:comment "A crate." .
own:leansOn a owl:ObjectProperty ; rdfs:domain own:Crate ; rdfs:range sk:Furniture ; rdfs:comment "Leans on it." .
own:age a owl:DatatypeProperty ; rdfs:domain own:Crate ; rdfs:range xsd:decimal ; sk:unit "s" .
own:anywhere a owl:ObjectProperty .
"""


def test_the_classes_are_shown_as_a_tree_with_their_relations_and_properties() -> None:
    lines = skiros("tree").stdout.splitlines()

    at = lines.index("    sk:SpatialThing: Anything that has a place.")
    assert "      - sk:in -> sk:Location: The thing lies in the container." in lines[at:]
    assert "      - sk:mass: xsd:decimal [kg]: Mass [kg]; 0 for static elements." in lines[at:]
    assert any(line.strip().startswith("kitting:Table (also sk:Furniture): ") for line in lines)
    found = json.loads(skiros("tree", "--json").stdout)
    assert next(top for top in found["classes"] if top["class"] == "sk:Element")["subclasses"]


def test_of_a_file_its_classes_are_shown_below_those_of_the_installation(tmp_path: Path) -> None:
    file = tmp_path / "own.ttl"
    core = (ROOT / "ontologies" / "core.ttl").read_text(encoding="utf-8")
    prefix = next(line for line in core.splitlines() if line.startswith("@prefix sk:"))
    file.write_text(OWN.replace("@prefix sk: <https://w3id.org/skiros-py/core#> .", prefix), encoding="utf-8")

    result = skiros("tree", str(file))

    assert result.returncode == 0
    lines = [line.strip() for line in result.stdout.splitlines()]
    at = lines.index("own:Crate: A crate.")
    assert lines[at + 1 : at + 3] == ["- own:leansOn -> sk:Furniture: Leans on it.", "- own:age: xsd:decimal [s]"]
    assert not any(line.startswith("kitting:") for line in lines)
    assert lines[lines.index("anything") + 1 :].count("- own:anywhere -> anything") == 1
