"""The commands that look at a world say the same whether or not a server owns its data directory."""

from __future__ import annotations

import json
import shutil
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import pytest
from click.testing import CliRunner
from support.server_process import ServerProcess

from skiros_py.cli.main import cli, main
from skiros_py.station.worlds import open_data
from skiros_py.world.branches import learn
from skiros_py.world.change import Writer

MANY = 210
"""More than a server tells at once of what is in a place, or of the edits of a change."""
PLACES = "SELECT ?part ?place { ?part sk:in ?place } ORDER BY ?part ?place"


@dataclass(frozen=True)
class Twins:
    """Two data directories with one content, of which one has a server."""

    served: Path
    free: Path
    server: ServerProcess

    def both(self, *arguments: str) -> tuple[str, str]:
        """Returns what a command prints about either."""
        served, free = (told(*arguments, "--data", str(data)) for data in (self.served, self.free))
        return served, free


@pytest.fixture(scope="module")
def twins(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Twins]:
    served, free = (tmp_path_factory.mktemp("twins") / name for name in ("served", "free"))
    with open_data(served, "kitting") as data:
        with data.world.transaction("teach", "shown by hand") as tx:
            learn(tx, "kit_1")
        with data.world.transaction("stock", "many starters were delivered") as tx:
            for number in range(MANY):
                tx.place(tx.add("kitting:Starter", f"spare {number}"), "sk:in", "pallet_a")
        with data.world.transaction("Änne", "by hand", writer=Writer.PERSON) as tx:
            tx.place("starter_1", "sk:in", "pallet_b")
            tx.set("starter_1", "sk:mass", 0.25)
    shutil.copytree(served, free)
    with ServerProcess("--fake", data=served) as server:
        yield Twins(served, free, server)


def told(*arguments: str) -> str:
    result = CliRunner().invoke(cli, arguments, catch_exceptions=False)
    assert result.exit_code == 0, result.output
    return result.stdout


def refused(
    monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str], *arguments: str
) -> tuple[object, str, str]:
    monkeypatch.setattr("sys.argv", ["skiros", *arguments])
    with pytest.raises(SystemExit) as ended:
        main()
    out, err = capfd.readouterr()
    return ended.value.code, out, err


@pytest.mark.parametrize(
    "command",
    [
        ["world", "show", "starter_1"],
        ["world", "show", "starter_1", "--json"],
        ["world", "show", "pallet_a", "--json"],
        ["world", "history", "starter_1"],
        ["world", "history", "starter_1", "--json"],
        ["world", "history", "starter_1", "--last", "1"],
        ["world", "learned", "list"],
        ["world", "learned", "list", "--json"],
        ["world", "learned", "export"],
        ["world", "query", PLACES],
        ["world", "query", PLACES, "--csv"],
        ["world", "query", PLACES, "--json"],
        ["world", "query", "SELECT ?pose { scene:starter_1 sk:pose ?pose }", "--json"],
        ["world", "query", "ASK { scene:starter_1 sk:in $place }", "--bind", "place=pallet_b"],
        ["world", "query", "ASK { ?x sk:mass $mass }", "--bind", "mass=0.25e0", "--json"],
        ["world", "query", "CONSTRUCT { ?a sk:in ?b } { ?a sk:in ?b } ORDER BY ?a", "--json"],
        ["world", "query", "ASK { scene:starter_1 sk:placement scene:pallet_b }", "--entailed"],
    ],
    ids=lambda command: " ".join(command)[6:60],
)
def test_world_commands_print_the_same_with_and_without_a_server(twins: Twins, command: list[str]) -> None:
    served, free = twins.both(*command)

    assert served == free
    assert served.strip()


def test_the_complete_history_is_the_same_with_and_without_a_server(twins: Twins) -> None:
    served, free = (json.loads(text) for text in twins.both("world", "history", "--all", "--json"))

    assert served["remembered_from"] == free["remembered_from"] == 1
    assert served["changes"][: len(free["changes"])] == free["changes"]
    assert max(len(change["edits"]) for change in served["changes"]) == 2 * MANY


def test_the_saved_scene_is_the_same_with_and_without_a_server(twins: Twins, tmp_path: Path) -> None:
    files = [tmp_path / "served.ttl", tmp_path / "free.ttl"]
    for data, file in zip((twins.served, twins.free), files, strict=True):
        told("scene", "save", "--data", str(data), str(file))

    assert files[0].read_text(encoding="utf-8") == files[1].read_text(encoding="utf-8")


def test_writing_commands_print_the_same_with_and_without_a_server_and_keep_the_author(
    twins: Twins, tmp_path: Path
) -> None:
    file = tmp_path / "taught.ttl"
    told("world", "learned", "export", str(file), "--data", str(twins.free))
    for command in (
        ["undo"],
        ["learned", "edit", "learned:kit_1", "--label", "tall"],
        ["learned", "import", str(file), "--replace"],
        ["learned", "forget", "learned:kit_1"],
        ["undo"],
        ["learned", "add", "sk:TaughtGrasp", "--set", "sk:graspWidth=0.05"],
        ["undo"],
    ):
        changes = [json.loads(text) for text in twins.both("world", *command, "--author", "Ægir", "--json")]
        assert [change.pop("author") for change in changes] == ["Ægir", "Ægir"]
        for change in changes:
            for differs in ("number", "time", "undoes", "reason"):  # a server has written changes of its own before
                change.pop(differs)
        assert changes[0] == changes[1]


@pytest.mark.parametrize(
    "command",
    [
        ["world", "show", "starter_999"],
        ["world", "history", "starter_999"],
        ["world", "learned", "forget", "learned:nothing"],
        ["world", "query", "SELECT ?x { ?x"],
        ["world", "query", "ASK { ?x a $what }", "--bind", "what=no:thing"],
        ["world", "query", "ASK { ?x a sk:Robot }", "--csv"],
        ["world", "show", "starter_999", "--json"],
    ],
    ids=lambda command: " ".join(command)[6:60],
)
def test_world_commands_are_refused_alike_with_and_without_a_server(
    twins: Twins, command: list[str], monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    served, free = (refused(monkeypatch, capfd, *command, "--data", str(d)) for d in (twins.served, twins.free))

    assert served == free
    assert served[0] == 2
    assert "Traceback" not in served[2]


@pytest.mark.parametrize("command", [["compact"], ["create", "kitting"]], ids=lambda command: command[0])
def test_an_operation_reserved_to_the_owner_names_the_owner(
    twins: Twins, command: list[str], monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    code, _, err = refused(monkeypatch, capfd, "world", *command, "--data", str(twins.served))

    assert code == 2
    assert twins.server.url in err


def test_a_server_refuses_a_query_time_limit_over_its_own(
    twins: Twins, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    query = ("world", "query", PLACES, "--time-limit", "600")
    code, _, err = refused(monkeypatch, capfd, *query, "--data", str(twins.served))

    assert code == 2
    assert "time_limit: must be at most 60" in err
