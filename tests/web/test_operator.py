"""What people do at the pages, start to end: what came of it is read from the simulator, not from the pages alone."""

from __future__ import annotations

import math
import re
import socket
from contextlib import closing
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import httpx2
import pytest

from skiros_py.testing.server_process import ServerProcess

if TYPE_CHECKING:
    from playwright.sync_api import Locator, Page

REFUSED = ("Failed to load resource",)
"""What the browser itself says of requests that are refused or reach nobody."""
WORK = 120_000
"""How long robots may work on something [ms]."""
NEAR = 0.1
"""A part that is nearer to the middle of a compartment lies in it [m]."""
SMALL = {"viewport": {"width": 1280, "height": 800}}


@dataclass
class Person:
    """Somebody at a page."""

    page: Page
    url: str
    expect: Any

    # ------------------------------------------------------------------ what people do everywhere

    def open(self, *tabs: str) -> None:
        """Opens a tab, and one in it."""
        for tab in tabs:
            self.page.get_by_role("tab", name=tab, exact=True).click()

    def press(self, name: str, within: Locator | None = None) -> None:
        """Presses a button."""
        (within or self.page).get_by_role("button", name=name, exact=True).click()

    def choose(self, label: str, text: str, within: Locator) -> None:
        """Types a part of a name into a field and takes what is offered."""
        field = within.get_by_role("combobox", name=label, exact=True)
        field.click()
        field.fill(text)
        self.page.get_by_role("option").filter(has_text=text).first.click()

    def choose_in_tree(self, thing: str) -> Locator:
        """Chooses something in the tree of the World tab."""
        row = self.page.get_by_role("treeitem").filter(has_text=thing).first
        row.click()
        self.expect(row).to_have_attribute("aria-selected", "true")
        return row

    # ------------------------------------------------------------------ World

    def load(self, scene: str) -> None:
        self.open("World", "Scenes")
        self.press(f"Load {scene}")
        self.press("Load", self.page.get_by_role("dialog", name=f"Load {scene}"))
        self.expect(self.page.get_by_role("heading", level=1)).to_have_text(scene, timeout=WORK)

    def add_part(self, class_: str, name: str, place: str) -> None:
        self.open("World", "Scene")
        self.choose_in_tree(place)
        self.press("Add here")
        dialog = self.page.get_by_role("dialog", name="Add", exact=True)
        self.choose("What", class_, dialog)
        dialog.get_by_role("textbox", name="Name").fill(name)
        self.expect(dialog.get_by_text("fits there")).to_be_visible()
        self.press("Add", dialog)
        self.expect(dialog).to_have_count(0)

    def rename(self, name: str) -> None:
        """Gives what is selected another name; the form is open."""
        form = self.page.get_by_role("form", name=re.compile("^Edit "))
        form.get_by_role("textbox", name="Name").fill(name)
        self.press("Save", form)

    # ------------------------------------------------------------------ Goal

    def want(self, **places: str) -> None:
        """Says anew what shall lie where."""
        self.open("Goal")
        goal = self.page.get_by_role("region", name="What shall be so")
        forget = goal.get_by_role("button", name="Remove all conditions")
        if forget.is_enabled():
            forget.click()
        for index, (part, place) in enumerate(places.items()):
            self.choose("Add a condition …", "ObjectAtLocation", goal)
            row = goal.get_by_role("listitem").nth(index)
            self.choose("object of ObjectAtLocation", part, row)
            self.choose("location of ObjectAtLocation", place, row)

    def run_goal(self) -> str:
        """Orders a job; returns its id."""
        panel = self.page.get_by_role("region", name="Job", exact=True)
        before = panel.get_by_role("heading").inner_text() if panel.count() else ""
        self.press("Run")
        self.expect(panel.get_by_role("heading")).not_to_have_text(before)
        return panel.get_by_role("heading").inner_text().removeprefix("Job ")

    def sees_end(self, outcome: str) -> None:
        job = self.page.get_by_role("region", name="Job", exact=True)
        self.expect(job.get_by_text(outcome, exact=True).first).to_be_visible(timeout=WORK)

    # ------------------------------------------------------------------ Modules

    def run_module(self, name: str, **arguments: str) -> None:
        """Tries a module and sees it succeed."""
        self.open("Modules", "Try modules")
        self.page.get_by_role("textbox", name="Search modules").fill(name)
        modules = self.page.get_by_role("navigation", name="Modules")
        modules.get_by_role("button", name=re.compile(rf"^{name}\b")).first.click()
        form = self.page.get_by_role("region", name="Arguments")
        for key, value in arguments.items():
            self.choose(key, value, form)
        self.expect(self.page.get_by_role("region", name="Conditions").get_by_text("ready to run")).to_be_visible()
        self.press("Run")
        run = self.page.get_by_role("region", name=re.compile(f"^Run of {name}")).first
        self.expect(run.get_by_text("succeeded", exact=True)).to_be_visible(timeout=WORK)

    # ------------------------------------------------------------------ what is drawn, and what is true

    def drawn(self, thing: str) -> list[float] | None:
        """Where something is drawn in the 3D view [m]."""
        pose = self.page.evaluate("id => window.skiros3d?.pose(id) ?? null", thing)
        return pose and pose[:3]

    def sees(self, thing: str, at: list[float], within: float) -> None:
        """Waits until something is drawn at a point, at most so far from it [m]."""
        near = """([id, x, y, far]) => {
            const pose = window.skiros3d?.pose(id);
            return Boolean(pose) && Math.hypot(pose[0] - x, pose[1] - y) <= far;
        }"""
        self.page.wait_for_function(near, arg=[thing, *at[:2], within])

    def ask(self, path: str) -> Any:
        """What the server says of something."""
        return httpx2.get(f"{self.url}/api/v1{path}", timeout=30).raise_for_status().json()

    def body(self, thing: str) -> dict[str, Any]:
        """Where something really is."""
        (body,) = (one for one in self.ask("/simulation/bodies")["items"] if one["id"] == thing)
        return body

    def sees_arrive(self, part: str, compartment: str) -> None:
        """Sees a part in its compartment, where it truly is."""
        body = self.body(part)
        assert body["place"] == compartment
        assert math.dist(body["position"][:2], self.body(compartment)["position"][:2]) < NEAR
        self.sees(part, body["position"], NEAR)


