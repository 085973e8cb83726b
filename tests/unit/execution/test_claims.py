"""In whatever order devices are claimed: only sharing claims overlap, none starves, none stays taken."""

from __future__ import annotations

import pytest
from hypothesis import settings
from hypothesis import strategies as st
from hypothesis.stateful import RuleBasedStateMachine, invariant, precondition, rule

from skiros_py.errors import DescriptionError, UsageError
from skiros_py.execution.claims import Claim, Claims

DEVICES = ["arm", "base", "camera", "gripper"]


def test_a_module_claims_all_its_devices_or_none() -> None:
    claims = Claims()
    claims.request("wave", ["arm"])
    pick = claims.request("pick", ["arm", "gripper"])

    assert not pick.granted
    assert claims.request("open", ["camera"]).granted
    assert pick.waits_for() == ("arm (wave)",)


def test_a_later_claim_does_not_overtake_an_earlier_one_for_the_same_device() -> None:
    claims = Claims()
    wave = claims.request("wave", ["arm"])
    pick = claims.request("pick", ["arm", "gripper"])
    open_ = claims.request("open", ["gripper"])

    assert not open_.granted, "the gripper is free, but somebody older waits for it"
    wave.release()
    assert (pick.granted, open_.granted) == (True, False)
    pick.release()
    assert open_.granted


def test_a_claim_is_released_at_the_end_of_its_block_even_after_an_exception() -> None:
    claims = Claims()
    with pytest.raises(ZeroDivisionError), claims.request("pick", ["arm"]):
        raise ZeroDivisionError

    assert claims.request("wave", ["arm"]).granted


def test_a_cancelled_claim_request_is_skipped() -> None:
    claims = Claims()
    wave = claims.request("wave", ["arm"])
    claims.request("pick", ["arm"]).release()
    place = claims.request("place", ["arm"])

    wave.release()

    assert place.granted


def test_a_module_without_devices_never_waits() -> None:
    claims = Claims()
    claims.request("pick", DEVICES)

    assert claims.request("think", []).granted


def test_the_parts_of_a_skill_divide_the_devices_of_the_skill() -> None:
    claims = Claims()
    pick = claims.request("pick", ["arm", "gripper"])
    move = claims.request("move", ["arm"], within=pick)
    grip = claims.request("grip", ["gripper"], within=pick)
    wave = claims.request("wave", ["arm"], within=pick)

    assert (move.granted, grip.granted, wave.granted) == (True, True, False)
    move.release()
    assert wave.granted


def test_a_device_that_the_skill_has_not_declared_is_refused_with_what_to_declare() -> None:
    claims = Claims()
    pick = claims.request("pick", ["arm"])

    with pytest.raises(
        DescriptionError, match=r"grip needs gripper, but pick has arm: .* a hardware parameter of pick"
    ):
        claims.request("grip", ["arm", "gripper"], within=pick)


def test_a_waiting_or_ended_skill_has_no_devices_for_its_parts() -> None:
    claims = Claims()
    wave = claims.request("wave", ["arm"])
    pick = claims.request("pick", ["arm"])

    with pytest.raises(UsageError, match=r"move: pick itself has to wait for arm \(wave\)"):
        claims.request("move", ["arm"], within=pick)
    wave.release()
    with pytest.raises(UsageError, match="move: wave itself has given its devices back"):
        claims.request("move", ["arm"], within=wave)


def test_releasing_a_claim_releases_the_claims_of_its_parts() -> None:
    claims = Claims()
    pick = claims.request("pick", ["arm"])
    move, wave = (claims.request(name, ["arm"], within=pick) for name in ("move", "wave"))

    pick.release()

    assert (move.released, wave.released) == (True, True)
    assert (move.granted, wave.granted) == (False, False)


