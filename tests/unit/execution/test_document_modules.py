"""Documents as modules: declared parameters and outputs, breakpoints."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar

import pytest

from skiros_py.behaviours.tree_document import Tree
from skiros_py.catalogue import load_catalogue
from skiros_py.errors import DocumentFault
from skiros_py.skills.outcome import Failure, Outcome, Success
from skiros_py.skills.parameters import Output, param
from skiros_py.skills.plain import Reader
from skiros_py.skills.primitive import Execution, Primitive
from skiros_py.skills.skill import RunnableDocument
from skiros_py.testing import Bench, tiny_world

READER = Reader(load_catalogue().behaviours)
DOUBLED: dict[str, Any] = {
    "parameters": [
        {"key": "Number", "type": "number", "help": "What is doubled."},
        {"key": "Factor", "type": "number", "help": "By how much.", "default": 2.0},
    ],
    "outputs": ["result"],
    "body": {
        "type": "do",
        "module": "multiply",
        "arguments": {"one": {"P": "Number"}, "other": {"P": "Factor"}, "product": {"Out": "result"}},
    },
}
PAUSES = {"type": "sequence", "children": [{"type": "wait", "seconds": 0.05}, {"type": "wait", "seconds": 0.05}]}


class Multiply(Primitive["Multiply.Params"]):
    """Multiplies two numbers."""

    name: ClassVar[str] = "multiply"
    outputs: ClassVar[tuple[Output, ...]] = (Output("product", "number", "One times the other.", "1"),)

    @dataclass(frozen=True, slots=True)
    class Params:
        one: float = param("number", "One.")
        other: float = param("number", "The other.")

    def execute(self) -> Execution[Outcome]:
        yield
        return Success("multiplied", {"product": self.params.one * self.params.other})


def bench_with(name: str, data: Any) -> Bench:
    kind = Tree()
    assert kind.check(data, READER) == ()
    behaviour, interface = kind.behaviour(data, READER), kind.interface(data)
    bench = Bench(tiny_world(), (), [Multiply])
    bench.runtime.managers.documents[name] = RunnableDocument(
        behaviour, 1, behaviour.title, interface.params, interface.outputs
    )
    return bench


def run(bench: Bench, name: str, **arguments: Any) -> Outcome:
    running = bench.managers["base_1"].start(name, arguments)
    bench.until(lambda: running.done)
    return running.result


def test_a_document_takes_declared_parameters_and_its_outcome_has_the_declared_outputs() -> None:
    with bench_with("tree:double", DOUBLED) as bench:
        outcome = run(bench, "tree:double", Number=3.0)
        threefold = run(bench, "tree:double", Number=3.0, Factor=3.0)

        assert isinstance(outcome, Success)
        assert isinstance(threefold, Success)
        assert (outcome.values["result"], threefold.values["result"]) == (6.0, 9.0)
        assert [p.key for p in bench.managers["base_1"].info("tree:double").params] == ["Number", "Factor"]


@pytest.mark.parametrize(
    ("arguments", "reason"),
    [
        ({}, "Number: not specified"),
        ({"Number": "many"}, "parameter Number takes"),
        ({"Number": 1.0, "Facto": 3.0}, "unknown parameter 'Facto'"),
    ],
)
def test_missing_or_invalid_parameters_fail_the_run(arguments: dict[str, Any], reason: str) -> None:
    with bench_with("tree:double", DOUBLED) as bench:
        outcome = run(bench, "tree:double", **arguments)

        assert isinstance(outcome, Failure)
        assert reason in outcome.reason


@pytest.mark.parametrize(
    ("change", "place"),
    [
        ({"outputs": ["other"]}, "outputs[0]"),
        ({"parameters": [{"key": "Number"}]}, "parameters[0]"),
        ({"parameters": [{"key": "Number", "type": "number", "help": "-", "step": 1}]}, "parameters[0]"),
        ({"extra": 1}, "extra"),
    ],
)
def test_a_fault_in_a_declaration_is_reported_with_its_place(change: dict[str, Any], place: str) -> None:
    (fault,) = Tree().check({**DOUBLED, **change}, READER)

    assert isinstance(fault, DocumentFault)
    assert fault.place == place


def test_a_run_pauses_before_a_node_with_a_breakpoint_and_continues_after_resume() -> None:
    with bench_with("tree:pauses", PAUSES) as bench:
        running = bench.managers["base_1"].start("tree:pauses", {})
        running.breakpoints.add("tree:pauses/body/1")
        bench.until(lambda: running.status == "paused")
        bench.advance(1.0)
        assert not running.done

        running.resume()
        bench.until(lambda: running.done)
        assert isinstance(running.result, Success)
