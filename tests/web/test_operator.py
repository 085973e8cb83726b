"""What people do at the pages, start to end: what came of it is read from the simulator, not from the pages alone."""

from __future__ import annotations

import math
import re
import socket
from contextlib import closing
from pathlib import Path
from typing import TYPE_CHECKING, Any

import httpx2
import pytest
from support.server_process import ServerProcess

from .people import NEAR, WORK, Engineer, Person

if TYPE_CHECKING:
    from playwright.sync_api import Locator, Page

REFUSED = ("Failed to load resource",)
"""What the browser itself says of requests that are refused or reach nobody."""
ROUNDED = 1e-4
"""By so much times of frames may differ from those of changes [s]."""
SMALL = {"viewport": {"width": 1280, "height": 800}}


# ---------------------------------------------------------------------- an operator


@pytest.mark.physics
@pytest.mark.timeout(600)
def test_an_operator_gets_a_kit_filled_despite_faults(station, visit, expect):
    served = station("kitting_stock", physics=True, pace=5.0)
    anna = Person(visit(served.url, **SMALL), served.url, expect)
    anna.load("kitting")
    adds_a_spare_starter(anna)
    is_told_why_there_is_no_plan_and_takes_the_proposal(anna)
    first = anna.run_goal()
    stops_everything_while_the_robot_moves(anna, served)
    resets_and_has_the_job_go_on(anna)
    anna.sees_arrive("starter_2", "kit_1_a")
    is_asked_about_a_part_that_is_missing(anna)
    anna.sees_arrive("compressor_1", "kit_1_c")
    looks_at_a_past_job(anna, first)
    sees_again_what_the_robot_did(anna, first)


def adds_a_spare_starter(anna: Person) -> None:
    anna.add_part("starter (kitting:Starter)", "spare starter", "pallet_b")
    row = anna.page.get_by_role("treeitem").filter(has_text="spare starter")
    anna.expect(row).to_have_attribute("aria-selected", "true")
    anna.sees("starter_2", anna.body("pallet_b")["position"], 0.5)
    assert anna.body("starter_2")["place"] == "pallet_b"


def is_told_why_there_is_no_plan_and_takes_the_proposal(anna: Person) -> None:
    anna.want(starter_1="compartment A", starter_2="compartment A")
    anna.press("Preview the plan")
    plan = anna.page.get_by_role("region", name="Plan", exact=True)
    anna.expect(plan.get_by_text("There is no plan")).to_be_visible(timeout=WORK)
    anna.expect(plan.get_by_text("These exclude each other")).to_be_visible()
    anna.expect(plan.get_by_text("compartment A (kit_1_a) takes one starter only")).to_be_visible()
    anna.expect(plan.get_by_role("button", name=re.compile("^Do this: want ")).first).to_be_visible()
    plan.get_by_role("button", name=re.compile("^Leave it out: .*starter_1")).click()
    steps = plan.get_by_role("list", name="Steps").get_by_role("listitem")
    anna.expect(steps).to_have_count(4, timeout=WORK)
    anna.expect(steps.last).to_contain_text("puts spare starter (starter_2) into compartment A")


def stops_everything_while_the_robot_moves(anna: Person, served: Any) -> None:
    anna.expect(anna.page.get_by_text("moving: ")).to_be_visible(timeout=WORK)
    start = anna.drawn("robot_1")
    assert start is not None
    anna.sees_leave("robot_1", start)
    anna.press("Stop all")
    anna.expect(anna.page.get_by_role("alert").get_by_text("STOPPED", exact=True)).to_be_visible()
    anna.expect(anna.page.get_by_text("The stop was obeyed.")).to_be_visible()
    assert served.services.station.session.cycle.halted
    anna.expect(anna.page.get_by_text("robot not moving", exact=True)).to_be_visible()
    stands = anna.ask("/state")["platforms"]["base_1"]["position"]
    anna.sees("robot_1", stands, 0.01)
    anna.page.wait_for_timeout(500)
    assert math.dist(anna.ask("/state")["platforms"]["base_1"]["position"], stands) < 0.001


def resets_and_has_the_job_go_on(anna: Person) -> None:
    held = anna.asked("A job is held")
    anna.expect(held).to_be_visible()
    anna.press("Reset …")
    anna.press("I have checked: reset")
    anna.expect(anna.page.get_by_text("Everything is halted")).to_have_count(0)
    anna.press("Try again", held)
    anna.sees_end("succeeded")


def is_asked_about_a_part_that_is_missing(anna: Person) -> None:
    httpx2.delete(f"{anna.url}/api/v1/simulation/bodies/alternator_1").raise_for_status()  # somebody took it
    anna.want(alternator_1="compartment B", compressor_1="compartment C")
    anna.press("Options of the run")
    anna.page.get_by_role("checkbox", name="Ask a person before a condition is given up").check()
    anna.page.keyboard.press("Escape")
    anna.run_goal()
    question = anna.asked(re.compile(r"alternator_1\W+not found in\W+pallet A"))
    anna.expect(question).to_be_visible(timeout=WORK)
    anna.press("Skip", question)
    anna.expect(question).to_have_count(0)
    anna.sees_end("partially succeeded")
    ends = anna.page.get_by_role("list", name="Results of the conditions").get_by_role("listitem")
    lost = ends.filter(has_text="alternator_1 not found")
    anna.expect(lost.get_by_role("img", name="not reached:")).to_be_visible()
    anna.expect(ends.get_by_role("img", name="reached:", exact=True)).to_have_count(1)


