"""A reasoner that fails does so under its own name, and hurts nobody else."""

from __future__ import annotations

import sys
from collections.abc import Callable

import pytest

from skiros_py.errors import DescriptionError
from skiros_py.world.element import Placement
from skiros_py.world.ontology import Ontology
from skiros_py.world.reasoners.registry import Answer, Proposal, Reasoner, Reasoners
from skiros_py.world.reasoners.sizes import SizeReasoner
from skiros_py.world.view import WorldView
from skiros_py.world.world import World


def boom(*_: object) -> Answer:
    raise KeyError("boom")


def recursion(*_: object) -> Answer:
    return recursion()


def world_with(ontology: Ontology, answer: Callable[..., object]) -> World:
    class Bad(Reasoner):
        name = "bad"
        relations = frozenset({"sk:near"})

        def answer(self, view: WorldView, subject: str, relation: str, object_: str) -> Answer:
            return answer()  # type: ignore[return-value]

        def veto(self, proposal: Proposal) -> str | None:
            answer()
            return None

    world = World(ontology, reasoners=Reasoners([SizeReasoner(), Bad()]))
    with world.transaction("test", "two places") as tx:
        tx.add("sk:Floor", id="floor")
        tx.add("kitting:Pallet", id="pallet_a", placement=Placement("sk:on", "floor"))
    return world


@pytest.mark.parametrize(
    ("answer", "says"),
    [
        (boom, "reasoner 'bad' failed: KeyError: 'boom'"),
        (recursion, "reasoner 'bad' failed: RecursionError"),
        (lambda: sys.exit(4), "reasoner 'bad' failed: SystemExit: 4"),
        (lambda: None, "reasoner 'bad' must answer with an Answer, not with None"),
        (lambda: Answer("yes", "because"), "reasoner 'bad' must answer with an Answer, not with Answer"),  # type: ignore[arg-type]
    ],
)
def test_a_question_to_a_broken_reasoner_names_it(ontology: Ontology, answer: Callable[..., object], says: str) -> None:
    world = world_with(ontology, answer)

    with pytest.raises(DescriptionError, match=says.replace("(", r"\(")):
        world.related("floor", "sk:near", "pallet_a")


def test_a_reasoner_whose_veto_raises_does_not_prevent_writing(
    ontology: Ontology, caplog: pytest.LogCaptureFixture
) -> None:
    world = world_with(ontology, boom)

    assert world.has("pallet_a")
    assert "reasoner 'bad'" in caplog.text


def test_a_computed_relation_holds_only_within_its_declared_domain_and_range(world: World) -> None:
    from skiros_py.station.worlds import open_world

    kitting = open_world("kitting")

    answer = kitting.reasoners.answer(kitting, "alternator_1", "sk:fitsIn", "kit_table")

    assert (answer.holds, answer.reason) == (
        False,
        "sk:fitsIn is about a sk:Container, and kit_table is a kitting:Table",
    )
    containers = set(kitting.instances("sk:Container"))
    assert set(kitting.objects("alternator_1", "sk:fitsIn")) <= containers
