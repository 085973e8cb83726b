"""Distributions as pip would leave them behind, good and bad, found by a session on the tiny scene."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import pytest
from click.testing import CliRunner

from skiros_py.catalogue import load_catalogue
from skiros_py.cli.main import cli, main
from skiros_py.errors import UnknownName, UsageError
from skiros_py.planning.plan import NoPlan
from skiros_py.plugins.plugin import PluginFault
from skiros_py.skills.outcome import Failure
from skiros_py.station.session import Options, Session
from skiros_py.testing import TINY_ONTOLOGY, tiny_scene

Install = Callable[[str, Mapping[str, Mapping[str, str]], str], None]

GOOD = """
from dataclasses import replace
from skiros_py.testing.tiny import AT_LOCATION, DRIVE, pretend
HOP = pretend(replace(DRIVE, name="hop"))
AT = AT_LOCATION
"""
BAD = """
from dataclasses import replace
from skiros_py.behaviours import Do
from skiros_py.skills.parameters import Param
from skiros_py.skills.skill import Skill
from skiros_py.testing.tiny import DRIVE, pretend
FLY = pretend(replace(DRIVE, name="fly", params=(Param("Base", "uav:Drone", "Who."), *DRIVE.params[1:])))
SWIM = Skill(replace(DRIVE, name="swim"), Do.of("paddle"), driver="fake")
"""


@pytest.fixture
def install(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Install:
    """Installs a distribution with entry points by group, and one module."""
    monkeypatch.setenv("SKIROS_ONTOLOGIES", str(TINY_ONTOLOGY))
    site = tmp_path / "site"
    site.mkdir()
    monkeypatch.syspath_prepend(str(site))

    def make(name: str, groups: Mapping[str, Mapping[str, str]], text: str) -> None:
        info = site / f"{name}-0.3.dist-info"
        info.mkdir()
        (info / "METADATA").write_text(f"Metadata-Version: 2.1\nName: {name}\nVersion: 0.3\n", encoding="utf-8")
        lines = [
            line
            for group, points in groups.items()
            for line in (f"[skiros.{group}]", *(f"{key} = {name}:{value}" for key, value in points.items()))
        ]
        (info / "entry_points.txt").write_text("\n".join(lines) + "\n", encoding="utf-8")
        (site / f"{name}.py").write_text(text, encoding="utf-8")

    return make


def opened(folder: Path) -> Session:
    return Session(str(tiny_scene(folder)), Options(fake=True))


def faults_of(faults: tuple[PluginFault, ...], distribution: str) -> dict[str, str]:
    return {fault.name: fault.reason for fault in faults if fault.distribution == f"{distribution} 0.3"}


def test_everything_that_a_distribution_provides_is_used(install: Install, tmp_path: Path) -> None:
    install("sk_good", {"skills": {"hop": "HOP"}, "conditions": {"TinyAt": "AT"}}, GOOD)

    with opened(tmp_path) as session:
        assert "hop" in session.managers["base_1"].descriptions
        assert session.catalogue.sources["skills/hop"] == "sk_good 0.3"
        assert faults_of(session.catalogue.faults, "sk_good") == {}
        assert session.run(["TinyAt(robot_1, box_a)"]).reached


def test_unusable_skills_are_reported_and_left_out_and_the_others_are_used(install: Install, tmp_path: Path) -> None:
    install("sk_good", {"skills": {"hop": "HOP"}, "conditions": {"TinyAt": "AT"}}, GOOD)
    install("sk_bad", {"skills": {"fly": "FLY", "swim": "SWIM"}}, BAD)

    with opened(tmp_path) as session:
        faults = faults_of(session.catalogue.faults, "sk_bad")
        assert faults["fly"] == "parameter Base: no ontology declares the class uav:Drone"
        assert faults["swim"].startswith("there is no primitive or skill 'paddle'; there is")
        assert not {"fly", "swim"} & set(session.catalogue.skills)
        assert not {"fly", "swim"} & set(session.managers["base_1"].descriptions)
        assert session.run(["TinyAt(robot_1, box_a)"]).reached


def test_a_module_that_raises_on_import_does_not_affect_others(install: Install, tmp_path: Path) -> None:
    install("sk_good", {"skills": {"hop": "HOP"}, "conditions": {"TinyAt": "AT"}}, GOOD)
    install("sk_broken", {"skills": {"dive": "DIVE"}, "conditions": {"Wet": "WET"}}, "1 / 0")

    with opened(tmp_path) as session:
        faults = [f for f in session.catalogue.faults if f.distribution == "sk_broken 0.3"]
        assert [(f.group, f.name) for f in faults] == [("skiros.skills", "dive"), ("skiros.conditions", "Wet")]
        assert all("ZeroDivisionError" in f.traceback for f in faults)
        assert session.run(["TinyAt(robot_1, box_a)"]).reached


@pytest.mark.parametrize("kind", ["skills", "primitives", "conditions", "planners"])
@pytest.mark.parametrize(("text", "type_"), [("X = 5", "int"), ("X = None", "NoneType"), ("X = 'drive'", "str")])
def test_an_entry_point_of_the_wrong_type_is_refused_and_names_the_type(
    install: Install, kind: str, text: str, type_: str
) -> None:
    install(f"sk_wrong_{kind}_{type_}", {kind: {"odd": "X"}}, text)

    catalogue = load_catalogue()

    assert "odd" not in getattr(catalogue, kind)
    (reason,) = faults_of(catalogue.faults, f"sk_wrong_{kind}_{type_}").values()
    assert reason.startswith(f"it is a {type_}, nothing for {kind}: name ")


@pytest.mark.parametrize("kind", ["skills", "primitives", "conditions"])
def test_a_class_where_an_object_is_needed_is_refused(install: Install, kind: str) -> None:
    install(f"sk_class_{kind}", {kind: {"odd": "X"}}, "class X: pass")

    catalogue = load_catalogue()

    assert "odd" not in getattr(catalogue, kind)
    assert list(faults_of(catalogue.faults, f"sk_class_{kind}")) == ["odd"]


REASONERS = """
from skiros_py.world.reasoners.registry import Answer, Reasoner

