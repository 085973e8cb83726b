"""Any PDDL planner by one command line."""

from __future__ import annotations

import pytest
from support.planning import tiny_pddl

from skiros_py.errors import UsageError
from skiros_py.planning.planners.planner import Answer, Solved, Unsolvable
from skiros_py.planning.planners.program_planner import CommandPlanner
from skiros_py.testing import tiny_world
from skiros_py.testing.tiny import IN_CONTAINER

DOMAIN = "(define (domain doves) (:predicates (in)) (:action enter :effect (in)))"
PROBLEM = "(define (problem one) (:domain doves) (:init) (:goal (in)))"


def answer_of(planner: CommandPlanner, domain: str = DOMAIN, problem: str = PROBLEM) -> Answer:
    try:
        return planner.solve(domain, problem).result()
    finally:
        planner.close()


PYPERPLAN = "pyperplan -s gbf -H hff {domain} {problem}"


@pytest.mark.parametrize(
    "planner",
    [
        CommandPlanner("pyperplan", PYPERPLAN),
        CommandPlanner("pyperplan", PYPERPLAN, plan="{problem}.soln"),
        CommandPlanner("kairos", "kairos {domain} {problem} --no-anytime --output {plan}"),
        CommandPlanner("kairos", "kairos {domain} {problem} --no-anytime"),
        CommandPlanner("kairos", "kairos {domain} {problem} --no-anytime --output best", plan="best*"),
    ],
    ids=["usual name", "own name", "where we want it", "printed", "pattern"],
)
def test_a_plan_is_read_from_any_file_or_from_the_output(planner: CommandPlanner) -> None:
    texts = tiny_pddl(tiny_world(), IN_CONTAINER("ball_1", "slot_1"))

    answer = answer_of(planner, texts.domain, texts.problem)

    assert isinstance(answer, Solved)
    assert [step[0] for step in answer.steps] == ["drive", "pick", "place"]


@pytest.mark.parametrize("no_plan", ["unsolvable: (.*)", {10}])
def test_a_proof_that_there_is_no_plan_is_recognised_by_output_or_exit_code(no_plan: str | set[int]) -> None:
    planner = CommandPlanner("it", "sh -c 'echo unsolvable: no way; exit 10' {domain} {problem}", no_plan=no_plan)

    assert answer_of(planner) == Unsolvable()


def test_a_search_without_a_plan_proves_nothing() -> None:
    answer = answer_of(CommandPlanner("it", "true {domain} {problem}"))

    assert answer == Unsolvable("it left no plan, and ended with code 0 and said nothing", proven=False)


@pytest.mark.parametrize(
    ("template", "words"),
    [
        ("", "it must name {domain} and {problem}, for example:\n  pyperplan"),
        ("popf {domain}", "it must name {problem}"),
        ("popf {domain} {problem} {seed}", "{seed} is none of {domain}, {plan}, {problem}"),
        ("popf '{domain} {problem}", "No closing quotation"),
    ],
)
def test_an_invalid_command_line_is_refused_with_a_valid_form(template: str, words: str) -> None:
    with pytest.raises(UsageError) as caught:
        CommandPlanner("it", template)

    assert words in str(caught.value)
