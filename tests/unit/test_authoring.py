"""A skill in one class: an outside distribution's is planned with, run, pretended, tested and drawn as any other."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
from click.testing import CliRunner

from skiros_py.behaviours import Do, lines
from skiros_py.catalogue import load_catalogue
from skiros_py.checking.plugin_check import check_plugins
from skiros_py.cli.main import cli
from skiros_py.plugins.loading import load_plugins
from skiros_py.skills.behaviour import walk
from skiros_py.skills.outcome import Success
from skiros_py.station.session import Options, Session
from skiros_py.testing import TINY_ONTOLOGY, Bench, Fails, run_skill, tiny_scene, tiny_world
from skiros_py.testing.contract import contract_cases

SKILL = '''
"""Reads the code of a ball in the gripper."""

from skiros_py.authoring import Execution, Failure, Kind, Outcome, Output, SkillBase, Success, param
from skiros_py.behaviours import Do, P, Sequence, Wait
from skiros_py.devices.gripper import Gripper
from skiros_py.skills.conditions import Compare, ConditionType, Role
from skiros_py.testing.tiny import AT_LOCATION, EMPTY_HANDED, HAS_PART, HOLDING, IN_CONTAINER

READ = ConditionType("Read", (Role("ball", "tiny:Ball"),), Compare("tiny:scanned", "=", "ball", True), "It was read.")


class ReadBall(SkillBase):
    """Reads the code of a ball
    in the gripper.

    Nothing else.
    """

    arm: str = param("sk:Arm", "The arm that holds it still.", kind=Kind.HARDWARE)
    gripper: str = param("sk:Gripper", "The gripper with the ball.", kind=Kind.HARDWARE)
    ball: str = param("tiny:Ball", "The ball in the gripper.")
    seconds: float = param("number", "How long reading takes.", default=0.5, unit="s")
    least: float | None = param("number", "The narrowest ball.", kind=Kind.OPTIONAL, unit="m")
    channel: int = param("integer", "Of the reader.", kind=Kind.CONFIG, default=3, unit="1")

    agent, target = "arm", "ball"
    pre = (HAS_PART("arm", "gripper"), HOLDING("gripper", "ball"))
    post = (READ("ball"),)
    duration = 2.0
    outputs = (Output("gap", "number", "Between the fingers.", "m"),)

    def execute(self) -> Execution[Outcome]:
        yield from self.context.sleep(self.seconds)
        gap = Gripper(self.context.board, self.gripper).state.gap
        if gap < (self.least or 0.0):
            return Failure(f"there is nothing to read on channel {self.channel}")
        self.assert_effects(reason="a code was read")
        return Success("read", {"gap": gap})


class FetchAndRead(SkillBase):
    """Takes a ball out of a box and reads it."""

    arm: str = param("sk:Arm", "The arm that does it.", kind=Kind.HARDWARE)
    gripper: str = param("sk:Gripper", "The gripper on it.", kind=Kind.HARDWARE)
    robot: str = param("sk:Robot", "The robot that has it.", kind=Kind.PLANNING)
    box: str = param("tiny:Box", "Where the ball lies.")
    ball: str = param("tiny:Ball", "The ball.")

    agent, target = "arm", "ball"
    pre = (
        HAS_PART("robot", "arm"),
        HAS_PART("arm", "gripper"),
        AT_LOCATION("robot", "box"),
        IN_CONTAINER("ball", "box"),
        EMPTY_HANDED("gripper"),
    )
    post = (READ("ball"), HOLDING("gripper", "ball"), ~EMPTY_HANDED("gripper"))
    body = Sequence.of(Do.of("take", Ball=P("ball"), Box=P("box")), Do.of("read_ball", ball=P("ball")))
'''
TINY = """
from dataclasses import replace
from skiros_py.testing.tiny import AT_LOCATION, DRIVE, PICK, pretend
GO, TAKE = pretend(replace(DRIVE, name="go")), pretend(replace(PICK, name="take"))
"""
GROUPS = {
    "skills": {"read": "sk_reading:ReadBall", "go": "sk_tiny:GO", "take": "sk_tiny:TAKE"},
    "conditions": {"Read": "sk_reading:READ", "At": "sk_tiny:AT_LOCATION"},
}


@pytest.fixture
def reading(site: Any, monkeypatch: pytest.MonkeyPatch) -> Any:
    """Installs the skill beside pretended ones that bring the ball into the gripper, without the built-in skills."""
    monkeypatch.setenv("SKIROS_ONTOLOGIES", str(TINY_ONTOLOGY))
    monkeypatch.setenv("SKIROS_WITHOUT", "skiros-skills")
    site.install("sk-reading", GROUPS, {"sk_reading.py": SKILL, "sk_tiny.py": TINY})
    import sk_reading

    return sk_reading


def test_it_is_found_through_the_group_of_skills_with_its_primitive_and_its_fake(reading: Any) -> None:
    catalogue = load_catalogue()

    assert [fault for fault in catalogue.faults if "sk-reading" in fault.distribution] == []
    real, fake = catalogue.skills["read"], catalogue.skills["read[fake]"]
    assert (real.driver, fake.driver) == (None, "fake")
    assert real.description is fake.description
    assert real.description.name == "read_ball"
    assert real.description.help == "Reads the code of a ball in the gripper."
    assert [param.key for param in real.description.params] == ["arm", "gripper", "ball", "seconds", "least"]
    assert catalogue.primitives["read_ball_body"] is reading.ReadBall
    assert catalogue.sources["primitives/read_ball_body"] == "sk-reading 0.3"


def test_it_is_planned_with_and_pretended_in_a_session(reading: Any, tmp_path: Path) -> None:
    with Session(str(tiny_scene(tmp_path)), Options(fake=True)) as session:
        report = session.run(["Read(ball_1)"])

    assert report.reached, report
    assert [step.skill for step in report.steps] == ["go", "take", "read_ball"]


def test_its_contract_is_tested_and_its_rules_are_checked(reading: Any) -> None:
    report = check_plugins("sk-reading")

    assert [str(finding) for finding in report.findings] == []
    assert "read" in {case.name for case in contract_cases("sk-reading")}
    assert {contract.skill.description.name for contract in report.contracts} >= {"read_ball"}
    for case in contract_cases("sk-reading"):
        case.check()


def held(reading: Any) -> Any:
    world = tiny_world()
    with world.transaction(author="test", reason="it took it before") as tx:
        tx.place("ball_1", "sk:heldBy", "gripper_1")
    return world


def test_its_body_runs_and_asserts_what_it_sensed(reading: Any) -> None:
    trial = run_skill(reading.ReadBall.skill, held(reading), ball="ball_1").check()

    assert trial.seconds == pytest.approx(0.5, abs=0.1)
    assert [(change.author, change.reason) for change in trial.changes] == [("read_ball_body", "a code was read")]
    assert all(trial.verdicts)


def test_its_parameters_are_attributes_also_those_with_defaults_and_of_its_configuration(reading: Any) -> None:
    config = {"read_ball_body.channel": 7}

    trial = run_skill(reading.ReadBall.skill, held(reading), config=config, ball="ball_1", least=1.0, seconds=0.1)

    assert trial.reason == "there is nothing to read on channel 7"
    assert trial.changes == ()


def test_its_body_can_be_made_to_fail_in_tests(reading: Any) -> None:
    fault = Fails("read_ball_body", "the reader is dirty")

    trial = run_skill(reading.ReadBall.skill, held(reading), faults=[fault], ball="ball_1")

    assert trial.reason == "the reader is dirty"


def test_it_is_drawn_and_listed_as_any_other(reading: Any, tmp_path: Path) -> None:
    skill = reading.ReadBall.skill
    assert lines(skill.body) == ["read_ball_body(arm=arm, gripper=gripper, ball=ball, seconds=seconds, least=least)"]
    assert [node.to_data()["type"] for node in walk(skill.body)] == ["do"]

    scene = str(tiny_scene(tmp_path))
    shown = CliRunner().invoke(cli, ["module", "show", "read_ball", "--scene", scene])
    listed = CliRunner().invoke(cli, ["plugins", "--group", "skills"])

    assert "Reads the code of a ball in the gripper." in shown.output
    assert "works" in next(line for line in listed.output.splitlines() if "sk_reading:ReadBall" in line)


def test_a_composition_runs_other_skills(reading: Any) -> None:
    world = tiny_world()
    with world.transaction(author="test", reason="it went there before") as tx:
        tx.place("robot_1", "sk:at", "box_a")
    skills = [load_catalogue().skills["take"], reading.ReadBall.fake]

    run_skill(reading.FetchAndRead.skill, world, skills=skills, ball="ball_1", box="box_a").check()

    assert reading.FetchAndRead.skill.primitives == ()
    assert world.value("ball_1", "tiny:scanned") is True


def test_a_bench_needs_no_more_than_the_skill(reading: Any) -> None:
    with Bench(held(reading), [reading.ReadBall.skill], driver="any") as bench:
        assert isinstance(bench.run("read_ball", ball="ball_1"), Success)
        assert isinstance(bench.run("read_ball_body", ball="ball_1"), Success)


def test_two_distributions_with_skills_of_one_class_name_are_both_offered_with_their_own_bodies(
    reading: Any, site: Any
) -> None:
    site.install(
        "sk-reading-too",
        {"skills": {"read": "sk_reading_too:ReadBall"}},
        {"sk_reading_too.py": SKILL.replace("0.5", "0.7")},
    )

    catalogue = load_catalogue()

    for name in ("sk-reading", "sk-reading-too"):
        (do,) = walk(catalogue.skills[f"{name}.read"].body)
        assert isinstance(do, Do)
        assert do.module == f"{name}.read_ball_body"
        assert catalogue.primitives[do.module].__module__ == name.replace("-", "_")


def test_a_primitive_that_is_named_as_a_body_is_reported(reading: Any, site: Any) -> None:
    text = SKILL + '\nclass Again(ReadBall):\n    name = "read_ball_body"\n'
    groups = {"skills": {"scan": "sk_again:ReadBall"}, "primitives": {"read_ball_body": "sk_again:Again"}}
    site.install("sk-again", groups, {"sk_again.py": text})

    faults = [fault.reason for fault in load_catalogue().faults if "sk-again" in fault.distribution]

    assert any("is the name of two primitives" in reason for reason in faults)


def test_a_subclass_of_a_skill_is_no_skill(reading: Any, site: Any) -> None:
    text = "from sk_reading import ReadBall\nclass Faster(ReadBall):\n    duration = 1.0\n"
    site.install("sk-faster", {"skills": {"faster": "sk_faster:Faster"}}, {"sk_faster.py": text})

    (fault,) = (fault for fault in load_catalogue().faults if "sk-faster" in fault.distribution)

    assert "name a Skill, or a sequence of them, or a SkillBase class" in fault.reason


# ---------------------------------------------------------------- what is refused

WRONG = {
    "a misspelt parameter in a condition": (
        'HOLDING("gripper", "ball"))',
        'HOLDING("griper", "ball"))',
        "unknown parameter 'griper' in Holding(griper, ball) of skill 'read_ball'. Did you mean 'gripper'?",
    ),
    "a misspelt parameter in the body": (
        "self.context.board, self.gripper)",
        "self.context.board, self.griper)",
        "unknown parameter 'griper' in line 35 of skill 'read_ball'. Did you mean 'gripper'?",
    ),
    "a misspelt target": ('"arm", "ball"\n', '"arm", "bal"\n', "unknown parameter 'bal' as agent or target of skill"),
    "no agent": ('agent, target = "arm", "ball"', 'target = "ball"', "has no agent: say agent = '…', the parameter"),
    "no effect": ('    post = (READ("ball"),)\n    duration', "    duration", "say what it brings about by post=(…,)"),
    "an effect that is no tuple": ('(READ("ball"),)\n    duration', 'READ("ball")\n    duration', "it must be a tuple"),
    "an effect of nothing": ('READ("ball"),)\n    dur', "READ,)\n    dur", "a condition of parameters: Read('…')"),
    "a contradictory effect": (
        'post = (READ("ball"),)\n    dur',
        'post = (READ("ball"), ~READ("ball"))\n    dur',
        "Read(ball) and not Read(ball) can never hold together",
    ),
    "a default of another type": (
        "default=0.5",
        'default="slowly"',
        "its default must be a finite number, not 'slowly'",
    ),
    "an annotation of another type": (
        "seconds: float",
        "seconds: str",
        "it is OFFLINE and number: annotate it as float",
    ),
    "an optional one that is never None": ("float | None", "float", "annotate it as float | None"),
    "an unknown type": ('"integer"', '"integr"', "unknown type 'integr' of parameter channel of ReadBall"),
    "a parameter called as a part of the form": ("channel: int", "label: int", "every run has something called so"),
    "a body that never yields": (
        "        yield from self.context.sleep(self.seconds)\n",
        "",
        "execute() of skill 'read_ball' never yields, so it is not a generator",
    ),
    "an asynchronous body": (
        "    def execute(self) -> Execution[Outcome]:\n        yield from self.context.sleep(self.seconds)\n",
        "    async def execute(self) -> Execution[Outcome]:\n",
        "must be a plain generator, not async",
    ),
    "no body": ("    def execute", "    def excute", "has neither execute() nor body: give one"),
    "two bodies": (
        "    duration = 2.0",
        "    body = Wait(1.0)\n    duration = 2.0",
        "has both execute() and body: give one",
    ),
    "parameters in two places": ("    duration = 2.0", "    class Params: pass\n", "not in both"),
}


@pytest.mark.parametrize("what", WRONG)
def test_a_mistake_is_named_with_its_line_and_what_would_be_right_without_a_traceback(site: Any, what: str) -> None:
    before, after, said = WRONG[what]
    assert before in SKILL
    site.install(
        "sk-wrong", {"skills": {"read": "sk_wrong:ReadBall"}}, {"sk_wrong.py": SKILL.replace(before, after, 1)}
    )

    (fault,) = (fault for fault in load_plugins("skiros.skills")[1] if "sk-wrong" in fault.distribution)

    assert said in fault.reason
    assert (fault.origin, fault.line, fault.traceback) == (str(site.folder / "sk_wrong.py"), 13, "")


def test_commands_show_the_line_of_a_mistake(site: Any) -> None:
    text = SKILL.replace('post = (READ("ball"),)', 'post = (READ("bal"),)', 1)
    site.install("sk-wrong", {"skills": {"read": "sk_wrong:ReadBall"}}, {"sk_wrong.py": text})

    told = CliRunner().invoke(cli, ["plugins", "read"]).output
    (finding,) = check_plugins("sk-wrong", run=False).findings

    assert "unknown parameter 'bal' in Read(bal) of skill 'read_ball'. Did you mean 'ball'?" in told
    assert f"({site.folder / 'sk_wrong.py'}:13)" in told
    assert "Traceback" not in told
    assert str(finding.spot) == f"{site.folder / 'sk_wrong.py'}:13"


def test_a_class_that_no_ontology_declares_is_named_with_file_and_line(reading: Any, site: Any, tmp_path: Path) -> None:
    text = SKILL.replace("tiny:Ball", "tiny:Bal").replace("class ReadBall", "class ReadBal")
    site.install("sk-wrong", {"skills": {"wrong": "sk_wrong:ReadBal"}}, {"sk_wrong.py": text})
    line = text[: text.index("class ReadBal")].count("\n") + 1

    with Session(str(tiny_scene(tmp_path)), Options(fake=True)) as session:
        faults = [str(fault) for fault in session.catalogue.faults if "sk-wrong" in fault.distribution]

    assert any("tiny:Bal" in fault and f"sk_wrong.py:{line})" in fault for fault in faults)
