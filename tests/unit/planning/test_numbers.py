"""Numbers in plans: a battery that driving empties and a charger fills."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from pathlib import Path

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from support.battery import FULL, SKILLS, able, at_least, battery_world, charging, driving, gains
from unified_planning.engines import SequentialPlanValidator, ValidationResultStatus
from unified_planning.io import PDDLReader

from skiros_py.errors import PlanningError
from skiros_py.planning.domain.model import Action, Atom, Grounding, NoneSuch, Variable
from skiros_py.planning.plan import NoPlan, Plan, Step
from skiros_py.planning.planners.fast_downward import FastDownward
from skiros_py.planning.planners.kairos import Kairos
from skiros_py.planning.planners.planner import Planner, Planners
from skiros_py.planning.problem.task import build_task
from skiros_py.planning.robots.ordering import partial_order
from skiros_py.planning.service import Planned, PlanningOptions
from skiros_py.planning.service import plan as plan_for
from skiros_py.skills.conditions import Condition, ConditionType, Increase, Role
from skiros_py.skills.skill import SkillDescription
from skiros_py.testing.tiny import AT_LOCATION, DRIVE, IN_CONTAINER, PICK, PLACE
from skiros_py.world.view import WorldView

BOTH = (IN_CONTAINER("ball_1", "slot_1"), IN_CONTAINER("red_ball_1", "slot_2"))
RED = IN_CONTAINER("red_ball_1", "slot_2")


@pytest.fixture(scope="module")
def kairos() -> Iterator[Kairos]:
    planner = Kairos(time_limit=20.0)
    yield planner
    planner.close()


@pytest.fixture(scope="module")
def fast_downward() -> Iterator[FastDownward]:
    planner = FastDownward()
    yield planner
    planner.close()


def planned(
    planner: Planner | Planners,
    view: WorldView,
    *goal: Condition,
    skills: Sequence[SkillDescription] = SKILLS,
    temporal: bool = False,
) -> Planned:
    return plan_for(planner, view, able(view, skills), goal, options=PlanningOptions("battery", temporal=temporal))


def with_drives(need: float, cost: float) -> tuple[SkillDescription, ...]:
    return (driving(need, cost), *SKILLS[1:])


def skills_of(result: Planned) -> list[str]:
    assert isinstance(result.outcome, Plan), result.outcome
    return [step.skill for step in result.outcome.steps]


def why_not(result: Planned) -> str:
    assert isinstance(result.outcome, NoPlan), result.outcome
    return "; ".join(result.outcome.reasons)


@pytest.mark.parametrize("temporal", [False, True])
@pytest.mark.parametrize(("charge", "times"), [(100.0, 0), (50.0, 0), (49.0, 1), (20.0, 1), (19.0, 2), (5.5, 2)])
def test_a_plan_charges_exactly_as_often_as_needed(kairos: Kairos, charge: float, times: int, temporal: bool) -> None:
    steps = skills_of(planned(kairos, battery_world(charge), *BOTH, temporal=temporal))

    assert steps.count("recharge") == times
    assert steps.count("drive") == 2


def test_a_plan_goes_back_to_the_charger_where_one_charge_does_not_last(kairos: Kairos) -> None:
    third = "scene:box_c a tiny:Box ; sk:on scene:floor . scene:ball_3 a tiny:Ball ; sk:in scene:box_c ."
    world = battery_world(100.0, third, "scene:slot_3 a tiny:Slot ; sk:on scene:floor .")
    goal = (*BOTH, IN_CONTAINER("ball_3", "slot_3"))

    steps = skills_of(planned(kairos, world, *goal, skills=with_drives(40.0, 40.0)))

    assert (steps.count("drive"), steps.count("recharge")) == (4, 2)
    assert "place" in steps[: steps.index("recharge")], "it works as long as it can"


def test_numbers_are_written_as_functions_and_comparisons_of_them(kairos: Kairos) -> None:
    texts = planned(kairos, battery_world(5.5), *BOTH).texts

    assert texts is not None
    assert texts.requirements == (":strips", ":typing", ":numeric-fluents")
    for line in (
        "(charge ?x1 - robot) - number",
        "(>= (charge ?robot) 25.0)",
        "(<= (charge ?robot) 70)",
        "(increase (charge ?robot) 30.0)",
        "(decrease (charge ?robot) 25.0)",
    ):
        assert line in texts.domain
    assert "(= (charge robot_1) 5.5)" in texts.problem
    assert "charge_at" not in texts.domain + texts.problem, "what is counted is no predicate"


def test_an_external_validator_accepts_domain_and_plan(kairos: Kairos, tmp_path: Path) -> None:
    result = planned(kairos, battery_world(19.0), *BOTH)
    assert isinstance(result.outcome, Plan)
    assert result.texts is not None
    (tmp_path / "domain.pddl").write_text(result.texts.domain)
    (tmp_path / "problem.pddl").write_text(result.texts.problem)
    lines = list(map(result.texts.line, result.outcome.groundings))
    reader, statuses = PDDLReader(), []
    problem = reader.parse_problem(str(tmp_path / "domain.pddl"), str(tmp_path / "problem.pddl"))
    for steps in (lines, lines[1:]):  # without the first charge it is no plan
        (tmp_path / "plan").write_text("\n".join(steps) + "\n")
        plan = reader.parse_plan(problem, str(tmp_path / "plan"))
        statuses.append(SequentialPlanValidator().validate(problem, plan).status)

    assert statuses == [ValidationResultStatus.VALID, ValidationResultStatus.INVALID]


def test_a_value_that_is_set_is_assigned_and_one_that_nothing_counts_stays_a_fact(
    kairos: Kairos, fast_downward: FastDownward
) -> None:
    filling = charging(FULL, None)

    counted = planned(kairos, battery_world(5.0), *BOTH, skills=(driving(), PICK, PLACE, filling))
    plain = planned(fast_downward, battery_world(5.0), FULL("robot_1"), skills=(DRIVE, filling))

    assert skills_of(counted).count("recharge") == 1
    assert counted.texts is not None
    assert "(assign (charge ?robot) 100" in counted.texts.domain
    assert plain.texts is not None
    assert plain.texts.requirements == (":strips", ":typing")
    assert "(charge_100 ?robot)" in plain.texts.domain


def test_an_inequality_as_an_effect_counts_as_its_limit(kairos: Kairos, fast_downward: FastDownward) -> None:
    topping = charging(at_least(60), None)

    assert (
        skills_of(planned(kairos, battery_world(5.0), *BOTH, skills=(driving(), PICK, PLACE, topping)))[0] == "recharge"
    )
    world, skills = battery_world(5.0), (DRIVE, topping)
    assert skills_of(planned(fast_downward, world, at_least(50)("robot_1"), skills=skills)) == ["recharge"]
    assert "not at least 70" in why_not(planned(fast_downward, world, at_least(70)("robot_1"), skills=skills))


def test_the_amount_may_be_a_property_of_another_element(kairos: Kairos) -> None:
    roles = (Role("robot", "sk:Robot"), Role("socket", "tiny:Door"))
    gains = ConditionType("Gains", roles, Increase("tiny:charge", "robot", "sk:mass", "socket"), "-")
    skills = (driving(), PICK, PLACE, replace(charging(), post=(gains("Robot", "Socket"),)))

    strong = planned(kairos, battery_world(5.0, "scene:socket_1 sk:mass 65.0 ."), *BOTH, skills=skills)
    weak = planned(kairos, battery_world(5.0, "scene:socket_1 sk:mass 20.0 ."), *BOTH, skills=skills)
    none = planned(kairos, battery_world(5.0), *BOTH, skills=skills)

    assert skills_of(strong).count("recharge") == 1
    assert skills_of(weak).count("recharge") == 3
    assert isinstance(none.outcome, NoPlan)


def test_a_planner_without_numbers_is_refused_with_the_skill_and_its_effect(fast_downward: FastDownward) -> None:
    with pytest.raises(PlanningError) as caught:
        planned(fast_downward, battery_world(50.0), *BOTH)

    assert str(caught.value) == (
        "no planner takes :strips :typing :numeric-fluents: fast-downward does not take :numeric-fluents; "
        "skill 'drive' decreases the charge of Robot by 25, which a planner such as kairos can count"
    )


def test_a_planner_that_can_count_is_selected_only_where_something_counts() -> None:
    made: dict[str, type[Planner]] = {"fast-downward": FastDownward, "kairos": Kairos}
    planners = Planners(made, lambda name: made[name]())
    try:
        assert planned(planners, battery_world(50.0), *BOTH).planner == "kairos"
        assert planned(planners, battery_world(50.0), *BOTH, skills=(DRIVE, PICK, PLACE)).planner == "fast-downward"
    finally:
        planners.close()


def test_a_goal_about_a_number_is_planned(kairos: Kairos) -> None:
    assert skills_of(planned(kairos, battery_world(20.0), at_least(75)("robot_1"))) == ["recharge", "recharge"]
    assert skills_of(planned(kairos, battery_world(50.0), ~at_least(30)("robot_1"))) == ["drive"]


# ------------------------------------------------------------ no plan


def test_more_than_a_full_battery_is_the_reason(kairos: Kairos) -> None:
    text = why_not(planned(kairos, battery_world(20.0), *BOTH, skills=with_drives(130.0, 25.0)))

    assert text.endswith("the charge of robot_1 is 20, not at least 130, and no skill gets it there")


def test_a_way_for_which_no_charge_lasts_is_the_reason_even_from_a_full_battery(kairos: Kairos) -> None:
    text = why_not(planned(kairos, battery_world(20.0), *BOTH, skills=with_drives(60.0, 60.0)))

    full = "even with a charge of 100 at the start: the charge of robot_1 is 40, not at least 60 at step "
    assert f"cannot be reached: {full}" in text
    assert "drive(Base=base_1, Robot=robot_1" in text


def test_a_battery_too_empty_to_get_to_the_charger_is_the_reason_and_charging_it_the_repair(
    kairos: Kairos,
) -> None:
    world = battery_world(20.0)
    with world.transaction("test", "stranded") as tx:
        tx.place("robot_1", "sk:at", "box_a")

    outcome = planned(kairos, world, RED).outcome

    assert isinstance(outcome, NoPlan)
    assert outcome.reasons[0].endswith("the charge of robot_1 is 20, not at least 25, and no skill gets it there")
    assert outcome.repairs[0].text == "see to it that the charge of robot_1 is 25.0, and say so"
    outcome.repairs[0].apply(world)
    assert isinstance(planned(kairos, world, RED).outcome, Plan)


def test_a_charge_that_the_charger_steps_over_is_the_reason_and_charging_by_hand_the_repair(kairos: Kairos) -> None:
    world, skills = battery_world(20.0), with_drives(90.0, 25.0)  # it charges to 50 and 80, and no further

    outcome = planned(kairos, world, RED, skills=skills).outcome

    assert isinstance(outcome, NoPlan)
    why = "with a charge of 100 at the start it could be reached, but the skills that change it do not get there"
    assert outcome.reasons == (f"{RED} cannot be reached: {why}",)
    assert outcome.repairs[0].text == "see to it that the charge of robot_1 is 100.0, and say so"
    outcome.repairs[0].apply(world)
    assert isinstance(planned(kairos, world, RED, skills=skills).outcome, Plan)


def test_a_robot_without_the_number_is_the_reason(kairos: Kairos) -> None:
    assert "robot_1 has no charge" in why_not(planned(kairos, battery_world(None), *BOTH))


# ------------------------------------------------------------ order


def test_changes_of_one_robots_number_keep_their_order_and_those_of_others_do_not(kairos: Kairos) -> None:
    world = battery_world(20.0, robots=2)
    goal = (at_least(75)("robot_1"), at_least(75)("robot_2"))

    outcome = planned(kairos, world, *goal).outcome

    assert isinstance(outcome, Plan)
    assert len(outcome.steps) == 4
    robots = [step.arguments["Robot"] for step in outcome.steps]
    after = partial_order(outcome.groundings, build_task(world, able(world), goal).skills)
    for robot in ("robot_1", "robot_2"):
        first, second = (index for index, one in enumerate(robots) if one == robot)
        assert (after[first], after[second]) == (frozenset(), {first})


# ------------------------------------------------------------ against a naive simulator

PLACES = ("socket_1", "box_a", "box_b")
numbers = st.tuples(
    st.integers(0, 100), st.integers(0, 60), st.integers(1, 60), st.integers(1, 60), st.integers(5, 100)
)


@settings(max_examples=40, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(numbers, st.sampled_from(PLACES[1:]), st.integers(-1, 110))
def test_a_plan_exists_exactly_where_a_naive_search_finds_one_and_a_naive_simulation_agrees_with_it(
    kairos: Kairos, numbers: tuple[int, int, int, int, int], place: str, least: int
) -> None:
    battery = Battery(*numbers)
    skills = (driving(battery.need, battery.cost), charging(gains(battery.gain), battery.room))
    goal = (AT_LOCATION("robot_1", place), *((at_least(least)("robot_1"),) if least >= 0 else ()))

    outcome = planned(kairos, battery_world(float(battery.charge)), *goal, skills=skills).outcome

    wanted = least if least >= 0 else -1000
    assert isinstance(outcome, Plan) is battery.reaches(place, wanted)
    if isinstance(outcome, Plan):
        end, charge = battery.after(outcome.steps)
        assert end == place
        assert charge >= wanted


class Battery:
    """One robot as a naive simulation: it may also drive to where it is, which costs as much."""

    def __init__(self, charge: int, need: int, cost: int, gain: int, room: int) -> None:
        self.charge, self.need, self.cost, self.gain, self.room = charge, need, cost, gain, room

    def taken(self, skill: str, to: str, place: str, charge: int) -> tuple[str, int] | None:
        """Returns where the robot is after a step, and its charge; None if the step is impossible."""
        if skill == "drive":
            return (to, charge - self.cost) if charge >= self.need else None
        return (place, charge + self.gain) if place == to == "socket_1" and charge <= self.room else None

    def reaches(self, place: str, least: int) -> bool:
        seen, waiting = set[tuple[str, int]](), [("socket_1", self.charge)]
        while waiting:
            state = waiting.pop()
            if state[0] == place and state[1] >= least:
                return True
            if state not in seen:
                seen.add(state)
                further = (self.taken(skill, to, *state) for skill in ("drive", "recharge") for to in PLACES)
                waiting += filter(None, further)
        return False

    def after(self, steps: Sequence[Step]) -> tuple[str, int]:
        state = ("socket_1", self.charge)
        for step in steps:
            target = step.arguments["Location" if step.skill == "drive" else "Socket"]
            found = self.taken(step.skill, target, *state)
            assert found is not None, f"{step} cannot be taken with a charge of {state[1]} at {state[0]}"
            state = found
        return state


def test_numbers_are_counted_where_places_have_an_order(kairos: Kairos) -> None:
    order = [
        "scene:floor sk:useSequenceNumbers true .",
        "scene:box_a sk:sequenceNumber 2 .",
        "scene:box_b sk:sequenceNumber 1 .",
    ]

    found = planned(kairos, battery_world(100, *order), BOTH[0])

    assert isinstance(found.outcome, Plan)


def test_a_number_that_says_how_much_another_one_changes_orders_their_changes() -> None:
    heavier = Action(
        "load", "load", (Variable("?b", "tiny:Box"),), (), (), (), changes=(Atom("increase sk:mass 5.0", ("?b",)),)
    )
    elements = (Variable("?r", "sk:Robot"), Variable("?b", "tiny:Box"))
    change = Atom("decrease tiny:charge sk:mass", ("?r", "?b"))
    carry = Action("carry", "carry", elements, (), (), (), changes=(change,))
    plan = [Grounding(heavier, {"?b": "box"}), Grounding(carry, {"?r": "robot", "?b": "box"})]

    assert partial_order(plan, dict.fromkeys(("load", "carry"), DRIVE)) == (frozenset(), frozenset({0}))


def test_an_absence_of_low_numbers_waits_for_what_raises_them() -> None:
    robot = (Variable("?r", "sk:Robot"),)
    charge = Action("charge", "charge", robot, (), (), (), changes=(Atom("increase tiny:charge 30.0", ("?r",)),))
    low = NoneSuch((Variable("?x", "sk:Robot"),), (Atom("value tiny:charge < 20", ("?x",)),))
    use = Action("use", "use", robot, (), (), (), none=(low,))
    plan = [Grounding(charge, {"?r": "robot"}), Grounding(use, {"?r": "robot"})]

    assert partial_order(plan, dict.fromkeys(("charge", "use"), DRIVE)) == (frozenset(), frozenset({0}))