def test_shared_claims_hold_a_device_together_and_an_exclusive_claim_waits_for_all() -> None:
    claims = Claims()
    push, turn = (claims.request(name, ["base"], shared=["base"]) for name in ("push", "turn"))
    drive = claims.request("drive", ["base"])
    nudge = claims.request("nudge", ["base"], shared=["base"])

    assert (push.granted, turn.granted, drive.granted, nudge.granted) == (True, True, False, False)
    assert drive.waits_for() == ("base (push)",)
    assert nudge.waits_for() == ("base (drive)",)
    push.release()
    turn.release()
    assert (drive.granted, nudge.granted) == (True, False)
    drive.release()
    assert nudge.granted


def test_parts_may_share_an_exclusive_device_of_their_skill_but_not_claim_a_shared_one_exclusively() -> None:
    claims = Claims()
    dance = claims.request("dance", ["base"])
    parts = [claims.request(name, ["base"], shared=["base"], within=dance) for name in ("push", "turn")]
    assert [part.granted for part in parts] == [True, True]
    dance.release()

    sway = claims.request("sway", ["base"], shared=["base"])
    with pytest.raises(DescriptionError, match="drive takes base exclusively, but sway shares it"):
        claims.request("drive", ["base"], within=sway)


def excludes(one: Claim, other: Claim) -> bool:
    return not one.devices.isdisjoint(other.devices - (one.shared & other.shared))


class ClaimsMachine(RuleBasedStateMachine):
    """Modules of modules ask and end in any order."""

    def __init__(self) -> None:
        super().__init__()
        self.claims = Claims()
        self.alive: list[Claim] = []  # by age
        self.names = iter(range(10**6))

    @rule(devices=st.dictionaries(st.sampled_from(DEVICES), st.booleans()))
    def request(self, devices: dict[str, bool]) -> None:
        shared = [device for device, open_ in devices.items() if open_]
        self.alive.append(self.claims.request(f"module {next(self.names)}", devices, shared=shared))

    @precondition(lambda self: any(claim.granted for claim in self.alive))
    @rule(data=st.data())
    def request_within(self, data: st.DataObject) -> None:
        parent = data.draw(st.sampled_from([claim for claim in self.alive if claim.granted]))
        devices = {device for device in sorted(parent.devices) if data.draw(st.booleans())}
        shared = {device for device in sorted(devices) if device in parent.shared or data.draw(st.booleans())}
        self.alive.append(self.claims.request(f"part {next(self.names)}", devices, shared=shared, within=parent))

    @precondition(lambda self: self.alive)
    @rule(data=st.data())
    def release(self, data: st.DataObject) -> None:
        data.draw(st.sampled_from(self.alive)).release()
        self.alive = [claim for claim in self.alive if not claim.released]

    def levels(self) -> list[list[Claim]]:
        parents = {id(claim.parent): claim.parent for claim in self.alive}
        return [[claim for claim in self.alive if claim.parent is parent] for parent in parents.values()]

    @invariant()
    def no_device_has_two_owners_at_one_level_unless_they_share_it(self) -> None:
        for level in self.levels():
            granted = [claim for claim in level if claim.granted]
            assert not any(excludes(one, other) for one in granted for other in granted if one is not other)

    @invariant()
    def a_claim_is_granted_exactly_when_no_older_one_of_its_level_excludes_it(self) -> None:
        for level in self.levels():
            for age, claim in enumerate(level):
                assert claim.granted == (not any(excludes(claim, older) for older in level[:age]))
                assert claim.granted != bool(claim.waits_for())

    @invariant()
    def whoever_waits_waits_for_somebody_who_has_and_does_not_wait(self) -> None:
        for level in self.levels():
            assert any(claim.granted for claim in level)

    @invariant()
    def parts_have_only_what_their_module_has(self) -> None:
        for claim in self.alive:
            if claim.parent is not None:
                assert claim.parent.granted
                assert claim.devices <= claim.parent.devices
                assert claim.devices & claim.parent.shared <= claim.shared

    def teardown(self) -> None:
        for claim in self.alive:
            claim.release()
        assert self.claims.request("last", DEVICES).granted


TestClaimsMachine = ClaimsMachine.TestCase
TestClaimsMachine.settings = settings(max_examples=100, stateful_step_count=30, deadline=None)
