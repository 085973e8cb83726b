"""``skiros world``: looking at a data directory, its history, and taking back."""

from __future__ import annotations

import json
import signal
from collections.abc import Iterator
from pathlib import Path

import pytest
import rdflib
from click.testing import CliRunner, Result

from skiros_py.cli.main import cli, main
from skiros_py.station.worlds import open_data
from skiros_py.testing import TINY_ONTOLOGY, tiny_scene
from skiros_py.world.change import Writer


@pytest.fixture(autouse=True)
def _tiny(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("SKIROS_ONTOLOGIES", str(TINY_ONTOLOGY))


@pytest.fixture(autouse=True)
def _signals() -> Iterator[None]:
    """The command ignores stops while it ends; the tests after it shall not."""
    before = {number: signal.getsignal(number) for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)}
    yield
    for number, handler in before.items():
        signal.signal(number, handler)


@pytest.fixture
def data(tmp_path: Path) -> str:
    """The tiny scene, weighed by a person, with one thing learned."""
    folder = tmp_path / "data"
    with open_data(folder, str(tiny_scene(tmp_path))) as directory:
        with directory.world.transaction("ann", "weighed", writer=Writer.PERSON) as tx:
            tx.set("ball_1", "sk:mass", 2.5)
        with directory.world.transaction("teacher", "this is a mug") as tx:
            tx.add("tiny:Ball", "mug", properties={"sk:appliesTo": "tiny:RedBall"}, learned=True)
    return str(folder)


def invoke(*arguments: str) -> Result:
    return CliRunner().invoke(cli, ["world", *arguments], catch_exceptions=False)


def answer(*arguments: str) -> dict[str, object]:
    result = invoke(*arguments, "--json")
    assert result.exit_code == 0
    parsed: dict[str, object] = json.loads(result.output)
    return parsed


def refusal(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], *arguments: str) -> str:
    monkeypatch.setattr("sys.argv", ["skiros", "world", *arguments])
    with pytest.raises(SystemExit) as ended:
        main()
    out, err = capsys.readouterr()
    assert (ended.value.code, out) == (2, "")
    assert "Traceback" not in err
    return err


@pytest.mark.parametrize(
    "command",
    [[], ["show"], ["history"], ["undo"], ["compact"], ["learned"], ["learned", "list"], ["learned", "forget"],
     ["learned", "export"]],
)  # fmt: skip
def test_every_command_has_help_with_an_example(command: list[str]) -> None:
    result = invoke(*command, "--help")

    assert result.exit_code == 0
    assert ("Example: skiros world " in result.output) == (command not in ([], ["learned"]))


def test_an_element_is_shown_with_its_values_relations_and_last_change(data: str) -> None:
    assert invoke("show", "ball_1", "--data", data).output.splitlines() == [
        "ball_1 (tiny:Ball) 'ball one'",
        "  changed last by change 2, at 0.0 s",
        "  sk:mass 2.5",
        "  ball_1 sk:in box_a",
    ]
    shown = answer("show", "ball_1", "--data", data)
    assert (shown["id"], shown["properties"]) == ("ball_1", {"sk:mass": 2.5})
    assert shown["relations"] == [{"subject": "ball_1", "relation": "sk:in", "object": "box_a"}]
    assert shown["changed"] == {"change": 2, "time": 0.0}


def test_an_element_of_a_scene_is_shown_too(data: str) -> None:
    scene = Path(data).parent / "tiny.ttl"

    assert answer("show", "ball_1", "--scene", str(scene))["properties"] == {}


def test_the_history_of_an_element_says_who_changed_what_and_why(data: str) -> None:
    lines = invoke("history", "ball_1", "--data", data).output.splitlines()

    assert [line.strip() for line in lines if line.startswith("        ")] == [
        "+ ball_1 (tiny:Ball) 'ball one'",
        "+ ball_1 sk:in box_a",
        "+ ball_1 sk:mass 2.5",
    ]
    assert lines[-2].endswith("ann (person): weighed")
    assert invoke("history", "ball_1", "--last", "1", "--data", data).output.splitlines() == lines[-2:]


def test_the_complete_history_as_json_has_each_change_with_its_wall_clock_time(data: str) -> None:
    found = answer("history", "--all", "--data", data)

    assert found["remembered_from"] == 1
    changes = found["changes"]
    assert isinstance(changes, list)
    assert [(c["number"], c["author"]) for c in changes] == [(1, "scene"), (2, "ann"), (3, "teacher")]
    assert all(c["written"].endswith("+00:00") for c in changes)


def test_undo_reverts_the_last_change_of_a_person(data: str) -> None:
    assert answer("undo", "--author", "bob", "--data", data)["undoes"] == 2
    assert answer("show", "ball_1", "--data", data)["properties"] == {}


def test_a_learned_concept_is_listed_forgotten_and_restored(data: str) -> None:
    assert invoke("learned", "list", "--data", data).output == "learned:ball_1 (tiny:Ball) 'mug', about tiny:RedBall\n"

    assert invoke("learned", "forget", "learned:ball_1", "--data", data).output == "change 4: forgets learned:ball_1\n"
    assert answer("learned", "list", "--data", data) == {"learned": []}

    invoke("undo", "--data", data)
    (mug,) = answer("learned", "list", "--data", data)["learned"]  # type: ignore[misc]
    assert mug["label"] == "mug"


