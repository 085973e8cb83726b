"""Who may write to the world: by name, with a reason, knowing what is, and where no reasoner objects."""

from __future__ import annotations

from pathlib import Path
from typing import ClassVar

import pytest

from skiros_py.errors import StaleVersion, UnknownName, UsageError, WorldError
from skiros_py.world.change import PropertyEdit, Writer
from skiros_py.world.element import Placement, Stamp
from skiros_py.world.ontology import Ontology
from skiros_py.world.reasoners.registry import Proposal, Reasoner, Reasoners
from skiros_py.world.scene.files import load_scene
from skiros_py.world.world import World


def weigh(world: World, mass: float, **how: object) -> None:
    with world.transaction("scale", "weighed", **how) as tx:  # type: ignore[arg-type]
        tx.set("starter_1", "sk:mass", mass)


# ------------------------------------------------------------ author and reason


@pytest.mark.parametrize("missing", ["", "  \n", None, 5])
def test_a_transaction_has_an_author_and_a_reason(world: World, missing: str) -> None:
    with pytest.raises(UsageError, match="needs its author: a text that says who writes"):
        world.transaction(missing, "because").__enter__()
    with pytest.raises(UsageError, match="needs its reason: a text that says why, in words for people"):
        world.transaction("me", missing).__enter__()

    weigh(world, 1.0)  # nothing is left open
    assert world.version == 2


def test_a_reason_that_is_too_long_is_cut_off(world: World) -> None:
    with world.transaction("me", "x" * 5000) as tx:
        tx.set("starter_1", "sk:mass", 1.0)

    assert world.changes[-1].reason == "x" * 1000 + "…"


# ------------------------------------------------------------ versions


def test_the_version_of_an_element_is_the_last_change_that_touched_it(world: World) -> None:
    world.clock = lambda: 3.5
    weigh(world, 1.0)

    assert world.stamp("starter_1") == Stamp(2, 3.5)
    assert world.stamp("relay_box_1").change == 1


def test_a_write_with_the_latest_version_is_accepted(world: World) -> None:
    weigh(world, 1.0)
    weigh(world, 2.0, expects={"starter_1": 2, "relay_box_1": 1, "": 2})

    assert world.value("starter_1", "sk:mass") == 2.0


def test_a_write_with_an_outdated_version_is_refused(world: World) -> None:
    weigh(world, 1.0)
    begun = False

    with (
        pytest.raises(StaleVersion) as caught,
        world.transaction("editor", "heavier", expects={"relay_box_1": 1, "starter_1": 1}),
    ):
        begun = True

    assert not begun
    assert str(caught.value) == "starter_1 is at version 2, and 1 was expected: it was changed since"
    assert world.version == 2


def test_changes_of_other_elements_do_not_change_a_version(world: World) -> None:
    weigh(world, 1.0)

    with world.transaction("editor", "lighter", expects={"relay_box_1": 1}) as tx:
        tx.set("relay_box_1", "sk:mass", 0.2)

    with pytest.raises(StaleVersion, match="the world is at version 3, and 1 was expected"):
        weigh(world, 2.0, expects={"": 1})


def test_a_relation_changes_the_version_of_both_ends_and_a_placement_only_that_of_the_moved_element(
    world: World,
) -> None:
    with world.transaction("test", "a frame") as tx:
        tx.relate("starter_1", "sk:poseFrame", "rack_1")
    with world.transaction("test", "a move") as tx:
        tx.place("relay_box_1", "sk:in", "pallet_b")

    versions = {name: world.stamp(name).change for name in ("starter_1", "rack_1", "relay_box_1", "pallet_b")}
    assert versions == {"starter_1": 2, "rack_1": 2, "relay_box_1": 3, "pallet_b": 1}


def test_expecting_a_version_of_a_removed_element_is_stale_and_of_a_missing_one_unknown(world: World) -> None:
    with world.transaction("operator", "broken") as tx:
        tx.remove("starter_1")

    with pytest.raises(StaleVersion, match="starter_1 is gone, and version 1 was expected"):
        weigh(world, 1.0, expects={"starter_1": 1})
    with pytest.raises(UnknownName, match=r"unknown element 'relay_box_9'\. Did you mean 'relay_box_"):
        weigh(world, 1.0, expects={"relay_box_9": 1})


def test_a_refused_change_consumes_no_id_and_no_version(world: World) -> None:
    place = Placement("sk:in", "pallet_a")

    def write_nonsense() -> None:
        with world.transaction("test", "in vain") as tx:
            tx.add("kitting:Starter", placement=place)
            tx.set("starter_1", "sk:mass", "heavy")

    with pytest.raises(WorldError, match="needs a finite number"):
        write_nonsense()

    with world.transaction("test", "again") as tx:
        assert tx.add("kitting:Starter", placement=place) == "starter_2"
    assert world.version == 2


# ------------------------------------------------------------ reasoners that object


class Careful(Reasoner):
    """Lets nobody but people make a starter heavier than a kilogram."""

    name = "careful"
    heard: ClassVar[list[Proposal]] = []

    def veto(self, proposal: Proposal) -> str | None:
        self.heard.append(proposal)
        heavy = float(str(proposal.after.value("starter_1", "sk:mass"))) > 1.0
        return "starters weigh less" if heavy and proposal.writer is not Writer.PERSON else None


class Strict(Reasoner):
    """Objects to everything once the scene is there."""

    name = "strict"

    def veto(self, proposal: Proposal) -> str | None:
        return "no" if proposal.before.has("starter_1") else None


@pytest.fixture
def careful(ontology: Ontology, root: Path) -> World:
    world = load_scene(ontology, root / "scenes" / "kitting.ttl", reasoners=Reasoners([Careful()]))
    Careful.heard.clear()
    return world


def test_a_reasoner_can_refuse_a_change(careful: World) -> None:
    with pytest.raises(WorldError) as caught:
        weigh(careful, 2.0)

    assert str(caught.value) == "transaction of scale (weighed) refused: careful: starters weigh less"
    assert (careful.version, careful.value("starter_1", "sk:mass")) == (1, 0.8)


def test_a_change_without_objections_of_the_reasoner_is_accepted(careful: World) -> None:
    weigh(careful, 0.9)
    weigh(careful, 2.0, writer=Writer.PERSON)

    assert careful.value("starter_1", "sk:mass") == 2.0


def test_a_reasoner_receives_the_world_before_and_after_the_change_and_its_edits(careful: World) -> None:
    weigh(careful, 0.9, writer=Writer.JOB)

    (heard,) = Careful.heard
    assert heard.before.value("starter_1", "sk:mass") == 0.8
    assert heard.after.value("starter_1", "sk:mass") == 0.9
    assert heard.edits == (PropertyEdit("starter_1", "sk:mass", None, 0.9),)
    assert (heard.author, heard.writer) == ("scale", Writer.JOB)


def test_a_reasoner_is_not_called_for_an_empty_change(careful: World) -> None:
    with careful.transaction("test", "nothing"):
        pass

    assert Careful.heard == []


def test_the_objections_of_all_reasoners_are_reported(ontology: Ontology, root: Path) -> None:
    world = load_scene(ontology, root / "scenes" / "kitting.ttl", reasoners=Reasoners([Careful(), Strict()]))

    with pytest.raises(WorldError, match="refused: careful: starters weigh less; strict: no"):
        weigh(world, 2.0)