def looks_at_a_past_job(anna: Person, job: str) -> None:
    anna.open("Task")
    anna.press("Jobs and sequences")
    jobs = anna.page.get_by_role("list", name="Jobs")
    jobs.get_by_role("listitem").filter(has_text=job).get_by_role("button").click()
    shown = anna.page.get_by_role("article", name=f"Job {job}")
    anna.expect(shown.get_by_role("button", name=re.compile("drive.*: cancelled, attempt 1"))).to_be_visible()
    anna.expect(shown.get_by_role("button", name=re.compile("drive.*: done, attempt 2"))).to_be_visible()
    anna.open("Report")
    report = shown.get_by_role("tabpanel", name="Report")
    for part in ("reached", "pallet B"):  # what came of the condition, and what was used for it
        row = report.get_by_role("row").filter(has_text="spare starter").filter(has_text="compartment A")
        anna.expect(row.filter(has_text=part)).to_have_count(1)


def sees_again_what_the_robot_did(anna: Person, job: str) -> None:
    now = anna.drawn("robot_1")
    assert now is not None
    anna.press("Replay in 3D")
    bar = anna.page.get_by_role("group", name=f"Replay of {job}")
    slider = bar.get_by_role("slider", name="Time of the replay")
    anna.sees("starter_2", anna.body("pallet_b")["position"], 0.5)
    for share in (0.3, 0.6, 0.15):
        drag(anna.page, slider, to=bar, share=share)
        then = base_in(anna.ask(f"/jobs/{job}/replay"), float(slider.get_attribute("aria-valuenow") or 0))
        anna.sees("robot_1", then, 0.005)
    anna.press("Leave the replay")
    anna.sees("robot_1", now, 0.005)
    anna.sees("starter_2", anna.body("starter_2")["position"], NEAR)


def drag(page: Page, slider: Locator, to: Locator, share: float) -> None:
    """Drags a slider to a share of the width of something."""
    thumb, room = slider.bounding_box(), to.bounding_box()
    assert thumb is not None
    assert room is not None
    middle = thumb["y"] + thumb["height"] / 2
    page.mouse.move(thumb["x"] + thumb["width"] / 2, middle)
    page.mouse.down()
    page.mouse.move(room["x"] + share * room["width"], middle, steps=5)
    page.mouse.up()


def base_in(replay: dict[str, Any], time: float) -> list[float]:
    """Where a replay has the robot at a moment [m]; while the job was held it stays where it was seen last."""
    times, base = replay["frames"]["times"], replay["frames"]["frames"]["base_1"]
    after = next((index for index, at in enumerate(times) if at > time), len(times) - 1)
    start, end = times[after - 1], times[after]
    share = min(1.0, (time - start) / (end - start)) if end > start else 1.0
    for change in replay["changes"]:
        went_on = change["time"] - ROUNDED
        if change["whole"] and start < went_on <= end:
            share = float(time >= went_on)
    return [start + share * (end - start) for start, end in zip(base[after - 1][:2], base[after][:2], strict=True)]


def test_a_goal_argument_is_chosen_by_a_click_in_the_picture(station, visit, expect):
    served = station()
    anna = Person(visit(served.url, **SMALL), served.url, expect)
    anna.open("World")
    anna.choose_in_tree("kit_1")
    anna.press("Look at the selection (f)")
    anna.open("Goal")
    goal = anna.page.get_by_role("region", name="Conditions of the goal")
    anna.choose("Add a condition …", "ObjectAtLocation", goal)
    goal.get_by_role("button", name=re.compile("^location of ObjectAtLocation: Pick")).click()
    awaited = anna.page.get_by_text(re.compile("^Click on: "))
    expect(awaited).to_be_visible()
    anna.clicks_on("kit_1_b")
    expect(awaited).to_have_count(0)
    gap = goal.get_by_role("combobox", name="location of ObjectAtLocation", exact=True)
    expect(gap).to_have_value("compartment B (kit_1_b)")


def test_clicking_an_element_in_the_picture_selects_it_in_the_tree(station, visit, expect):
    served = station()
    anna = Person(visit(served.url, at="#/world", **SMALL), served.url, expect)
    anna.clicks_on("rack_1")
    row = anna.page.get_by_role("treeitem").filter(has_text="rack_1")
    expect(row).to_have_attribute("aria-selected", "true")
    expect(anna.page.get_by_role("button", name="Shift in 3D")).to_be_visible()


# ---------------------------------------------------------------------- an engineer


