from __future__ import annotations

import subprocess

import pytest
from support.planning import tiny_pddl

from skiros_py.errors import PlanningError
from skiros_py.planning.planners.kairos import Kairos, program_path
from skiros_py.planning.planners.planner import Answer, Solved, Unsolvable, lacking
from skiros_py.testing import tiny_world
from skiros_py.testing.tiny import IN_CONTAINER

DOMAIN = """
(define (domain doves) (:requirements :typing :durative-actions :numeric-fluents)
  (:types dove) (:predicates (out ?d - dove) (in ?d - dove)) (:functions (way ?d - dove) - number)
  (:durative-action enter :parameters (?d - dove) :duration (= ?duration (way ?d))
    :condition (at start (out ?d)) :effect (and (at start (not (out ?d))) (at end (in ?d)))))
"""
PROBLEM = """
(define (problem two) (:domain doves) (:objects anna bert - dove)
  (:init (out anna) (out bert) (= (way anna) 2) (= (way bert) 3.5)) (:goal (and (in anna) (in bert))))
"""


def answer_of(domain: str, problem: str) -> Answer:
    planner = Kairos()
    try:
        return planner.solve(domain, problem).result()
    finally:
        planner.close()


def test_a_classical_plan_has_no_times() -> None:
    texts = tiny_pddl(tiny_world(), IN_CONTAINER("ball_1", "slot_1"))

    answer = answer_of(texts.domain, texts.problem)

    assert isinstance(answer, Solved)
    assert [step[0] for step in answer.steps] == ["drive", "pick", "place"]
    assert (answer.starts, answer.durations) == ((), ())


def test_a_temporal_plan_has_start_times_durations_and_parallel_steps() -> None:
    answer = answer_of(DOMAIN, PROBLEM)

    assert isinstance(answer, Solved)
    assert sorted(zip(answer.steps, answer.durations, strict=True)) == [
        (("enter", "anna"), 2.0),
        (("enter", "bert"), 3.5),
    ]
    assert max(answer.starts) < 1.0


def test_the_same_task_always_has_the_same_plan() -> None:
    assert answer_of(DOMAIN, PROBLEM) == answer_of(DOMAIN, PROBLEM)


def test_kairos_reports_a_proof_that_there_is_no_plan() -> None:
    assert answer_of(DOMAIN, PROBLEM.replace("(out bert)", "")) == Unsolvable()


def test_input_that_kairos_does_not_understand_is_a_fault_with_its_message() -> None:
    with pytest.raises(PlanningError, match=r"Kairos ended with code 2:\n(.|\n)*way"):
        answer_of(DOMAIN.replace("(way ?d - dove)", ""), PROBLEM)


def test_the_declared_features_of_kairos_match_those_it_reports() -> None:
    said = subprocess.run([program_path(), "--features"], capture_output=True, text=True, check=True).stdout
    words = {word for word in said.split() if word.startswith(":")} - {":negative", ":typing"}

    assert lacking(words, Kairos.supports) == ()