class Luck(Reasoner):
    name = "luck"
    relations = frozenset({"tiny:fitsIn"})

    def answer(self, view, subject, relation, object_):
        return Answer(True, "it always does")

class Nearer(Reasoner):
    name = "nearer"
    relations = frozenset({"sk:near"})
"""
ASKING = """
from dataclasses import replace
from skiros_py.skills.conditions import Computed, ConditionType, Role
from skiros_py.testing.tiny import PLACE, pretend
ROLES = (Role("ball", "tiny:Ball"), Role("slot", "tiny:Slot"))
LUCKY = ConditionType("Lucky", ROLES, Computed("tiny:fitsIn", "ball", "slot"), "-")
DROP = pretend(replace(PLACE, name="drop", pre=(*PLACE.pre, LUCKY("Ball", "Slot"))))
"""


def test_worlds_use_the_working_reasoners_of_a_distribution_and_report_the_others(
    install: Install, tmp_path: Path
) -> None:
    install("sk_lucky", {"reasoners": {"luck": "Luck", "near": "Nearer"}}, REASONERS)
    install("sk_asking", {"skills": {"drop": "DROP"}}, ASKING)

    with opened(tmp_path) as session:
        assert session.world.objects("ball_1", "tiny:fitsIn") == ("slot_1", "slot_2")
        assert "drop" in session.catalogue.skills
        assert faults_of(session.catalogue.faults, "sk_lucky") == {
            "near": "reasoners spatial and nearer both compute sk:near"
        }


def test_a_skill_that_needs_a_relation_without_a_reasoner_is_left_out_and_reported(
    install: Install, tmp_path: Path
) -> None:
    install("sk_asking", {"skills": {"drop": "DROP"}}, ASKING)

    with opened(tmp_path) as session:
        assert "drop" not in session.catalogue.skills
        assert "no reasoner computes tiny:fitsIn" in faults_of(session.catalogue.faults, "sk_asking")["drop"]


BROKEN = {"reasoners": {"far": "Far", "paint": "Paint"}, "ontologies": {"words": "WORDS"}}
PAINT = """
from skiros_py.world.reasoners.registry import Reasoner
WORDS = 5

class Paint(Reasoner):
    name = "paint"
    relations = frozenset({"paint:likeColour"})
"""


@pytest.mark.parametrize("command", [["scene", "check"], ["scene", "show"], ["plan"]])
def test_opening_a_world_reports_failed_plug_ins_once_on_stderr(
    install: Install,
    command: list[str],
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    install("sk_faulty", BROKEN, PAINT)
    monkeypatch.setattr("sys.argv", ["skiros", *command, str(tiny_scene(tmp_path)), "--json"])

    with pytest.raises(SystemExit):
        main()

    out, err = capsys.readouterr()
    json.loads(out)
    told = [line for line in err.splitlines() if "of sk_faulty 0.3 did not load: " in line]
    assert [line.split()[:4] for line in sorted(told)] == [
        ["skiros:", "warning:", "plug-in", name] for name in ("far", "paint", "words")
    ]
    assert any("no ontology declares paint:likeColour below sk:computed" in line for line in told)


def test_the_command_line_lists_faulty_plug_ins(install: Install) -> None:
    install("sk_typo", {"skills": {"dive": "DIVE"}}, "")

    answer = json.loads(CliRunner().invoke(cli, ["skills", "--json"]).output)

    assert [f["name"] for f in answer["faults"]] == ["dive"]


LACKING = """
from dataclasses import replace
from skiros_py.simulation.fake.cell import FakeCell

class Armless(FakeCell):
    kind = "armless"

    def __init__(self, spec, *, seed):
        super().__init__(spec, seed=seed)
        self.devices = {id: device for id, device in self.devices.items() if id != "base_1"}
