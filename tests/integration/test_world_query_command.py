"""``skiros world query`` as people type it."""

from __future__ import annotations

import io
import json
import signal
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from support import warm_python

from skiros_py.cli.main import main
from skiros_py.station.worlds import open_data

PARTS = "SELECT ?part { ?part sk:in $place } ORDER BY ?part"
IN_PALLET_A = ["alternator_1", "relay_box_1", "starter_1"]


@pytest.fixture(autouse=True)
def _signals() -> Iterator[None]:
    """The command ignores stops while it ends; the tests after it shall not."""
    before = {number: signal.getsignal(number) for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)}
    yield
    for number, handler in before.items():
        signal.signal(number, handler)


class Command:
    """Types a command without the start of another interpreter."""

    def __init__(self, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
        self._monkeypatch = monkeypatch
        self._capsys = capsys

    def run(self, *arguments: str, stdin: str = "") -> tuple[object, str, str]:
        self._monkeypatch.setattr("sys.argv", ["skiros", "world", "query", *arguments])
        self._monkeypatch.setattr("sys.stdin", io.StringIO(stdin))
        with pytest.raises(SystemExit) as ended:
            main()
        return ended.value.code, *self._capsys.readouterr()

    def json(self, *arguments: str, stdin: str = "") -> dict[str, Any]:
        status, out, err = self.run(*arguments, "--json", stdin=stdin)
        assert (status, err) == (0, "")
        parsed: dict[str, Any] = json.loads(out)
        return parsed

    def refusal(self, *arguments: str) -> str:
        """The one message of an error."""
        status, out, err = self.run(*arguments)
        assert (status, out) == (2, "")
        assert "Traceback" not in err
        assert err.count("skiros: ") + err.count("Error: ") == 1
        return err


@pytest.fixture
def command(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> Command:
    return Command(monkeypatch, capsys)


def test_querying_a_scene_in_the_shell_prints_a_table() -> None:
    command = [*warm_python.SKIROS, "world", "query", "kitting", "-", "--bind", "place=pallet_a"]
    result = warm_python.run(command, typed=PARTS)

    assert (result.returncode, result.stderr) == (0, "")
    assert [line.strip() for line in result.stdout.splitlines()] == ["part", *IN_PALLET_A, "3 rows"]


def test_a_fault_ends_a_shell_command_with_one_line_and_status_two() -> None:
    result = warm_python.run([*warm_python.SKIROS, "world", "query", "kitting", "ASK { ?s ?p }"])

    assert (result.returncode, result.stdout) == (2, "")
    assert result.stderr.startswith("skiros: the query does not parse: line 1: ")
    assert len(result.stderr.splitlines()) == 1


def test_a_json_answer_has_columns_and_typed_values_of_bound_texts_and_numbers(command: Command) -> None:
    asked = "SELECT ?s ?n ?none { ?s sk:on ?floor ; rdfs:label $label BIND($n AS ?n) OPTIONAL { ?s sk:missing ?none } }"

    found = command.json("kitting", "-", "--bind", 'label="rack"', "--bind", "n=320", stdin=asked)

    assert found == {
        "form": "SELECT",
        "variables": ["s", "n", "none"],
        "rows": [{"s": "rack_1", "n": 320, "none": None}],
    }


def test_owl_entailments_are_included_on_request(command: Command) -> None:
    asked = "ASK { scene:starter_1 sk:placement scene:pallet_a }"

    assert command.run("kitting", asked, "--entailed", "--time-limit", "20") == (0, "yes\n", "")


def test_a_construct_query_on_a_data_directory_prints_turtle(command: Command, tmp_path: Path) -> None:
    with open_data(tmp_path / "data", "kitting") as data, data.world.transaction("test", "carried over") as tx:
        tx.place("starter_1", "sk:in", "pallet_b")
    query = "CONSTRUCT WHERE { ?part sk:in $place }"

    status, out, err = command.run(query, "--data", str(tmp_path / "data"), "--bind", "place=pallet_b")

    assert (status, err) == (0, "")
    said = [line for line in out.splitlines() if not line.startswith("@prefix")]
    assert sorted(said) == [
        f"scene:{part} sk:in scene:pallet_b ." for part in ("compressor_1", "relay_box_2", "starter_1")
    ]


def test_an_endless_query_ends_at_its_time_limit(command: Command) -> None:
    for_ever = "SELECT (COUNT(*) AS ?n) { ?a ?b ?c . ?d ?e ?f . ?g ?h ?i . ?j ?k ?l }"

    assert "took longer than 0.3 s" in command.refusal("kitting", for_ever, "--time-limit", "0.3")


def test_with_json_an_error_is_json(command: Command) -> None:
    status, out, err = command.run("kiting", "ASK {}", "--json")

    said = json.loads(out)
    assert (status, said["status"]) == (2, 2)
    assert "kiting" in said["error"]
    assert "Traceback" not in err


def test_wrong_usage_is_refused_before_the_world_is_opened(command: Command, tmp_path: Path) -> None:
    nowhere = tmp_path / "nowhere"

    assert "needs SCENE and SPARQL" in command.refusal("kitting")
    assert "needs SPARQL" in command.refusal("kitting", "ASK {}", "--data", str(nowhere))
    assert "--bind takes NAME=VALUE" in command.refusal("kitting", "ASK {}", "--bind", "place")
    assert "--bind takes NAME=VALUE" in command.refusal("kitting", "ASK {}", "--bind", "a b=1")
    assert "--time-limit" in command.refusal("kitting", "ASK {}", "--time-limit", "0")
    assert "kiting" in command.refusal("kiting", "ASK {}")
    assert "is no data directory" in command.refusal("ASK {}", "--data", str(nowhere))
    assert not nowhere.exists()