# ---------------------------------------------------------------------- an operator


@pytest.mark.physics
@pytest.mark.timeout(400)
def test_an_operator_has_parts_put_into_a_kit_and_copes_with_all_that_goes_wrong(station, visit, expect):
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
    anna.expect(plan.get_by_text("exclude each other: kit_1_a takes one starter only")).to_be_visible()
    anna.press("Leave it out: give up ObjectAtLocation(starter_1, kit_1_a)", plan)
    steps = plan.get_by_role("list", name="Steps").get_by_role("listitem")
    anna.expect(steps).to_have_count(4, timeout=WORK)
    anna.expect(steps.last).to_contain_text("puts spare starter (starter_2) into compartment A")


def stops_everything_while_the_robot_moves(anna: Person, served: Any) -> None:
    anna.expect(anna.page.get_by_text("moving: ")).to_be_visible(timeout=WORK)
    start = anna.drawn("robot_1")
    anna.page.wait_for_function("([x, y]) => Math.hypot(skiros3d.pose('robot_1')[0] - x, skiros3d.pose('robot_1')[1] - y) > 0.3",
                                arg=start[:2], timeout=WORK)
    anna.press("Stop all")
    anna.expect(anna.page.get_by_role("alert").get_by_text("STOPPED", exact=True)).to_be_visible()
    anna.expect(anna.page.get_by_text("The stop was obeyed.")).to_be_visible()
    assert served.services.session.cycle.halted
    anna.expect(anna.page.get_by_text("robot stands", exact=True)).to_be_visible()
    stands = anna.ask("/state")["bases"]["base_1"]["pose"]["position"]
    anna.sees("robot_1", stands, 0.01)
    anna.page.wait_for_timeout(500)
    assert math.dist(anna.ask("/state")["bases"]["base_1"]["pose"]["position"], stands) < 0.001


def resets_and_has_the_job_go_on(anna: Person) -> None:
    held = anna.page.get_by_role("alert").filter(has_text="A job is held")
    anna.expect(held).to_be_visible()
    anna.press("Reset …")
    anna.press("I have looked: reset")
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
    question = anna.page.get_by_role("alert").filter(has_text="alternator_1 not found in pallet_a")
    anna.expect(question).to_be_visible(timeout=WORK)
    anna.press("Skip", question)
    anna.expect(question).to_have_count(0)
    anna.sees_end("partially succeeded")
    ends = anna.page.get_by_role("list", name="What came of the conditions").get_by_role("listitem")
    lost = ends.filter(has_text="ObjectAtLocation(alternator_1, kit_1_b)")
    anna.expect(lost.get_by_role("img", name="not reached:")).to_be_visible()
    anna.expect(ends.get_by_role("img", name="reached:", exact=True)).to_have_count(1)


def looks_at_a_past_job(anna: Person, job: str) -> None:
    anna.open("Task")
    anna.press("Jobs and sequences")
    jobs = anna.page.get_by_role("list", name="Jobs")
    jobs.get_by_role("listitem").filter(has_text=job).get_by_role("button").click()
    shown = anna.page.get_by_role("article", name=f"Job {job}")
    anna.expect(shown.get_by_role("button", name="drive pallet_b: broken off, attempt 1")).to_be_visible()
    anna.expect(shown.get_by_role("button", name="drive pallet_b: done, attempt 2")).to_be_visible()
    anna.open("Report")
    report = shown.get_by_role("tabpanel", name="Report")
    anna.expect(report.get_by_role("row").filter(has_text="spare starter")).to_contain_text("compartment A")
    anna.expect(report.get_by_text("reached", exact=True)).to_be_visible()


