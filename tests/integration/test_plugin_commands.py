"""``skiros plugins`` and ``skiros doctor`` with distributions that are broken in every way."""

from __future__ import annotations

import json
from typing import Any

import pytest
from click.testing import CliRunner, Result

from skiros_py.catalogue import Catalogue, fitting, load_catalogue
from skiros_py.cli.doctor import CHECKS, Finding, data_folder, examined
from skiros_py.cli.main import cli, main
from skiros_py.errors import PlanningError, UnknownName, UsageError
from skiros_py.plugins.installation import installation
from skiros_py.plugins.loading import fault_of
from skiros_py.skills.outcome import Success
from skiros_py.station.session import Options, Session
from skiros_py.testing import CONDITIONS, SKILLS, TINY_ONTOLOGY, tiny_ontology, tiny_scene

CODE = """
from dataclasses import dataclass, replace
from skiros_py.behaviours import Do
from skiros_py.skills.primitive import Primitive
from skiros_py.skills.skill import Skill
from skiros_py.testing.tiny import DRIVE, pretend
HOP = pretend(replace(DRIVE, name="hop"))
CALLS = Skill(replace(DRIVE, name="calls"), Do.of("paddle"), driver="fake")
UNSEEN = Skill(replace(DRIVE, name="unseen"), Do.of("glide"))
class Wave(Primitive):
    name = "wave"
    @dataclass(frozen=True)
    class Params: pass
    def execute(self): yield
def planner():
    raise OSError("no licence")
"""

MOVES = """
from dataclasses import replace
from skiros_py.testing.tiny import DRIVE, pretend
X = pretend(replace(DRIVE, name="tiny_drive"))
"""


@pytest.fixture(autouse=True)
def _tiny(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("SKIROS_ONTOLOGIES", str(TINY_ONTOLOGY))


@pytest.fixture
def zoo(site: Any) -> Any:
    """One distribution that works, and some that do not."""
    good = {"skills": {"hop": "sk_zoo:HOP"}, "primitives": {"wave": "sk_zoo:Wave"}}
    site.install("sk-zoo", good, {"sk_zoo.py": CODE})
    bad = {"primitives": {"paddle": "sk_zoo_bad:X"}, "reasoners": {"odd": "sk_zoo_bad:Y"}}
    site.install("sk-bad", bad, {"sk_zoo_bad.py": "1 / 0"})
    site.install("sk-gone", {"conditions": {"Gone": "sk_zoo_gone:X"}, "robots": {"crane": "sk_zoo_gone"}})
    site.install("sk-new", {"planners": {"new": "sk_zoo_new:X"}}, {}, requires=["skiros-py>=99"])
    site.install("sk-twin", {"skills": {"twin": "sk_zoo:HOP"}})
    site.install("sk-twain", {"skills": {"twin": "sk_zoo:HOP"}, "gadgets": {"toy": "sk_zoo:HOP"}})
    site.install("sk-hidden", {"scenes": {"own": "sk_zoo_hidden"}}, {"sk_zoo_hidden/kitting.ttl": ""})
    return site


def invoke(*arguments: str) -> Result:
    return CliRunner().invoke(cli, list(arguments), standalone_mode=False)


def plugins(*arguments: str) -> dict[str, Any]:
    result = invoke("plugins", "--json", *arguments)
    return {f"{p['group']} {p['name']}": p for p in json.loads(result.stdout)["plugins"]}


def test_every_plug_in_of_the_installation_works() -> None:
    result = invoke("plugins")

    assert result.return_value == 0
    assert "drive_fake" in result.stdout
    assert all(line.rstrip().endswith("works") for line in result.stdout.splitlines()[1:])


def test_each_plug_in_is_listed_with_its_origin_and_its_problems(zoo: Any) -> None:
    found = plugins()

    says = {key: p["faults"][0]["reason"] for key, p in found.items() if not p["works"]}
    assert sorted(says) == [
        "skiros.conditions Gone",
        "skiros.gadgets toy",
        "skiros.planners new",
        "skiros.primitives paddle",
        "skiros.reasoners odd",
        "skiros.robots crane",
    ]
    assert "the entry point is stale" in says["skiros.conditions Gone"]
    assert "unknown group of entry points 'skiros.gadgets'. " in says["skiros.gadgets toy"]
    assert "the entry point is stale" in says["skiros.robots crane"]
    assert says["skiros.planners new"].startswith("it is made for skiros-py>=99, and this is skiros-py ")
    assert {key for key in found if "twin" in key} == {"skiros.skills sk-twain.twin", "skiros.skills sk-twin.twin"}
    assert [plugin["distribution"] for plugin in plugins("twin").values()] == ["sk-twain", "sk-twin"]
    paddle = found["skiros.primitives paddle"]
    assert (paddle["distribution"], paddle["version"], paddle["object"]) == ("sk-bad", "0.3", "sk_zoo_bad:X")
    assert paddle["faults"][0]["origin"] == str(zoo.folder / "sk_zoo_bad.py")
    assert "ZeroDivisionError" in paddle["faults"][0]["traceback"]


@pytest.mark.parametrize("kind", ["adapters", "documents", "pages", "signals", "topics"])
def test_an_entry_point_to_a_number_is_reported_in_every_group(site: Any, kind: str) -> None:
    site.install("sk-three", {kind: {"three": "sk_three:THREE"}}, {"sk_three.py": "THREE = 3"})

    three = plugins()[f"skiros.{kind} three"]

    assert not three["works"]
    assert f"it is a int, nothing for {kind}" in three["faults"][0]["reason"]


def test_the_list_can_be_limited_to_one_group_or_one_name(zoo: Any) -> None:
    assert {p["group"] for p in plugins("--group", "primitives").values()} == {"skiros.primitives"}
    assert list(plugins("--group", "skiros.primitives", "wave")) == ["skiros.primitives wave"]

    shown = invoke("plugins", "paddle").stdout

    assert "must be   a subclass of Primitive" in shown
    assert f"file      {zoo.folder / 'sk_zoo_bad.py'}" in shown
    assert "reason    ZeroDivisionError: division by zero\nTraceback (most recent call last):" in shown


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        (["padle"], "unknown plug-in 'padle'. Did you mean 'paddle'"),
        (["--group", "skils"], "unknown group 'skils'. Did"),
    ],
)
def test_unknown_names_are_answered_with_the_nearest(zoo: Any, arguments: list[str], says: str) -> None:
    assert isinstance(error := invoke("plugins", *arguments).exception, UnknownName)
    assert str(error).startswith(says)


