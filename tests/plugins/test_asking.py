from __future__ import annotations

from collections.abc import Iterator

import pytest

from skiros_primitives.asking import Choose, Confirm, Refill
from skiros_py.skills.outcome import Failure, Success
from skiros_py.testing import Bench, answers, tiny_world

LOST = "scene:ball_2 a tiny:Ball ; sk:on scene:unknown_location ; sk:missing true ; sk:missedLooks 2 ."
UNSEEN = 'scene:ball_3 a tiny:Ball ; sk:in scene:box_a ; sk:missedLooks 1 ; sk:pose "1 0 0 0 0 0"^^sk:poseLiteral .'


@pytest.fixture
def bench() -> Iterator[Bench]:
    with Bench(tiny_world(LOST, UNSEEN), primitives=(Confirm, Choose, Refill)) as made:
        yield made


def test_the_answer_yes_succeeds_and_no_fails_with_the_question(bench: Bench) -> None:
    answers(bench.questions, {"closed": "yes", "empty": "no"})

    assert bench.run("confirm", question="Is the door closed?") == Success("yes")
    assert bench.run("confirm", question="Is it empty?") == Failure("a person said no: Is it empty?")


@pytest.mark.parametrize(
    ("module", "arguments"),
    [
        ("confirm", {"question": "Well?"}),
        ("choose", {"question": "Which?", "options": ("a", "b")}),
        ("refill", {"place": "box_a", "what": "tiny:Ball"}),
    ],
)
def test_without_a_listener_a_question_fails_at_once(bench: Bench, module: str, arguments: dict[str, object]) -> None:
    outcome = bench.run(module, **arguments)

    assert isinstance(outcome, Failure)
    assert "there is no one to answer" in outcome.reason
    assert bench.time < 0.1


def test_a_question_stays_open_until_it_is_answered(bench: Bench) -> None:
    asked = answers(bench.questions, {})
    running = bench.start("confirm", question="Go on?")
    bench.advance(10.0)
    assert not running.done

    bench.questions.answer(asked.asked[0].id, "yes", by="Ada")
    bench.advance(0.1)

    assert running.result == Success("yes")
    assert bench.questions.open == ()
    assert any("Ada answered: yes" in event.text for event in bench.events)


def test_an_unanswered_question_fails_after_its_timeout_and_is_withdrawn(bench: Bench) -> None:
    answers(bench.questions, {})

    outcome = bench.run("confirm", question="Go on?", patience=2.0)

    assert outcome == Failure("no answer within 2 s: Go on?")
    assert 2.0 <= bench.time < 2.2
    assert bench.questions.open == ()


def test_a_stop_withdraws_the_question(bench: Bench) -> None:
    answers(bench.questions, {})
    running = bench.start("confirm", question="Go on?")
    bench.advance(0.1)
    assert len(bench.questions.open) == 1

    running.stop()

    assert bench.questions.open == ()


def test_a_choice_is_returned_and_written_to_the_requested_property(bench: Bench) -> None:
    answers(bench.questions, {"How much": "2.5"})
    asks = {"question": "How much is it?", "options": ("1", "2.5")}

    assert bench.run("choose", **asks) == Success("2.5", {"answer": "2.5"})
    assert bench.run("choose", **asks, element="ball_1", property="sk:mass") == Success("2.5", {"answer": "2.5"})
    assert bench.world.value("ball_1", "sk:mass") == 2.5


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        ({"options": ("a",)}, "two or more"),
        ({"options": ("a", "a")}, "that differ"),
        ({"options": ("a", "b"), "element": "ball_1"}, "both together"),
        ({"options": ("a", "b"), "element": "ball_1", "property": "sk:masss"}, "no property 'sk:masss'"),
        ({"options": ("1", "b"), "element": "ball_1", "property": "sk:mass"}, "'b' cannot be written as sk:mass"),
    ],
)
def test_an_invalid_choice_question_is_not_asked(bench: Bench, arguments: dict[str, object], says: str) -> None:
    asked = answers(bench.questions, {})

    outcome = bench.run("choose", question="Which?", **arguments)

    assert isinstance(outcome, Failure)
    assert says in outcome.reason
    assert asked.asked == []


def test_parts_brought_by_a_person_are_the_missing_ones_and_the_others_count_as_not_yet_seen(bench: Bench) -> None:
    answers(bench.questions, {"Bring 1 x Ball to box A (box_a)": "done"})

    outcome = bench.run("refill", place="box_a", what="tiny:Ball")

    assert isinstance(outcome, Success)
    assert bench.world.related("ball_2", "sk:in", "box_a")
    assert (bench.world.value("ball_2", "sk:missing"), bench.world.value("ball_2", "sk:missedLooks")) == (None, None)
    assert (bench.world.value("ball_3", "sk:pose"), bench.world.value("ball_3", "sk:missedLooks")) == (None, None)


def test_parts_brought_in_excess_of_the_missing_ones_are_new(bench: Bench) -> None:
    answers(bench.questions, {"Bring": "done"})
    before = set(bench.world.subjects("sk:in", "box_a"))

    bench.run("refill", place="box_a", what="tiny:Ball", count=3)

    brought = set(bench.world.subjects("sk:in", "box_a")) - before
    assert len(brought) == 3
    assert "ball_2" in brought


def test_an_item_that_a_person_cannot_bring_changes_no_belief(bench: Bench) -> None:
    answers(bench.questions, {"Bring": "cannot"})
    before = bench.world.version

    outcome = bench.run("refill", place="box_a", what="tiny:Ball")

    assert isinstance(outcome, Failure)
    assert outcome.reason.startswith("a person cannot do this: Bring 1 x Ball")
    assert bench.world.version == before


def test_only_portable_items_can_be_requested_from_a_person(bench: Bench) -> None:
    answers(bench.questions, {"Bring": "done"})

    assert "no sk:Manipulatable" in bench.run("refill", place="box_a", what="tiny:Box").reason
    assert "count: one or more" in bench.run("refill", place="box_a", what="tiny:Ball", count=0).reason