def sees_again_what_the_robot_did(anna: Person, job: str) -> None:
    now = anna.drawn("robot_1")
    anna.press("Replay in 3D")
    bar = anna.page.get_by_role("group", name=f"Replay of {job}")
    slider = bar.get_by_role("slider", name="Time of the replay")
    anna.sees("starter_2", anna.body("pallet_b")["position"], 0.5)
    for share in (0.3, 0.6, 0.15):
        drag(anna.page, slider, to=bar, share=share)
        then = base_in(anna.ask(f"/jobs/{job}/replay")["frames"], float(slider.get_attribute("aria-valuenow") or 0))
        anna.sees("robot_1", then, 0.005)
    anna.press("Leave the replay")
    anna.sees("robot_1", now, 0.005)
    anna.sees("starter_2", anna.body("starter_2")["position"], NEAR)


def drag(page: Page, slider: Locator, to: Locator, share: float) -> None:
    """Drags a slider to a share of the width of something."""
    thumb, room = slider.bounding_box(), to.bounding_box()
    assert thumb is not None and room is not None
    middle = thumb["y"] + thumb["height"] / 2
    page.mouse.move(thumb["x"] + thumb["width"] / 2, middle)
    page.mouse.down()
    page.mouse.move(room["x"] + share * room["width"], middle, steps=5)
    page.mouse.up()


def base_in(frames: dict[str, Any], time: float) -> list[float]:
    """Where a replay has the robot at a moment [m]."""
    times, base = frames["times"], frames["bases"]["base_1"]
    after = next((index for index, at in enumerate(times) if at > time), len(times) - 1)
    span = times[after] - times[after - 1]
    share = min(1.0, (time - times[after - 1]) / span) if span > 0 else 1.0
    return [start + share * (end - start) for start, end in zip(base[after - 1][:2], base[after][:2], strict=True)]


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
SIZES = (100, 20, 5)
"""Steps of the tool [mm]."""


def taught_height(ben: Engineer) -> float:
    (lesson,) = ben.ask("/learned")["items"]
    assert lesson["about"] == "kitting:Starter"
    return float(lesson["properties"]["sk:graspPose"]["position"][2])


class Engineer(Person):
    """Somebody who moves a robot by hand."""

    def tool(self) -> list[float]:
        """Where the tool is [m], as the page says it, too."""
        position: list[float] = self.ask("/state")["arms"]["arm_1"]["tool"]["position"]
        return position

    def jog(self, name: str) -> None:
        """Presses a button once and waits until the robot has done it."""
        bar = self.page.get_by_role("region", name="Moving by hand")
        self.press(name)
        self.expect(bar.get_by_text("moving", exact=True)).to_have_count(0, timeout=WORK)
        self.expect(bar.get_by_text("done", exact=True)).to_be_visible()

    def sets(self, what: str, size: str) -> None:
        self.page.get_by_role("radiogroup", name=what, exact=True).last.get_by_text(size, exact=True).click()

    def jogs_over(self, part: str, height: float) -> None:
        """Turns the tool across a part and brings it there."""
        self.open("Jog and teach")
        self.sets("Axes of", "Map")
        self.choose("May touch", part, self.page.get_by_role("main"))
        for size, times in (("20°", 4), ("10°", 1)):
            self.sets("Turn", size)
            for _ in range(times):
                self.jog("Turn tool about +z")
        (seen,) = (one for one in self.ask("/view")["elements"] if one["id"] == part)
        x, y, z = seen["pose"]["position"]
        for axis, goal in enumerate((x, y, z + height)):
            self.jogs_along(axis, goal)

    def jogs_along(self, axis: int, goal: float) -> None:
        """Moves the tool along an axis of the map to a coordinate [m], by ever smaller steps."""
        for size in SIZES:
            way = 1000 * (goal - self.tool()[axis])
            steps = round(abs(way) / size) if size == SIZES[-1] else int(abs(way) / size)
            if steps:
                self.sets("Step", f"{size} mm")
            for _ in range(steps):
                self.jog(f"Tool {'+' if way > 0 else '−'}{'xyz'[axis]}")

    def teaches_a_grasp(self, part: str) -> None:
        self.press("Gripper gripper_1")
        self.jog("Close")
        self.page.get_by_role("button", name="Teach here").first.click()
        self.choose("part", part, self.page.get_by_role("group", name="Arguments"))
        self.page.get_by_role("button", name="Teach here").last.click()
        self.expect(self.page.get_by_text("grasp for Starter")).to_be_visible()

    def goes_home(self) -> None:
        self.jog("Open")
        self.sets("Step", "100 mm")
        self.jog("Tool +z")
        self.jog("Arms home")


# ---------------------------------------------------------------------- two people, a template, a restart


def test_who_edits_what_somebody_else_has_just_changed_sees_theirs_against_mine_and_overwrites_nothing(
    station, visit, expect
):
    served = station()
    anna, ben = (Person(visit(served.url, at="#/world", expected=REFUSED), served.url, expect) for _ in range(2))
    for person in (anna, ben):
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


def test_a_template_fills_a_kit(station, visit, expect):
    served = station(pace=20.0)
    httpx2.put(f"{served.url}/api/v1/goal-templates/fill a kit", json=KITTING).raise_for_status()
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


def test_the_pages_work_on_when_the_server_was_killed_and_started_anew(visit, expect, data: Path):
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
        expect(anna.page.get_by_text("Is so already")).to_be_visible()
