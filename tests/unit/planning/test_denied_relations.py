"""What must not hold: kept up to date by whatever makes it hold, and the same as in the world."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from itertools import product

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from support.planning import tiny_task

from skiros_py.errors import PlanningError
from skiros_py.planning.domain.actions import actions_of, possible_variants
from skiros_py.planning.domain.complements import with_complements
from skiros_py.planning.domain.literals import negated
from skiros_py.planning.domain.model import Action, Atom
from skiros_py.planning.plan import Plan, Step
from skiros_py.planning.planners.fast_downward import FastDownward
from skiros_py.planning.problem.task import Capability, PlanningTask
from skiros_py.planning.replay import replay
from skiros_py.planning.service import plan
from skiros_py.skills.conditions import AllOf, ConditionType, Exists, Not, Related, Role
from skiros_py.skills.parameters import Param
from skiros_py.skills.skill import SkillDescription
from skiros_py.tasks.goals import parse_goal
from skiros_py.testing import tiny_ontology, tiny_world
from skiros_py.testing.tiny import AT_LOCATION, CONDITIONS, DRIVE, IN_CONTAINER, PICK, PLACE, SKILLS
from skiros_py.world.world import World

_ROBOT, _WHERE = Param("Robot", "sk:Robot", "Who."), Param("Location", "sk:Location", "Where.")
_OTHER = Param("Other", "sk:Location", "What else.")
KNOWS = ConditionType(
    "Knows",
    (Role("robot", "sk:Robot"), Role("location", "sk:Location")),
    Related("tiny:knows", "robot", "location"),
    "-",
)
LEARN = SkillDescription(
    "learn",
    "-",
    "Robot",
    "Location",
    (_ROBOT, _WHERE),
    (~KNOWS("Robot", "Location"),),
    (),
    (KNOWS("Robot", "Location"),),
)
FORGET = replace(LEARN, name="forget", pre=(KNOWS("Robot", "Location"),), post=(~KNOWS("Robot", "Location"),))
LEAVE = replace(DRIVE, name="leave", pre=(*DRIVE.pre, ~AT_LOCATION("Robot", "Location")))
CROWDED = ConditionType(
    "Alone",
    (Role("robot", "sk:Robot"), Role("location", "sk:Location")),
    Not(Exists("other", "sk:Robot", Related("sk:at", "other", "location"))),
    "No robot stands there.",
)
ENTER = replace(DRIVE, name="enter", pre=(*DRIVE.pre, CROWDED("Robot", "Location")))
SOME = (DRIVE, LEAVE, ENTER, LEARN, FORGET)
WORLD = tiny_world(robots=2)


def first_impossible(task: PlanningTask, steps: Sequence[Step]) -> int | None:
    """Returns the first step of which no variant can be taken in the task, whatever its own parameters are."""
    state = set(task.problem.init)
    for index, step in enumerate(steps):
        for action in (a for a in task.domain.actions if a.skill == step.skill):
            binding = _binding(task, action, step, state)
            if binding is not None:
                state -= {atom.bind(binding) for atom in action.delete}
                state |= {atom.bind(binding) for atom in action.add}
                break
        else:
            return index
    return None


def _binding(task: PlanningTask, action: Action, step: Step, state: set[Atom]) -> dict[str, str] | None:
    given = {f"?{key}": value for key, value in step.arguments.items()}
    free = [v for v in action.parameters if v.name not in given]
    for elements in product(task.problem.objects, repeat=len(free)):
        binding = given | {v.name: e for v, e in zip(free, elements, strict=True)}
        none = [atom.bind(binding) for such in action.none for atom in such.atoms]
        met = any(atom.predicate == a.predicate and atom.arguments[1] == a.arguments[1] for atom in state for a in none)
        if not met and {atom.bind(binding) for atom in action.pre} <= state:
            return binding
    return None


def steps_of(skill: SkillDescription) -> st.SearchStrategy[Step]:
    number = st.sampled_from([1, 2])
    place = st.sampled_from(["box_a", "box_b"])
    if skill in (LEARN, FORGET):
        return st.builds(lambda n, p: Step(skill.name, {"Robot": f"robot_{n}", "Location": p}), number, place)
    return st.builds(
        lambda n, p: Step(skill.name, {"Base": f"base_{n}", "Robot": f"robot_{n}", "Location": p}), number, place
    )


TASK = tiny_task(
    WORLD,
    ~AT_LOCATION("robot_1", "unknown_location"),
    KNOWS("robot_1", "box_a"),
    ~KNOWS("robot_2", "box_b"),
    AT_LOCATION("robot_2", "box_a"),
    skills=SOME,
)


@settings(max_examples=200, deadline=None)
@given(st.lists(st.one_of([steps_of(skill) for skill in (LEAVE, ENTER, LEARN)]), max_size=6))
def test_the_task_and_the_world_agree_on_possible_actions(steps: list[Step]) -> None:
    flaw = replay(WORLD, steps, [], {skill.name: skill for skill in SOME})

    assert first_impossible(TASK, steps) == (None if flaw is None else flaw.step)


def names(world: World, goal: str, *skills: SkillDescription) -> list[str]:
    planner = FastDownward()
    wanted = parse_goal([goal], world, {"Knows": KNOWS, "Alone": CROWDED, **CONDITIONS})
    able = [Capability(skill, world.instances(skill.agent_class)) for skill in skills]
    try:
        outcome = plan(planner, world, able, wanted).outcome
    finally:
        planner.close()
    assert isinstance(outcome, Plan), outcome
    return [step.skill for step in outcome.steps]


def test_an_effect_can_be_planned_to_be_undone_and_restored() -> None:
    world = tiny_world()
    with world.transaction("test", "knows its way") as tx:
        tx.relate("robot_1", "tiny:knows", "box_a")

    assert names(world, "not Knows(robot_1, box_a)", LEARN, FORGET) == ["forget"]


def test_a_robot_drives_away_from_where_it_is() -> None:
    world = tiny_world()
    with world.transaction("test", "stands there") as tx:
        tx.place("robot_1", "sk:at", "box_a")

    assert names(world, "not At(robot_1, box_a)", LEAVE) == ["leave"]


def test_a_robot_leaves_a_place_before_another_one_arrives() -> None:
    world = tiny_world(robots=2)
    with world.transaction("test", "in the way") as tx:
        tx.place("robot_1", "sk:at", "box_a")

    assert names(world, "At(robot_2, box_a)", ENTER) == ["enter", "enter"]


def test_only_queried_negations_are_facts() -> None:
    task = tiny_task(
        WORLD, ~KNOWS("robot_1", "box_a"), KNOWS("robot_1", "box_b"), skills=(replace(LEARN, pre=()), FORGET)
    )
    denied = {atom for atom in task.problem.init if atom.predicate == "not tiny:knows"}

    assert denied == {Atom("not tiny:knows", ("robot_1", "box_a"))}


def test_no_negations_are_tracked_without_a_condition_on_them() -> None:
    task = tiny_task(WORLD, AT_LOCATION("robot_1", "box_a"))

    assert not [name for name in task.domain.predicates if name.startswith("not ")]


def drive_variants() -> tuple[Action, ...]:
    (drive,) = possible_variants(actions(DRIVE), tiny_world())
    return with_complements([drive], [Atom("not sk:at", ("robot_1", "box_a"))], tiny_ontology())


def actions(skill: SkillDescription) -> tuple[Action, ...]:
    return actions_of(skill, tiny_ontology())


def test_driving_to_the_current_place_is_a_variant_without_effects() -> None:
    away, staying = drive_variants()
    here = Atom("sk:at", ("?Robot", "?Location"))

    assert negated(here) in away.pre
    assert here in staying.pre
    assert (staying.add, staying.delete) == ((), ())
    assert any(note.startswith("variant:") for note in staying.notes)


def test_a_skill_that_may_delete_and_add_the_same_fact_is_refused_by_name() -> None:
    swap = replace(
        LEARN,
        name="swap",
        params=(_ROBOT, _WHERE, _OTHER),
        pre=(KNOWS("Robot", "Location"),),
        post=(~KNOWS("Robot", "Location"), KNOWS("Robot", "Other")),
    )

    with pytest.raises(PlanningError, match=r"skill 'swap' ends knows\(Robot, Location\) and .*make two skills of it"):
        with_complements(actions(swap), [Atom("not tiny:knows", ("robot_1", "box_a"))], tiny_ontology())


@pytest.mark.parametrize(
    ("relation", "place"), [("sk:at", "unknown_location"), ("sk:at", "floor"), ("sk:on", "floor"), ("sk:in", "box_b")]
)
def test_a_robot_drives_from_any_place_and_any_relation_to_it(relation: str, place: str) -> None:
    world = tiny_world()
    with world.transaction("test", "somewhere") as tx:
        tx.place("robot_1", relation, place)

    assert names(world, "At(robot_1, box_a)", DRIVE) == ["drive"]


def test_variants_that_no_element_can_use_are_left_out() -> None:
    assert [a.name for a in possible_variants(actions(DRIVE), tiny_world())] == ["drive"]


def test_robots_placed_by_different_relations_each_have_a_variant() -> None:
    world = tiny_world(robots=2)
    with world.transaction("test", "on the floor") as tx:
        tx.place("robot_1", "sk:on", "floor")

    assert [a.name for a in possible_variants(actions(DRIVE), world)] == ["drive/1", "drive/2"]


def test_a_ball_given_from_box_to_robot_leaves_the_box_by_a_variant() -> None:
    box = Param("Box", "tiny:Box", "Where the robot stands.")
    carries = CONDITIONS["Carries"]
    load = SkillDescription(
        "load",
        "-",
        "Robot",
        "Ball",
        (_ROBOT, Param("Ball", "tiny:Ball", "What."), box),
        (AT_LOCATION("Robot", "Box"),),
        (),
        (carries("Robot", "Ball"),),
    )

    assert names(tiny_world(), "Carries(robot_1, ball_1) and not In(ball_1, box_a)", DRIVE, load) == ["drive", "load"]


def test_a_general_relation_in_a_precondition_is_met_by_any_narrower_one() -> None:
    somewhere = ConditionType(
        "Somewhere",
        (Role("ball", "tiny:Ball"), Role("place", "sk:Location")),
        Related("sk:placement", "ball", "place"),
        "-",
    )
    grab = replace(PICK, pre=tuple(somewhere("Ball", "Box") if c.type is IN_CONTAINER else c for c in PICK.pre))
    world = tiny_world("scene:ball_7 a tiny:Ball ; sk:on scene:box_b .")

    assert names(world, "In(ball_7, slot_1)", DRIVE, grab, PLACE) == ["drive", "pick", "place"]


def test_an_absence_condition_is_written_with_its_required_features() -> None:
    task = tiny_task(WORLD, AT_LOCATION("robot_2", "box_a"), skills=(ENTER,))

    (enter,) = task.domain.actions
    assert [none.atoms[0].predicate for none in enter.none] == ["sk:at"]
    assert {"robot_1", "robot_2"} <= set(task.problem.objects), "who may be in the way is in the problem"


def test_an_absence_condition_on_another_box_works_as_a_precondition() -> None:
    crowded = ConditionType(
        "Full",
        (Role("slot", "tiny:Slot"),),
        Not(Exists("ball", "tiny:Ball", AllOf((Related("sk:in", "ball", "slot"), Related("sk:on", "slot", "slot"))))),
        "-",
    )
    careful = replace(PLACE, pre=(*PLACE.pre, crowded("Slot")))

    assert names(tiny_world(), "In(ball_1, slot_1)", DRIVE, PICK, careful) == [s.description.name for s in SKILLS]
