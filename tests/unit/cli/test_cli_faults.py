"""The command line without any plug-in's skills: faults, exit statuses, and JSON also for errors."""

from __future__ import annotations

import json
import re
import signal
from collections.abc import Iterator
from pathlib import Path

import pytest
from click.testing import CliRunner, Result

from skiros_py.cli.job_order import _order
from skiros_py.cli.main import cli, main
from skiros_py.errors import UsageError
from skiros_py.testing import TINY_ONTOLOGY, tiny_scene

HEAD = """\
@prefix scene: <https://w3id.org/skiros-py/scene#> .
@prefix tiny: <https://w3id.org/skiros-py/testing/tiny#> .
@prefix sk: <https://w3id.org/skiros-py/core#> .
@prefix owl: <http://www.w3.org/2002/07/owl#> .
@prefix rdfs: <http://www.w3.org/2000/01/rdf-schema#> .
"""


@pytest.fixture(autouse=True)
def _signals() -> Iterator[None]:
    """The command ignores stops while it ends; the tests after it shall not."""
    before = {number: signal.getsignal(number) for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)}
    yield
    for number, handler in before.items():
        signal.signal(number, handler)


@pytest.fixture(autouse=True)
def _tiny(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("SKIROS_ONTOLOGIES", str(TINY_ONTOLOGY))


def status_of(monkeypatch: pytest.MonkeyPatch, *arguments: str) -> int:
    monkeypatch.setattr("sys.argv", ["skiros", *arguments])
    with pytest.raises(SystemExit) as ended:
        main()
    assert isinstance(ended.value.code, int)
    return ended.value.code


def invoke(*arguments: str) -> Result:
    return CliRunner().invoke(cli, list(arguments))


@pytest.mark.parametrize(
    "command", [[], ["run"], ["plan"], ["skills"], ["scene"], ["scene", "show"], ["scene", "list"]]
)
def test_every_command_has_help(command: list[str]) -> None:
    result = invoke(*command, "--help")

    assert result.exit_code == 0
    assert "Usage:" in result.output


def test_help_names_every_command() -> None:
    output = invoke("--help").output

    assert all(f"\n  {name} " in output for name in ("run", "plan", "skills", "scene"))


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["run"], "Missing argument 'SCENE'"),
        (["fly"], "unknown command 'fly'"),
        (["run", "kitting", "--sed", "3"], "No such option"),
        (["run", "kitting", "--fake", "--pace", "-1"], "'-1' is not 'max', 'real' or a factor"),
        (["run", "kitting", "--seed", "-1"], "-1 is not in the range"),
        (["run", "kiting", "--fake"], "unknown scene 'kiting'. Did you mean 'kitting'?"),
        (["plan", "kiting"], "unknown scene 'kiting'"),
        (["scene", "show", "kiting"], "unknown scene 'kiting'"),
    ],
)
def test_wrong_usage_ends_with_status_two_and_one_message(
    arguments: list[str], message: str, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    status = status_of(monkeypatch, *arguments)

    out, err = capsys.readouterr()
    assert status == 2
    assert message in err
    assert out == ""
    assert "Traceback" not in err


@pytest.mark.parametrize(
    "arguments", [["run", "kiting", "--fake", "--json"], ["plan", "--json"], ["scene", "show", "x", "--json", "--y"]]
)
def test_with_json_an_error_is_exactly_one_object_on_stdout(
    arguments: list[str], monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    status = status_of(monkeypatch, *arguments)

    answer = json.loads(capsys.readouterr().out)
    assert answer["status"] == status == 2
    assert answer["error"]


BROKEN_SCENES = [
    pytest.param("scene:ball_1 a tiny:Ball\nscene:x", 7, "", id="not Turtle"),
    pytest.param("scene:ball_1 a tiny:Bal .", 6, "Did you mean 'tiny:Ball'?", id="unknown class"),
    pytest.param("scene:b a tiny:Box ;\n  sk:onn scene:b .", 7, "Did you mean 'sk:on'?", id="unknown relation"),
    pytest.param("scene:b a tiny:Box ;\n  sk:on scene:flor .", 7, "unknown individual 'flor'", id="dangling"),
    pytest.param('scene:b a tiny:Box ; sk:mass "heavy" .', 6, "sk:mass", id="wrong literal"),
]


@pytest.mark.parametrize(("text", "line", "reason"), BROKEN_SCENES)
@pytest.mark.parametrize("command", [["scene", "show"], ["plan"], ["run", "--fake"]], ids=lambda c: c[0])
def test_a_broken_scene_is_reported_by_file_and_line_and_nothing_is_started(
    text: str,
    line: int,
    reason: str,
    command: list[str],
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    file = tmp_path / "broken.ttl"
    file.write_text(f"{HEAD}{text}\n", encoding="utf-8")

    status = status_of(monkeypatch, *command, str(file))

    out, err = capsys.readouterr()
    assert status == 2
    assert f"broken.ttl:{line}: " in err
    assert reason in err
    assert out == ""


@pytest.mark.parametrize(
    ("text", "line", "reason"),
    [
        pytest.param("tiny:X a owl:Class\ntiny:Y", 7, "", id="not Turtle"),
        pytest.param(
            "<https://x> a owl:Ontology .\ntiny:X a owl:Class ; rdfs:subClassOf sk:Elemnt .",
            7,
            "sk:Elemen",
            id="parent",
        ),
    ],
)
def test_a_broken_ontology_is_reported_by_file_and_line(
    text: str,
    line: int,
    reason: str,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    file = tmp_path / "words.ttl"
    file.write_text(f"{HEAD}{text}\n", encoding="utf-8")
    monkeypatch.setenv("SKIROS_ONTOLOGIES", f"{TINY_ONTOLOGY}:{file}")

    status = status_of(monkeypatch, "scene", "show", str(tiny_scene(tmp_path)))

    out, err = capsys.readouterr()
    assert status == 2
    assert f"words.ttl:{line}: " in err
    assert reason in err
    assert out == ""


def test_a_missing_file_named_in_the_environment_is_reported(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setenv("SKIROS_ONTOLOGIES", str(tmp_path / "nowhere.ttl"))

    assert status_of(monkeypatch, "scene", "show", "kitting") == 2
    assert "nowhere.ttl" in capsys.readouterr().err


def test_a_scene_is_shown_as_a_tree_with_its_goals(tmp_path: Path) -> None:
    scene = tiny_scene(tmp_path, goals=("In(ball_1, slot_1)",))

    lines = invoke("scene", "show", str(scene)).output.splitlines()

    assert lines[0] == "floor (Floor)"
    assert "  on: box_a (Box)" in lines
    assert "    in: ball_1 (Ball)" in lines
    assert "      hasA: gripper_1 (Gripper)" in lines
    assert lines[-1] == "goal: In(ball_1, slot_1)"


def test_a_scene_as_json_is_one_object(tmp_path: Path) -> None:
    result = invoke("scene", "show", str(tiny_scene(tmp_path)), "--json")

    answer = json.loads(result.output)
    assert [root["id"] for root in answer["tree"]] == ["floor", "unknown_location"]


def test_scenes_are_listed_by_the_names_that_commands_accept(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("SKIROS_SCENES", str(tiny_scene(tmp_path).parent))

    assert {"kitting", "tiny"} <= set(invoke("scene", "list").output.split())


def test_an_unknown_robot_is_answered_with_the_known_ones(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    assert status_of(monkeypatch, "plan", str(tiny_scene(tmp_path)), "--robot", "robot_9") == 2
    assert "unknown robot 'robot_9'" in capsys.readouterr().err


def test_planning_without_a_goal_asks_for_a_goal(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    assert status_of(monkeypatch, "plan", str(tiny_scene(tmp_path))) == 2

    out, err = capsys.readouterr()
    assert "comes without a goal: state one" in err
    assert out == ""


@pytest.mark.parametrize(
    ("solid", "reason"),
    [
        ("[]", "a solid needs at least one primitive"),
        ('[{"kind": "ball", "size": [1]}]', "a 'box' or a 'cylinder', not 'ball'"),
        ('[{"kind": "box", "size": [1, 1, 1], "at": [0, 0]}]', "'at' takes three finite numbers"),
    ],
)
def test_an_invalid_shape_is_reported_by_file_and_line(
    solid: str, reason: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    json_type = "<http://www.w3.org/1999/02/22-rdf-syntax-ns#JSON>"
    scene = tiny_scene(tmp_path, f"scene:box_a sk:solid '{solid}'^^{json_type} .")

    assert status_of(monkeypatch, "scene", "show", str(scene)) == 2

    err = capsys.readouterr().err
    assert re.search(r"tiny\.ttl:\d+: sk:solid of box_a", err)
    assert reason in err


def test_a_scene_nested_a_thousand_pallets_deep_is_shown_completely(tmp_path: Path) -> None:
    deep = "".join(
        f"scene:p_{i} a tiny:Box ; sk:on scene:{'floor' if i == 0 else f'p_{i - 1}'} .\n" for i in range(1200)
    )
    scene = tiny_scene(tmp_path, deep)

    told = invoke("scene", "show", str(scene))
    as_json = invoke("scene", "show", str(scene), "--json")

    assert (told.exit_code, as_json.exit_code) == (0, 0)
    assert f"{'  ' * 1200}on: p_1199 (Box)" in told.output.splitlines()
    text = as_json.output
    assert '"id": "p_1199"' in text
    assert (text.count("["), text.count("{")) == (text.count("]"), text.count("}"))


def test_control_characters_in_a_scene_never_reach_the_terminal(tmp_path: Path) -> None:
    plain = tiny_scene(tmp_path)
    (tmp_path / "evil").mkdir()
    evil = tiny_scene(
        tmp_path / "evil", 'scene:ball_9 a tiny:Ball ; sk:in scene:box_a ; rdfs:label "\\u001b[2J\\n\\r" .'
    )

    told = [
        invoke("scene", "diff", str(plain), str(evil)).output,
        invoke("world", "show", "ball_9", "--scene", str(evil)).output,
        invoke("world", "query", str(evil), "SELECT ?l { scene:ball_9 rdfs:label ?l }").output,
    ]

    assert all("\\x1b[2J\\n\\r" in text and "\x1b" not in text and "\r" not in text for text in told)


@pytest.mark.parametrize("limit", ["nan", "inf", "1e308", "0", "3601"])
@pytest.mark.parametrize(
    "command", [["world", "query", "kitting", "ASK {}"], ["ontology", "check"]], ids=lambda c: c[0]
)
def test_an_invalid_time_limit_is_refused(
    command: list[str], limit: str, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    assert status_of(monkeypatch, *command, "--time-limit", limit) == 2
    assert "is not in the range 0.0<x<=3600.0" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["ASK { $a sk:in $a }", "--bind", "a=box_a", "--bind", "a=box_b"], "--bind a is given twice"),
        (["ASK {}", "--json", "--csv"], "--json and --csv are two ways"),
        (["ASK {}", "--csv"], "only SELECT has rows"),
        (["CONSTRUCT WHERE { scene:ball_1 sk:in ?x }", "--csv"], "only SELECT has rows"),
        (["--file", "/dev/zero"], "/dev/zero: is no query: it has more than 65536 characters"),
        (["--file", "{folder}"], "cannot be read: Is a directory"),
        (["--file", "{folder}/nowhere.rq"], "nowhere.rq: cannot be read: No such file or directory"),
        (["--file", "{folder}/latin1.rq"], "latin1.rq: cannot be read as UTF-8 text"),
    ],
)
def test_a_wrong_query_command_is_refused_with_one_message(
    arguments: list[str],
    message: str,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    (tmp_path / "latin1.rq").write_bytes("ASK { ?x rdfs:label 'Größe' }".encode("latin-1"))
    given = [argument.replace("{folder}", str(tmp_path)) for argument in arguments]

    status = status_of(monkeypatch, "world", "query", str(tiny_scene(tmp_path)), *given)

    _, err = capsys.readouterr()
    assert status == 2
    assert message in err
    assert "Traceback" not in err


def test_a_query_is_read_from_a_file(tmp_path: Path) -> None:
    (tmp_path / "in.rq").write_text("ASK { scene:ball_1 sk:in scene:box_a }", encoding="utf-8")

    assert invoke("world", "query", str(tiny_scene(tmp_path)), "--file", str(tmp_path / "in.rq")).output == "yes\n"


def test_an_empty_goal_is_refused_in_words_of_the_product() -> None:
    with pytest.raises(UsageError, match=r"^that is no order: goal: must not be empty$"):
        _order(("",))
