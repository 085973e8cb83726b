"""What is wrong with what a document does is known before it runs, with the place."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar

import pytest

from skiros_py.behaviours import Behaviour, Do, Fallback, Guard, Out, P, Repeat, Retry, Sequence, Timeout, WaitUntil
from skiros_py.skills.lint.checking import faults_of_document
from skiros_py.skills.lint.rule import Known
from skiros_py.skills.outcome import Execution, Outcome, Success
from skiros_py.skills.parameters import Kind, Output, Param, param
from skiros_py.skills.primitive import Primitive
from skiros_py.skills.skill import RunnableDocument
from skiros_py.testing import tiny_ontology


class Weigh(Primitive[Any]):
    """Weighs."""

    name: ClassVar[str] = "weigh"
    outputs: ClassVar[tuple[Output, ...]] = (
        Output("mass", "number", "What it weighs.", "kg"),
        Output("way", "number", "How far it is.", "m"),
        Output("name", "text", "What it is called."),
        Output("ball", "tiny:Ball", "What was weighed."),
    )

    @dataclass(frozen=True, slots=True)
    class Params:
        gripper: str = param("sk:Gripper", "The gripper.", kind=Kind.HARDWARE)

    def execute(self) -> Execution[Outcome]:
        yield
        return Success("weighed", {"mass": 1.0, "way": 0.1, "name": "x", "ball": "ball_1"})


class Move(Primitive[Any]):
    """Moves."""

    name: ClassVar[str] = "move"

    @dataclass(frozen=True, slots=True)
    class Params:
        to: float = param("number", "Where to.", unit="m", limits=(0.0, 1.0))
        title: str = param("text", "A title.", default="")
        type: str = param("class", "A class.", default="tiny:Ball")
        box: str | None = param("tiny:Box", "A box.", kind=Kind.OPTIONAL)

    def execute(self) -> Execution[Outcome]:
        yield
        return Success("moved")


def document(behaviour: Behaviour, *outputs: str, params: tuple[Param, ...] = ()) -> RunnableDocument:
    return RunnableDocument(behaviour, 1, "", params, outputs)


WEIGHED = document(Do.of("weigh", mass=Out("mass"), way=Out("way")), "mass", "way")
TITLED = document(Do.of("move", to=0.5, title=P("Title")), params=(Param("Title", "text", "A title."),))


def found(root: Behaviour, **documents: RunnableDocument) -> list[tuple[str, str]]:
    named = {"weighed": WEIGHED, "titled": TITLED, "later": None, **documents}
    known = Known(tiny_ontology(), {"weigh": Weigh, "move": Move}, documents=named)
    params = (Param("Arm", "sk:Arm", "The arm."), Param("Way", "number", "How far.", unit="m"))
    return list(faults_of_document(root, params, known))


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        ({"to": "far"}, "'move': parameter to takes a finite number [m], not 'far'"),
        ({"to": 5}, "'move': parameter to takes a finite number [m], not 5: it must be between 0 and 1"),
        ({"to": 0.5, "title": 3}, "'move': parameter title takes a text, not 3"),
        ({"to": 0.5, "type": "tiny:Bal"}, "'move': unknown class 'tiny:Bal'"),
        ({"to": 0.5, "box": 3}, "'move': parameter box takes the id of a tiny:Box, not 3"),
        ({}, "primitive 'move' needs to"),
    ],
)
def test_a_constant_of_the_wrong_type_is_a_fault_at_its_node(arguments: Any, said: str) -> None:
    ((place, text),) = found(Sequence.of(Do.of("move", to=0.1), Do.of("move", **arguments)))

    assert place == "1"
    assert text.startswith(said)


@pytest.mark.parametrize(
    ("output", "argument", "said"),
    [
        ("mass", "to", "'move' takes number as to in m, and seen is in kg"),
        ("name", "to", "'move' takes number as to, and seen is a text"),
        ("ball", "to", "'move' takes number as to, and seen is a tiny:Ball"),
        ("ball", "box", "'move' takes a tiny:Box as box, and seen is a tiny:Ball: nothing is both"),
        ("mass", "box", "'move' takes a tiny:Box as box, and seen is not an element"),
        ("mass", "title", "'move' takes text as title, and seen is a number"),
    ],
)
def test_an_output_that_a_parameter_never_takes_is_a_fault_where_it_is_read(
    output: str, argument: str, said: str
) -> None:
    read = {"to": 0.5, argument: P("seen")}

    assert found(Sequence.of(Do.of("weigh", **{output: Out("seen")}), Do.of("move", **read))) == [("1", said)]


def test_the_type_of_an_output_of_a_document_is_that_of_the_value_it_writes() -> None:
    def read(output: str) -> list[tuple[str, str]]:
        return found(Sequence.of(Do.of("weighed", **{output: Out("x")}), Do.of("move", to=P("x"))))

    assert read("way") == []
    assert read("mass") == [("1", "'move' takes number as to in m, and x is in kg")]
    assert read("name") == [("0", "document 'weighed' has no output name; it has mass, way")]


def test_a_value_that_several_nodes_write_may_be_of_either_type() -> None:
    either = Fallback.of(Do.of("weigh", mass=Out("x")), Do.of("weigh", way=Out("x")))

    assert found(Sequence.of(either, Do.of("move", to=P("x")))) == []


def test_a_document_takes_the_parameters_that_it_declares_and_no_others() -> None:
    assert found(Do.of("titled", Title="x")) == []
    assert found(Do.of("titled", Title=3)) == [("", "'titled': parameter Title takes a text, not 3")]
    assert found(Do.of("titled", Titel="x")) == [("", "document 'titled' has no parameter Titel; did you mean Title?")]
    assert found(Do.of("titled")) == [("", "document 'titled' needs Title")]


@pytest.mark.parametrize(
    ("node", "place"),
    [
        (lambda *children: Sequence.of(*children), "0"),
        (lambda *children: Fallback.of(*children), "0"),
        (lambda *children: Timeout(Sequence.of(*children), 5.0), "0/0"),
        (lambda *children: Guard.of(Sequence.of(*children), "Way > 0"), "0/0"),
    ],
)
def test_a_value_that_only_a_later_node_writes_is_a_fault_where_it_is_read(node: Any, place: str) -> None:
    read, write = Do.of("move", to=P("x")), Do.of("weigh", way=Out("x"))

    assert found(node(read, write)) == [(place, "the call of 'move' reads 'x', which only a later node writes")]
    assert found(node(WaitUntil.of("x > 0.1"), write)) == [(place, "x > 0.1 reads 'x', which only a later node writes")]
    assert found(node(write, read)) == []


def test_in_a_loop_a_node_may_read_what_a_later_one_wrote_the_time_before() -> None:
    read, write = Do.of("move", to=P("x")), Do.of("weigh", way=Out("x"))

    assert found(Repeat(Fallback.of(read, write), times=2)) == []


def test_documents_that_call_each_other_without_end_are_faults_at_the_call() -> None:
    first = Sequence.of(Do.of("move", to=0.1), Do.of("second"))
    told = "second leads to calls in a circle, which never end: write loops with repeat or retry"

    assert found(first, first=document(first), second=document(Do.of("first"))) == [("1", told)]


@pytest.mark.parametrize(
    ("between", "place"),
    [
        (Fallback.of(Do.of("second"), Do.of("move", to=0.1)), "0"),
        (Fallback.of(Do.of("move", to=0.1), Do.of("second")), "1"),
        (Retry(Do.of("second"), times=2), "0"),
        (Timeout(Do.of("second"), 1.0), "0"),
    ],
)
def test_calls_in_a_circle_are_faults_whatever_lies_between(between: Any, place: str) -> None:
    told = "second leads to calls in a circle, which never end: write loops with repeat or retry"

    assert found(between, first=document(between), second=document(Do.of("first"))) == [(place, told)]
    assert found(between, first=document(between), second=document(Do.of("move", to=0.1))) == []


def test_a_signal_that_devices_of_another_kind_offer_is_a_fault() -> None:
    ((place, text),) = found(WaitUntil.of("Arm.gap < 0.1"))

    assert place == ""
    assert "no sk:Arm has a signal 'gap'; there is" in text
    assert found(WaitUntil.of("Arm.still")) == []


def test_a_call_of_a_document_that_cannot_run_now_is_not_checked() -> None:
    assert found(Do.of("later", anything=3, x=Out("x"))) == []
