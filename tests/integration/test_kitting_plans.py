"""The shipped skills on the shipped scenes: planning only, and a run with a robot that pretends."""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path

import pytest
from unified_planning.environment import Environment
from unified_planning.io import PDDLReader

import skiros_py
from skiros_py.errors import UnknownName, UsageError
from skiros_py.execution.monitor import Status
from skiros_py.geometry import Pose
from skiros_py.planning.plan import NoPlan, Plan
from skiros_py.station.session import Options, Session
from skiros_py.world.element import Placement
from skiros_py.world.poses import write_pose

SCENES = ["kitting", "kitting_carried"]


@pytest.fixture(scope="module", params=SCENES)
def opened(request: pytest.FixtureRequest) -> Iterator[Session]:
    with Session(request.param, Options(fake=True)) as session:
        yield session


@pytest.fixture(scope="module")
def kitting() -> Iterator[Session]:
    with Session("kitting", Options(fake=True)) as session:
        yield session


def test_unified_planning_reads_what_fast_downward_solved(opened: Session, tmp_path: Path) -> None:
    planned = opened.plan()
    (tmp_path / "domain.pddl").write_text(planned.texts.domain, encoding="utf-8")
    (tmp_path / "problem.pddl").write_text(planned.texts.problem, encoding="utf-8")

    problem = PDDLReader(Environment()).parse_problem(str(tmp_path / "domain.pddl"), str(tmp_path / "problem.pddl"))

    assert isinstance(planned.outcome, Plan)
    assert {action.name for action in problem.actions} == set(planned.texts.actions)


def test_the_domain_is_typed_strips_and_printed_the_same_each_time(opened: Session) -> None:
    one, other = opened.plan().texts, opened.plan().texts

    assert (one.domain, one.problem) == (other.domain, other.problem)
    assert re.findall(r"\(:requirements ([^)]*)\)", one.domain) == [":strips :typing"]


def test_the_robot_drives_to_a_kit_on_the_table_but_not_to_one_on_its_deck() -> None:
    drives = {}
    for scene in SCENES:
        with Session(scene, Options(fake=True)) as session:
            outcome = session.plan().outcome
        assert isinstance(outcome, Plan)
        drives[scene] = {s.arguments["Location"] for s in outcome.steps if s.skill == "drive"}

    assert drives == {"kitting": {"pallet_a", "pallet_b", "kit_1"}, "kitting_carried": {"pallet_a", "pallet_b"}}


@pytest.mark.parametrize(
    ("goal", "reason"),
    [
        (
            "ObjectAtLocation(starter_1, kit_1_a) and ObjectAtLocation(starter_1, kit_1_b)",
            "exclude each other: starter_1 has one place only",
        ),
        ("RobotAtLocation(robot_1, floor)", "needs that floor has a driving pose"),
        ("ObjectAtLocation(starter_1, pallet_b)", "pallet_b is not a Compartment, which skill 'place' needs"),
    ],
)
def test_an_impossible_goal_is_explained_in_the_words_of_the_operator(kitting: Session, goal: str, reason: str) -> None:
    outcome = kitting.plan(kitting.parse([goal])).outcome

    assert isinstance(outcome, NoPlan)
    assert reason in outcome.reasons[0]


def test_a_goal_is_parsed_again_when_the_world_has_changed() -> None:
    with skiros_py.open("kitting", fake=True) as session:
        before = session.parse(["InKit(Starter, kit_1)"])
        assert session.parse(["InKit(Starter, kit_1)"]) is before
        with pytest.raises(UnknownName):
            session.parse(["ObjectAtLocation(starter_9, kit_1_a)"])
        with session.world.transaction("test", "another") as tx:
            tx.add("kitting:Starter", id="starter_9", placement=Placement("sk:in", "pallet_a"))
        assert session.parse(["ObjectAtLocation(starter_9, kit_1_a)"])


def test_putting_any_part_into_a_kit_takes_one_pick_and_one_place(kitting: Session) -> None:
    outcome = kitting.plan(kitting.parse(["InKit(RelayBox, kit_1)"])).outcome

    assert isinstance(outcome, Plan)
    assert [s.skill for s in outcome.steps] == ["drive", "pick", "drive", "place"]