"""


def test_a_scene_with_a_device_that_its_driver_lacks_is_refused_with_both_named(
    install: Install, tmp_path: Path
) -> None:
    install("sk_armless", {"drivers": {"armless": "Armless"}}, LACKING)

    with pytest.raises(UsageError, match=r"driver 'armless' has no base_1, which the scene has; it has"):
        Session(str(tiny_scene(tmp_path)), Options(driver="armless"))


RIVAL = """
from dataclasses import replace
from skiros_py.skills.skill import Skill
from skiros_py.testing.tiny import pretend
from skiros_skills.pick import PICK, PICK_FAKE
OTHER = replace(PICK.description, help="Picks in another way.")
PICK_OTHER = pretend(OTHER)
"""


def rival(site: Any) -> None:
    site.install("sk-rival", {"skills": {"pick": "sk_rival:PICK_OTHER"}}, {"sk_rival.py": RIVAL})


def test_a_foreign_skill_named_as_a_built_in_one_is_offered_beside_it(site: Any, monkeypatch: Any) -> None:
    rival(site)

    with Session("kitting", Options(fake=True)) as session:
        texts = session.plan().texts
        assert {"pick", "sk-rival.pick"} <= set(session.managers["arm_1"].descriptions)
        assert isinstance(session.run_module("sk-rival.pick", {"Object": "starter_1"}), Failure)
        assert session.run().reached
    assert texts is not None
    assert {"pick", "sk-rival_pick"} <= set(texts.actions)


def test_a_distribution_can_be_left_out_by_every_command_that_opens_a_scene(site: Any) -> None:
    rival(site)
    for command in (["module", "list"], ["plan", "kitting"], ["run", "kitting", "--fake"]):
        said = CliRunner().invoke(cli, [*command, "--without", "sk_rival", "--json"], standalone_mode=False)
        assert "sk-rival" not in said.output
        assert said.return_value == 0
        assert "sk-rival" in CliRunner().invoke(cli, ["skills"]).output
    for command in ("plan", "run", "serve"):
        wrong = CliRunner().invoke(cli, [command, "kitting", "--without", "sk-rivals"])
        assert isinstance(wrong.exception, UnknownName)
        assert "Did you mean 'sk-rival'?" in str(wrong.exception)


TWICE = """
from dataclasses import replace
from skiros_skills.pick import PICK_FAKE
AGAIN = replace(PICK_FAKE, description=replace(PICK_FAKE.description, help="Another."))
BROKEN = replace(PICK_FAKE, description=replace(PICK_FAKE.description, pre=(), name="grab"), body=Do.of("gone"))
"""


def test_no_plan_names_the_skill_that_was_left_out_as_a_cause(site: Any) -> None:
    text = TWICE.replace("import replace\n", "import replace\nfrom skiros_py.behaviours import Do\n")
    site.install("sk-broken", {"skills": {"grab": "sk_broken_grab:BROKEN"}}, {"sk_broken_grab.py": text})

    with Session("kitting", Options(fake=True, skills=("drive", "place"))) as session:
        planned = session.plan()
        station = session.catalogue.absent

    assert isinstance(planned.outcome, NoPlan)
    (reason,) = [reason for reason in planned.outcome.reasons if "grab" in reason]
    assert reason.startswith("a skill would change it, but cannot be used: plug-in grab of sk-broken 0.3 did not load:")
    assert "there is no primitive or skill 'gone'" in reason
    assert [(skill.changes is not None, "grab" in skill.fault) for skill in station] == [(True, True)]


def test_no_plan_names_a_skill_of_which_nothing_is_known_as_a_possible_cause(site: Any) -> None:
    site.install("sk-broken", {"skills": {"grab": "sk_broken_import:X"}}, {"sk_broken_import.py": "1 / 0"})

    said = CliRunner().invoke(cli, ["plan", "kitting", "--skills", "drive,place", "--json"], standalone_mode=False)

    assert said.return_value == 3
    found = json.loads(said.stdout)
    because = "perhaps a skill that cannot be used would change it: plug-in grab of sk-broken 0.3 did not load: "
    assert f"{because}ZeroDivisionError: division by zero" in found["reasons"]


@pytest.mark.parametrize(
    ("text", "reason"),
    [
        ("import os\nos._exit(0)\n", "SystemExit: it tried to end the program: os._exit(0)"),
        ("while True:\n    pass\n", "TimeoutError: loading plug-in lost of sk-lost 0.3 did not end within 0.5 s"),
    ],
)
@pytest.mark.parametrize("command", [["run", "kitting", "--fake", "--json"], ["plugins"], ["check-plugin", "sk-lost"]])
def test_an_import_that_never_ends_or_ends_the_program_is_named_by_every_command(
    site: Any, monkeypatch: pytest.MonkeyPatch, caplog: Any, text: str, reason: str, command: list[str]
) -> None:
    monkeypatch.setattr("skiros_py.plugins.loading._LONGEST", 0.5)
    module = f"sk_lost_{len(text)}_{command[0].replace('-', '_')}"
    site.install("sk-lost", {"skills": {"lost": f"{module}:X"}}, {f"{module}.py": text})

    said = CliRunner().invoke(cli, command, standalone_mode=False)

    assert said.return_value == (0 if command[0] == "run" else 1)
    assert reason in said.output + caplog.text
    assert "sk-lost" in said.output + caplog.text