def test_learned_concepts_are_written_to_a_file_that_a_new_directory_accepts(data: str, tmp_path: Path) -> None:
    other = tmp_path / "other"
    other.mkdir()

    assert invoke("learned", "export", str(other / "learned.ttl"), "--data", data).exit_code == 0

    assert invoke("learned", "export", "--data", data).output == (other / "learned.ttl").read_text(encoding="utf-8")
    with open_data(other) as directory:
        assert directory.world.element("learned:ball_1").label == "mug"


def test_compaction_reports_which_changes_are_kept(data: str) -> None:
    assert invoke("compact", "--keep", "1", "--data", data).output == "1 of 3 changes are remembered\n"

    assert "remembered from number 3 on" in invoke("history", "ball_1", "--data", data).output
    assert answer("compact", "--data", data) == {"remembered_from": 3, "version": 3}


def test_all_faults_are_reported_in_one_message(
    data: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def refused(*arguments: str) -> str:
        return refusal(monkeypatch, capsys, *arguments)

    assert "Did you mean 'ball_1'?" in refused("show", "bal_1", "--data", data)
    assert "either --data DIR or --scene SCENE" in refused("show", "ball_1")
    assert "either --data DIR or --scene SCENE" in refused("show", "ball_1", "--data", data, "--scene", "kitting")
    assert "either ELEMENT or --all" in refused("history", "--data", data)
    assert "either ELEMENT or --all" in refused("history", "ball_1", "--all", "--data", data)
    assert "unknown element 'bal_1'" in refused("history", "bal_1", "--data", data)
    assert "Missing option '--data'" in refused("undo")
    assert "unknown learned concept 'ball_1'" in refused("learned", "forget", "ball_1", "--data", data)
    assert "is no data directory" in refused("undo", "--data", str(tmp_path / "nowhere"))
    assert not (tmp_path / "nowhere").exists()
    assert "-1 is not in the range" in refused("compact", "--keep", "-1", "--data", data)
    with open_data(data):
        assert "in use by process" in refused("history", "--all", "--data", data)
    invoke("undo", "--data", data)
    assert "nothing to undo" in refused("undo", "--data", data)


# ---------------------------------------------------------------- learned concepts, written


def test_a_learned_concept_is_added_edited_and_taken_back(data: str) -> None:
    values = ("--set", "sk:mass=0.3", "--set", "sk:appliesTo=tiny:RedBall")
    added = answer("learned", "add", "tiny:Ball", "--label", "5", *values, "--data", data, "--author", "ann")
    edited = invoke("learned", "edit", "learned:ball_2", "--set", "sk:mass=null", "--data", data)
    same = invoke("learned", "edit", "learned:ball_2", "--set", "sk:mass=null", "--data", data)
    (one,) = [e for e in answer("learned", "list", "--data", data)["learned"] if e["id"] == "learned:ball_2"]  # type: ignore[attr-defined]
    invoke("undo", "--data", data)
    invoke("undo", "--data", data)

    assert (added["author"], added["reason"]) == ("ann", "teaches a tiny:Ball")
    assert "- learned:ball_2 sk:mass 0.3" in edited.output
    assert same.output == "nothing to change: it is so already\n"
    assert (one["label"], one["properties"]) == ("5", {"sk:appliesTo": "tiny:RedBall"})
    assert "learned:ball_2" not in invoke("learned", "list", "--data", data).output


def test_a_concept_is_learned_from_an_element_of_the_scene(data: str) -> None:
    result = invoke("learned", "add", "ball_1", "--like", "--label", "heavy", "--data", data)

    assert "+ learned:ball_2 (tiny:" in result.output
    assert "'heavy'" in result.output


def test_exported_concepts_are_imported_in_another_format(data: str, tmp_path: Path) -> None:
    file = tmp_path / "mugs.nt"
    turtle = invoke("learned", "export", "--data", data).output
    file.write_text(rdflib.Graph().parse(data=turtle, format="turtle").serialize(format="nt"), encoding="utf-8")
    invoke("learned", "forget", "learned:ball_1", "--data", data)

    result = invoke("learned", "import", str(file), "--data", data)

    assert result.exit_code == 0
    assert ": imports mugs.nt" in result.output
    assert invoke("learned", "export", "--data", data).output == turtle


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        (("add", "tiny:Ball", "--id", "mug"), "begins with 'learned:'"),
        (("add", "tiny:Ball", "--id", "learned:b", "--like"), "leave out 'id'"),
        (("add", "tiny:Ball", "--set", "sk:mass=heavy"), "sk:mass"),
        (("edit", "ball_1", "--label", "x"), "unknown learned concept 'ball_1'"),
        (("import", "FILE"), "may speak of learned: individuals only; 'tiny:Ball' belongs into an ontology file"),
    ],
)
def test_what_no_learned_concept_can_be_is_refused(
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
    data: str,
    tmp_path: Path,
    arguments: tuple[str, ...],
    says: str,
) -> None:
    file = tmp_path / "foreign.ttl"
    file.write_text("@prefix tiny: <https://w3id.org/skiros-py/testing/tiny#> . tiny:Ball tiny:x 1 .", encoding="utf-8")

    given = (str(file) if word == "FILE" else word for word in arguments)
    assert says in refusal(monkeypatch, capsys, "learned", *given, "--data", data)
