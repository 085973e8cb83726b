"""Every run has an id, a parent and a path: loops and twin branches can be told apart."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, ClassVar

import pytest

from skiros_py.behaviours import (
    Behaviour,
    Do,
    ForEach,
    Guard,
    Out,
    P,
    Parallel,
    Policy,
    Repeat,
    Scope,
    Sequence,
    Wait,
)
from skiros_py.errors import DescriptionError, UnknownName
from skiros_py.execution.monitor import ModuleEvent, Status
from skiros_py.skills.outcome import BROKEN, Failure, Outcome, Success
from skiros_py.skills.parameters import Output, param
from skiros_py.skills.primitive import Execution, Primitive
from skiros_py.skills.skill import Skill, SkillDescription
from skiros_py.testing import Bench, tiny_world
from skiros_py.testing.tiny import AT_LOCATION, DRIVE, pretend

TO_A = {"Base": "base_1", "Robot": "robot_1", "Location": "box_a"}
NOTED: list[Any] = []


class Note(Primitive[Any]):
    """Keeps what it is given, and gives it back."""

    name: ClassVar[str] = "note"
    outputs: ClassVar[tuple[Output, ...]] = (
        Output("text", "text", "What it was given."),
        Output("pose", "pose", "Where it was; never known."),
    )

    @dataclass(frozen=True, slots=True)
    class Params:
        text: str = param("text", "What to keep.", default="")

    def execute(self) -> Execution[Outcome]:
        NOTED.append(self.params.text)
        self.emit("noted", {"text": self.params.text})
        yield
        return Success(values={"text": self.params.text + "!"})


class CallsTwice(Primitive[Any]):
    """Calls a module twice at the same time."""

    name: ClassVar[str] = "calls_twice"

    @dataclass(frozen=True, slots=True)
    class Params:
        """It takes none."""

    def execute(self) -> Execution[Outcome]:
        yield from self.join(self.call("note", text="a"), self.call("note", text="b"))
        return Success()


def skill(body: Behaviour, **more: Any) -> Skill:
    return Skill(DRIVE, body, driver="fake", **more)


def run(body: Behaviour, *others: Skill, nodes: bool = False) -> tuple[Outcome, list[ModuleEvent]]:
    NOTED.clear()
    with Bench(tiny_world(), (skill(body), *others), (Note, CallsTwice)) as bench:
        heard: list[ModuleEvent] = []
        bench.monitor.subscribe(heard.append, nodes=nodes)
        outcome = bench.run("drive", **TO_A)
    return outcome, heard


def started(events: list[ModuleEvent], module: str = "note") -> list[ModuleEvent]:
    return [event for event in events if event.module == module and event.status is Status.STARTED]


def test_branches_and_loop_rounds_of_one_module_have_distinct_paths_and_ids() -> None:
    body = Parallel.of(Repeat(Do.of("note", text="left"), 3), Do.of("note", text="right"), policy=Policy.ALL)

    _, events = run(body)
    notes = started(events)

    left, right = "drive/body/0/0", "drive/body/1"
    assert [event.path for event in notes] == [left, right, left, left]
    assert len({event.id for event in notes}) == 4
    ends = {event.id: event.status for event in events if event.module == "note"}
    assert set(ends) == {event.id for event in notes}
    assert set(ends.values()) == {Status.TERMINATED}


def test_the_parent_of_an_event_is_the_enclosing_run() -> None:
    _, events = run(Sequence.of(Do.of("calls_twice"), Wait(0.01)), nodes=True)
    by_id = {event.id: event for event in events if event.status is Status.STARTED}
    note = started(events)[0]

    line = [note]
    while line[-1].parent in by_id:
        line.append(by_id[line[-1].parent])

    assert [(one.kind, one.path) for one in line] == [
        ("primitive", "drive/body/0/note"),
        ("primitive", "drive/body/0"),
        ("node", "drive/body/0"),
        ("node", "drive/body"),
        ("skill", "drive"),
    ]
    assert line[-1].parent == ""


def test_a_called_skill_continues_the_path_of_the_node_that_calls_it() -> None:
    inner = Skill(
        SkillDescription("inner", "Notes.", "Base", "Location", DRIVE.params, post=(AT_LOCATION("Robot", "Location"),)),
        Do.of("note", text="deep"),
        driver="fake",
    )
    _, events = run(Sequence.of(Do.of("inner", Location=P("Location"))), inner)

    assert [event.path for event in started(events)] == ["drive/body/0/body"]


def test_node_events_are_reported_only_on_request() -> None:
    body = Sequence.of(Do.of("note"), Wait(0.01))

    told, untold = run(body, nodes=True)[1], run(body)[1]

    paths = [(event.path, event.status) for event in told if event.kind == "node" and event.event == ""]
    assert paths == [
        ("drive/body", Status.STARTED),
        ("drive/body/0", Status.STARTED),
        ("drive/body/0", Status.TERMINATED),
        ("drive/body/1", Status.STARTED),
        ("drive/body/1", Status.TERMINATED),
        ("drive/body", Status.TERMINATED),
    ]
    assert all(event.kind != "node" or event.event for event in untold)


def test_an_event_carries_its_name_value_and_run() -> None:
    _, events = run(Do.of("note", text="x"))

    (event,) = (event for event in events if event.event == "noted")
    assert (event.status, event.value, event.path) == (Status.EVENT, {"text": "x"}, "drive/body")
    assert event.id == started(events)[0].id


# ---------------------------------------------------------------------- values


def test_later_nodes_read_the_values_of_an_outcome() -> None:
    run(Sequence.of(Do.of("note", text=Out("seen")), Do.of("note", text=P("seen"))))

    assert NOTED == ["", "!"]


def test_reading_a_value_before_it_is_written_fails_and_names_it() -> None:
    outcome, _ = run(Sequence.of(Do.of("note", text=P("seen")), Do.of("note", text=Out("seen"))))

    assert outcome == Failure("note: no node has written 'seen' yet")


def test_reading_a_missing_value_of_an_outcome_fails_and_lists_its_values() -> None:
    outcome, _ = run(Do.of("note", pose=Out("seen")))

    assert outcome == Failure("note gave no value 'pose': its outcome has text")


class Gossip(Note):
    """Gives more than it declares."""

    name: ClassVar[str] = "gossip"
    outputs: ClassVar[tuple[Output, ...]] = (Output("pose", "pose", "Where it was."),)


def test_an_outcome_with_a_value_that_its_primitive_does_not_declare_is_a_failure_that_names_it() -> None:
    with Bench(tiny_world(), (skill(Do.of("gossip", text="x")),), (Gossip,)) as bench:
        outcome = bench.run("drive", **TO_A)

    assert isinstance(outcome, Failure)
    assert outcome.code == BROKEN
    assert "unknown output 'text'" in outcome.reason


class Weigh(Note):
    """Gives what its parameter says, as several outputs."""

    name: ClassVar[str] = "weigh"
    outputs: ClassVar[tuple[Output, ...]] = (
        Output("mass", "number", "What it weighs.", "kg"),
        Output("place", "tiny:Box", "What it stands in."),
    )
    found: ClassVar[Any] = None

    def execute(self) -> Execution[Outcome]:
        yield
        return Success(values=self.found)


@pytest.mark.parametrize(
    ("found", "said"),
    [
        ({"mass": "far"}, "output mass takes a finite number [kg], not 'far'"),
        ({"mass": float("nan")}, "output mass takes a finite number [kg], not nan"),
        ({"mass": object()}, "output mass takes a finite number [kg], not <object"),
        ({"place": "box_99"}, "unknown element 'box_99' for output place, a tiny:Box"),
        ({"place": "robot_1"}, "output place takes a tiny:Box, and robot_1 is a"),
        ({"mass": "0.4"}, "output mass takes a finite number [kg], not '0.4'"),
        ({"mass": None}, "output mass takes a finite number [kg], not None"),
        ({"place": None}, "output place takes a tiny:Box, not None"),
        ([1.0], "the values of its outcome are given by name, not as [1.0]"),
    ],
)
def test_an_output_of_another_type_than_declared_is_a_failure_that_names_it(found: Any, said: str) -> None:
    primitive = type("Bad", (Weigh,), {"found": found})

    with Bench(tiny_world(), (skill(Do.of("weigh", text="x")),), (primitive,)) as bench:
        outcome = bench.run("drive", **TO_A)

    assert isinstance(outcome, Failure)
    assert outcome.code == BROKEN
    assert said in outcome.reason


def test_an_output_of_a_class_that_no_ontology_declares_keeps_the_primitive_from_loading() -> None:
    primitive = type("Bad", (Weigh,), {"outputs": (Output("place", "tiny:Bocks", "Where."),)})

    with Bench(tiny_world(), (skill(Do.of("weigh", text="x")),), (primitive,)) as bench:
        outcome = bench.run("drive", **TO_A)

    assert isinstance(outcome, Failure)
    assert "weigh did not load: UnknownName: unknown class 'tiny:Bocks'" in outcome.reason


@pytest.mark.parametrize(
    ("outputs", "said"),
    [
        ((Output("pose", "poses", "Where."),), "unknown type 'poses'"),
        ((Output("mass", "number", "How heavy.", "kgs"),), "'kgs' is no unit such as m"),
        ((Output("mass", None, "How heavy."),), "parameter 'mass' of the outputs of primitive Wrong: its name, help"),
        ((Output("mass", "number", "How heavy.", 5),), "parameter 'mass' of the outputs of primitive Wrong: its name"),
        (
            (Output(3, "number", "How heavy."),),
            "parameter 3 of the outputs of primitive Wrong: its name, help and unit",
        ),
        ((Output("a", "text", "A."), Output("a", "text", "B.")), "two parameters of the outputs of primitive Wrong"),
        ([Output("a", "text", "A.")], "outputs of primitive Wrong: a tuple"),
    ],
)
def test_wrongly_declared_outputs_are_refused_and_name_the_class(outputs: Any, said: str) -> None:
    with pytest.raises((DescriptionError, UnknownName), match=said):
        type("Wrong", (Note,), {"outputs": outputs})


def test_reading_a_name_that_no_node_writes_is_refused_when_the_body_is_defined() -> None:
    with pytest.raises(UnknownName, match="seen"):
        skill(Do.of("note", text=P("seen")))


def test_a_value_cannot_overwrite_a_parameter() -> None:
    with pytest.raises(DescriptionError, match=r"Out\('Robot'\)"):
        skill(Do.of("note", text=Out("Robot")))


# ---------------------------------------------------------------------- a behaviour from outside


@dataclass(frozen=True, slots=True)
class Nonsense(Behaviour):
    """Returns what is no outcome."""

    kind: ClassVar[str] = "nonsense"

    @property
    def title(self) -> str:
        return "nonsense"

    def run(self, scope: Scope) -> Execution[Outcome]:
        yield
        return scope.path  # type: ignore[return-value]


def test_a_node_that_returns_no_outcome_is_a_failure_that_names_its_path() -> None:
    outcome, _ = run(Sequence.of(Nonsense()))

    assert isinstance(outcome, Failure)
    assert "node drive/body/0 returned 'drive/body/0'" in outcome.reason


@dataclass(frozen=True, slots=True)
class Either(Behaviour):
    """Runs one of two named children, by turns."""

    kind: ClassVar[str] = "either"

    left: Behaviour
    right: Behaviour

    @property
    def title(self) -> str:
        return "either"

    def named_children(self) -> Mapping[str, Behaviour]:
        return {"left": self.left, "right": self.right}

    def run(self, scope: Scope) -> Execution[Outcome]:
        yield from scope.run(self.left, "left")
        return (yield from scope.run(self.right, "right"))


def test_a_plug_in_behaviour_runs_and_is_observed_like_any_other() -> None:
    body = Guard.of(Either(Do.of("note", text="1"), ForEach("box", "tiny:Box", Do.of("note", text=P("box")))),
                    ~AT_LOCATION("Robot", "Location"))  # fmt: skip

    _, events = run(body)

    assert NOTED == ["1", "box_a", "box_b"]
    assert {event.path for event in started(events)} == {"drive/body/0/left", "drive/body/0/right/0"}


# ---------------------------------------------------------------------- a breakpoint


def test_a_task_pauses_before_a_node_with_a_breakpoint_and_continues_after_resume() -> None:
    NOTED.clear()
    body = Sequence.of(Do.of("note", text="before"), Do.of("note", text="behind"))
    with Bench(tiny_world(), (skill(body), pretend(DRIVE)), (Note, CallsTwice)) as bench:
        running = bench.managers["base_1"].start("drive", TO_A)
        running.scope.breakpoints.add("drive/body/1")
        for _ in range(200):
            bench.cycle.step()
        held = list(NOTED), running.status
        running.resume()
        for _ in range(200):
            bench.cycle.step()

    assert held == (["before"], "paused")
    assert NOTED == ["before", "behind"]


# ---------------------------------------------------------------------- tasks and steps


def test_the_parent_of_a_run_is_its_step_whose_parent_is_the_task() -> None:
    with Bench(tiny_world()) as bench:
        report = bench.pursue("In(ball_1, slot_1)")
        runs = [event for event in bench.events if event.kind == "skill" and event.status is Status.STARTED]

    assert report.reached
    assert [run.parent for run in runs] == [f"{runs[0].task}#{number}" for number in range(1, len(runs) + 1)]