@pytest.mark.physics
@pytest.mark.timeout(300)
def test_an_engineer_teaches_a_grasp_by_jogging_and_the_robot_picks_with_it(station, visit, expect):
    served = station("kitting", physics=True, pace=5.0)
    ben = Engineer(visit(served.url, at="#/modules", **SMALL), served.url, expect)
    ben.run_module("drive", Location="pallet A")
    ben.run_module("locate", place="pallet A", part="starter_1")
    ben.run_module("register_part", part="starter_1")
    ben.jogs_over("starter_1", height=GRASP)
    ben.teaches_a_grasp("starter_1")
    ben.goes_home()
    ben.run_module("pick", Object="starter_1")
    assert ben.body("starter_1")["place"] == "gripper_1"
    above = ben.tool()[2] - ben.body("starter_1")["position"][2]
    assert above == pytest.approx(taught_height(ben), abs=0.004)
    assert abs(above - USUAL_GRASP) > 0.004, "it was held as the class of the part says, not as taught"


GRASP = 0.042
"""How far above the foot of a starter the engineer has it grasped [m]."""
USUAL_GRASP = 0.032
"""How far above it robots grasp that were taught nothing [m]."""


def taught_height(ben: Engineer) -> float:
    (lesson,) = ben.ask("/learned")["items"]
    assert lesson["about"] == "kitting:Starter"
    return float(lesson["properties"]["sk:graspPose"]["position"][2])


# ---------------------------------------------------------------------- two people, a template, a restart


def test_a_concurrent_edit_shows_both_versions_and_overwrites_nothing(station, visit, expect):
    served = station()
    anna, ben = (Person(visit(served.url, at="#/world", expected=REFUSED), served.url, expect) for _ in range(2))
    for person in (anna, ben):
        person.page.keyboard.press("Alt+0")  # without the 3D view: nobody looks at it
        person.choose_in_tree("starter_1")
        person.press("Edit")
    anna.rename("starter of Anna")
    expect(anna.page.get_by_role("treeitem").filter(has_text="starter of Anna")).to_be_visible()
    ben.rename("starter of Ben")
    conflict = ben.page.get_by_role("dialog", name="Changed meanwhile")
    names = conflict.get_by_role("row").filter(has_text="starter of Anna")
    expect(names).to_contain_text("starter of Ben")
    expect(names).to_contain_text("both changed")
    assert anna.ask("/elements/starter_1")["label"] == "starter of Anna"
    ben.press("Take theirs", conflict)
    expect(ben.page.get_by_role("heading", name="starter of Anna")).to_be_visible()
    assert anna.ask("/elements/starter_1")["label"] == "starter of Anna"


KITTING = {
    "description": "Each part into its compartment.",
    "parameters": [{"name": "kit", "class": "Kit"}],
    "per_material": {"condition": "ObjectAtLocation", "arguments": [{"material": "class"}, {"material": "location"}]},
}


def test_an_operator_fills_a_kit_with_a_template(station, visit, expect):
    served = station(pace=20.0)
    httpx2.put(f"{served.url}/api/v1/documents/template/fill a kit", json={"data": KITTING}).raise_for_status()
    anna = Person(visit(served.url), served.url, expect)
    page = anna.page
    anna.choose("Template", "fill a kit", page.get_by_role("main"))
    form = page.get_by_role("region", name="Template “fill a kit”")
    anna.choose("kit", "kit", form)
    anna.press("Rows for 4 places", form)
    for row, part in enumerate(("starter", "alternator", "compressor", "relay box"), start=1):
        anna.choose(f"Part, row {row}", part, form)
    expect(form.get_by_role("list").get_by_role("listitem")).to_have_count(4)
    anna.run_goal()
    anna.sees_end("succeeded")
    kit = ("kit_1_a", "kit_1_b", "kit_1_c", "kit_1_d")
    parts = [[child["id"] for child in anna.ask(f"/tree?root={place}")["children"]] for place in kit]
    assert parts[0] == ["starter_1"]
    assert [len(one) for one in parts] == [1, 1, 1, 1]


def free_port() -> int:
    with closing(socket.socket()) as listening:
        listening.bind(("127.0.0.1", 0))
        return int(listening.getsockname()[1])


def test_the_pages_recover_after_the_server_is_killed_and_restarted(visit, expect, data: Path):
    port = free_port()
    with ServerProcess("kitting", "--fake", data=data, port=port) as first:
        anna = Person(visit(first.url, at="#/world", expected=REFUSED), first.url, expect)
        anna.add_part("starter (kitting:Starter)", "spare starter", "pallet_b")
        first.kill()
        expect(anna.page.get_by_text("Connection lost")).to_be_visible()
    with ServerProcess("--fake", "--pace", "20", data=data, port=port):
        expect(anna.page.get_by_text("Connection lost")).to_have_count(0, timeout=WORK)
        expect(anna.page.get_by_role("treeitem").filter(has_text="spare starter")).to_be_visible()
        anna.want(starter_2="compartment A")
        anna.run_goal()
        anna.sees_end("succeeded")
        expect(anna.page.get_by_text("Already holds")).to_be_visible()