def test_a_part_that_was_let_go_and_not_seen_yet_is_looked_for() -> None:
    with skiros_py.open("kitting", fake=True) as session:
        with session.world.transaction("test", "let go") as tx:
            tx.place("starter_1", "sk:mayBeIn", "kit_1_a")
        report = session.run(["InKit(Starter, kit_1)"])

        assert report.reached
        assert [step.skill for step in report.steps] == ["drive", "search"]
        assert session.world.related("starter_1", "sk:in", "kit_1_a")


def test_a_part_is_taken_from_whatever_it_was_seen_to_lie_on() -> None:
    found = {}
    with skiros_py.open("kitting", fake=True) as session:
        for place in ("kit_1", "kit_table", "floor"):
            with session.world.transaction("test", "seen") as tx:
                tx.place("starter_1", "sk:on", place)
                write_pose(tx, "starter_1", Pose((2.0, 0.0, 0.54)))
            outcome = session.plan(["InKit(starter_1, kit_1)"]).outcome
            assert isinstance(outcome, Plan)
            found[place] = [(s.skill, s.arguments.get("Container")) for s in outcome.steps]
        with session.world.transaction("test", "lost") as tx:
            write_pose(tx, "starter_1", None)
        lost = session.plan(["InKit(starter_1, kit_1)"]).outcome

    assert found == {place: [("drive", None), ("pick", place), ("place", None)] for place in found}
    assert isinstance(lost, NoPlan)
    assert "starter_1 is on floor, and no skill takes it from there" in lost.reasons[0]


@pytest.mark.parametrize("scene", SCENES)
def test_a_fake_robot_reaches_the_goal_of_the_scene(scene: str) -> None:
    with skiros_py.open(scene, fake=True) as session:
        report = session.run()

        assert session.world.related("starter_1", "sk:in", "kit_1_a")
    assert report.reached
    assert [c.tries for c in report.conditions] == [1, 1, 1]


def test_equal_seeds_give_equal_digests() -> None:
    def digest() -> str:
        with skiros_py.open("kitting", fake=True, seed=3) as session:
            return session.run(["InKit(Starter, kit_1)"]).digest

    assert digest() == digest() != ""


def test_a_stop_requested_before_the_run_ends_it_in_its_first_cycle() -> None:
    with skiros_py.open("kitting", fake=True) as session:
        session.stop()
        report = session.run()

    assert report.stopped
    assert not report.reached
    assert report.steps == ()


def test_a_fake_session_has_no_simulation() -> None:
    with skiros_py.open("kitting", fake=True) as session, pytest.raises(UsageError, match="leave out --fake"):
        _ = session.simulation


def test_a_session_may_be_closed_twice() -> None:
    session = skiros_py.open("kitting", fake=True)
    session.close()
    session.close()


def test_a_negated_goal_is_planned_and_reached(kitting: Session) -> None:
    report = kitting.run(["not ObjectAtLocation(relay_box_1, pallet_a)"])

    assert report.reached
    assert [step.skill for step in report.steps] == ["drive", "pick"]


def test_a_negated_goal_that_already_holds_is_accepted(kitting: Session) -> None:
    report = kitting.run(["not InKit(Starter, kit_1)"])

    assert report.reached
    assert report.steps == ()


def test_variants_of_one_skill_have_distinct_names() -> None:
    with Session("kitting_carried", Options(fake=True)) as session:
        actions = session.plan().texts.actions

    assert {action.skill for action in actions.values()} >= {"drive", "pick", "place"}
    assert len({action.name for action in actions.values()}) == len(actions)


def test_each_condition_in_the_report_has_the_time_when_it_was_reached() -> None:
    with skiros_py.open("kitting", fake=True) as session:
        report = session.run()

    times = [c.simulated for c in report.conditions]
    assert None not in times
    assert max(times) == pytest.approx(report.simulated, abs=0.1)
    assert len(set(times)) == 3, "one after the other"
    assert all(0.0 < c.wall <= report.wall for c in report.conditions)


def test_conditions_reached_before_a_stop_count_as_reached() -> None:
    with Session("kitting", Options(fake=True)) as session:
        session.monitor.subscribe(lambda e: (e.module, e.status) == ("place", Status.TERMINATED) and session.stop())
        report = session.run(["InKit(Starter, kit_1) and InKit(Alternator, kit_1)"])

    by_reached = {condition.believed: condition for condition in report.conditions}
    assert report.stopped
    assert (by_reached[True].tries, by_reached[True].reason) == (1, "")
    assert by_reached[False].reason == "stopped"