def test_a_broken_plug_in_changes_the_exit_status_where_it_is_listed(zoo: Any) -> None:
    assert invoke("plugins").return_value == 1
    assert invoke("plugins", "wave").return_value == 0


def test_tracebacks_are_shown_on_request(zoo: Any) -> None:
    assert "Traceback" not in invoke("plugins").stdout
    assert "plug-in paddle of sk-bad 0.3 did not load: ZeroDivisionError" in invoke("plugins", "--tracebacks").stdout


def doctor(*arguments: str) -> tuple[int, dict[str, list[dict[str, str]]]]:
    result = invoke("doctor", "--json", *arguments)
    found: dict[str, list[dict[str, str]]] = {}
    for finding in json.loads(result.stdout)["checks"]:
        found.setdefault(finding["check"], []).append(finding)
    return result.return_value, found


def test_the_doctor_finds_no_problem_in_the_test_environment() -> None:
    status, found = doctor()

    assert status == 0, [finding for own in found.values() for finding in own if finding["state"] == "wrong"]
    assert set(found) >= set(CHECKS) - {"display"}
    assert found["planner"][0]["text"] == "Fast Downward plans"


def test_the_doctor_names_each_problem_and_its_remedy(zoo: Any, tmp_path: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("SKIROS_SCENES", str(tmp_path / "nowhere"))
    status, found = doctor("--data", str(zoo.folder / "sk_zoo.py"))

    wrong = {check: [f for f in own if f["state"] == "wrong"] for check, own in found.items()}
    assert status == 1
    assert {check for check, own in wrong.items() if own} == {
        "data",
        "folders",
        "loading",
        "stale entry points",
        "versions",
    }
    assert {f["text"].split()[1] for f in wrong["stale entry points"]} == {"Gone", "crane", "new"}
    assert wrong["versions"][0]["todo"].startswith("install a release of sk-new that fits")
    assert [f["state"] for f in found["unknown groups"]] == ["note"]
    assert all(f["todo"] for own in wrong.values() for f in own)


def test_the_doctor_reports_scenes_and_ontologies_that_do_not_load(
    tmp_path: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "torn.ttl").write_text("<> <http://www.w3.org/2002/07/owl#imports> <http://nowhere> .")
    monkeypatch.setenv("SKIROS_SCENES", str(tmp_path))
    assert next(f["text"] for f in doctor()[1]["scenes"] if f["state"] == "wrong").startswith("torn: ")

    monkeypatch.setenv("SKIROS_ONTOLOGIES", str(tmp_path / "torn.ttl"))
    (tmp_path / "torn.ttl").write_text("no turtle")
    status, found = doctor()

    assert status == 1
    assert "torn.ttl:1: not Turtle" in found["ontologies"][0]["text"]
    assert found["scenes"][0]["text"].startswith("the check itself broke: FileError")


def test_a_doctor_check_that_raises_is_reported() -> None:
    def check() -> Any:
        yield Finding("half-way")
        raise ImportError("no numbers")

    half, broken = examined(check)

    assert half == Finding("half-way")
    assert broken.state == "wrong"
    assert broken.text == "the check itself broke: ImportError: no numbers"


def test_the_doctor_accepts_a_missing_data_folder_but_not_a_file_in_its_place(tmp_path: Any) -> None:
    (tmp_path / "file").touch()

    assert [finding.state for finding in data_folder(tmp_path / "a" / "b")] == ["ok"]
    assert [finding.state for finding in data_folder(tmp_path / "file" / "b")] == ["wrong"]


def test_the_doctor_prints_readable_lines(zoo: Any) -> None:
    lines = invoke("doctor").stdout.splitlines()

    assert "ok     planner             Fast Downward plans" in lines
    assert any(line.startswith("wrong  versions            sk-new 0.3: it is made for skiros-py>=99") for line in lines)
    assert lines[-1] != "nothing is wrong"


def broken_catalogue(site: Any, name: str) -> Catalogue:
    groups = {"skills": {"calls": f"{name}:CALLS", "unseen": f"{name}:UNSEEN"}}
    site.install("sk-mine", groups, {f"{name}.py": CODE})
    site.install("sk-bad", {"primitives": {"paddle": "sk_sunk:X", "glide": "sk_sunk:Y"}}, {"sk_sunk.py": "1 / 0"})
    return load_catalogue()


def test_a_skill_that_calls_a_broken_primitive_is_reported_with_the_name_of_the_primitive(site: Any) -> None:
    catalogue = broken_catalogue(site, "sk_mine_a")
    before = {fault.name for fault in catalogue.faults}

    fitted = fitting(catalogue, tiny_ontology(), catalogue.reasoners, fake=True)

    reasons = {fault.name: fault.reason for fault in fitted.faults}
    assert "paddle" not in before
    assert reasons["calls"] == (
        "it calls 'paddle': plug-in paddle of sk-bad 0.3 did not load: ZeroDivisionError: division by zero"
    )
    assert reasons["paddle"] == "ZeroDivisionError: division by zero"
    assert "glide" not in reasons, "nobody who pretends needs it"
    assert not {"calls", "unseen"} & set(fitted.skills)


WITHIN = """
from dataclasses import replace
from skiros_py.behaviours import Do, P
from skiros_py.testing.tiny import DRIVE, pretend
OUTER = pretend(replace(DRIVE, name="tour"), Do.of("hop", Location=P("Location")))
INNER = pretend(replace(DRIVE, name="hop"))
LOST = pretend(replace(DRIVE, name="lost"), Do.of("sunk", Location=P("Location")))
"""


def test_a_skill_of_one_package_calls_a_skill_of_another(site: Any, tmp_path: Any) -> None:
    site.install("sk-words", {"conditions": {"TinyAt": "skiros_py.testing.tiny:AT_LOCATION"}})
    site.install(
        "sk-outer", {"skills": {"tour": "sk_within:OUTER", "lost": "sk_within:LOST"}}, {"sk_within.py": WITHIN}
    )
    site.install("sk-inner", {"skills": {"hop": "sk_within:INNER"}})
    site.install("sk-sunk", {"skills": {"sunk": "sk_gone_down:X"}}, {"sk_gone_down.py": "1 / 0"})

    with Session(str(tiny_scene(tmp_path)), Options(fake=True)) as session:
        outcome = session.run_module("tour", {"Location": "box_a"})
        reasons = {fault.name: fault.reason for fault in session.catalogue.faults}

    assert isinstance(outcome, Success), outcome
    assert not {"tour", "hop"} & set(reasons)
    assert reasons["lost"] == (
        "it calls 'sunk': plug-in sunk of sk-sunk 0.3 did not load: ZeroDivisionError: division by zero"
    )


REAL = """
from dataclasses import replace
from skiros_py.behaviours import Wait
from skiros_py.skills.skill import Skill
from skiros_py.testing.tiny import DRIVE
X = Skill(replace(DRIVE, name="ride"), Wait(1.0))
"""


def test_a_skill_without_an_implementation_for_the_driver_is_refused_with_that_reason(site: Any, tmp_path: Any) -> None:
    site.install("sk-words", {"conditions": {"TinyCarries": "skiros_py.testing.tiny:CARRIES"}})
    site.install("sk-real", {"skills": {"ride": "sk_real:X"}}, {"sk_real.py": REAL})
    scene = str(tiny_scene(tmp_path))
    says = "ride is there, but has no implementation for driver fake"

    with Session(scene, Options(fake=True)) as session, pytest.raises(UsageError, match=says):
        session.run_module("ride", {"Location": "box_a"})
    with pytest.raises(UsageError, match=says):
        Session(scene, Options(fake=True, skills=("ride",)))
    planned = invoke("plan", scene, "--goal", "TinyCarries(robot_1, ball_1)", "--json")
    assert says in json.loads(planned.stdout)["reasons"]


def test_a_session_runs_beside_broken_primitives_and_skills(site: Any, tmp_path: Any) -> None:
    site.install("sk-words", {"conditions": {"TinyAt": "skiros_py.testing.tiny:AT_LOCATION"}})
    site.install("sk-moves", {"skills": {"tiny_drive": "sk_moves:X"}}, {"sk_moves.py": MOVES})

    with Session(
        str(tiny_scene(tmp_path)), Options(fake=True), catalogue=broken_catalogue(site, "sk_mine_b")
    ) as session:
        assert session.run(["TinyAt(robot_1, box_a)"]).reached
        assert {"calls", "paddle"} <= {fault.name for fault in session.catalogue.faults}


def test_requesting_a_broken_planner_gives_the_reason(zoo: Any) -> None:
    zoo.install("sk-lic", {"planners": {"paid": "sk_zoo:planner"}})
    catalogue = load_catalogue()

    with pytest.raises(
        UsageError, match=r"planner 'new' cannot be used: plug-in new of sk-new 0.3 did not load: it is m"
    ):
        catalogue.planner("new")
    with pytest.raises(PlanningError, match=r"planner 'paid' of sk-lic 0.3 breaks: OSError: no licence"):
        catalogue.planner("paid")
    with pytest.raises(UnknownName, match="Did you mean 'fast-downward'"):
        catalogue.planner("fast-forward")
    with pytest.raises(UnknownName, match="unknown driver 'ur5'"):
        catalogue.driver("ur5")


def test_faults_found_after_loading_are_added_to_the_catalogue(zoo: Any) -> None:
    catalogue = load_catalogue()
    (entry,) = (entry for entry in installation().entries if entry.name == "paddle")
    assert fault_of(entry, "x").name not in {fault.name for fault in catalogue.faults}

    assert "paddle" not in catalogue.primitives

    assert [fault.origin for fault in catalogue.faults if fault.name == "paddle"] == [str(zoo.folder / "sk_zoo_bad.py")]


def test_a_catalogue_made_in_memory_needs_no_plug_ins() -> None:
    skills = {skill.description.name: skill for skill in SKILLS}

    fitted = fitting(Catalogue(skills, {}, CONDITIONS, {}, {}), tiny_ontology())

    assert set(fitted.skills) == set(skills) - {fault.name for fault in fitted.faults}


def test_both_commands_are_listed_by_help(capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("sys.argv", ["skiros", "--help"])

    with pytest.raises(SystemExit):
        main()

    assert {"plugins", "doctor"} <= set(capsys.readouterr().out.split())
