"""People at the pages: what they do there, by the names and roles that anybody finds."""

from __future__ import annotations

import math
import re
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import httpx2

if TYPE_CHECKING:
    from playwright.sync_api import Locator, Page

WORK = 120_000
"""How long robots may work on something [ms]."""
NEAR = 0.1
"""A part that is nearer to the middle of a compartment lies in it [m]."""
GLANCE = 300
"""How long people look before they click at what may move [ms]."""
PLUS, MINUS = "+", "\N{MINUS SIGN}"
SIZES = (100, 20, 5)
"""Steps of the tool [mm]."""

_FAR = "(at => at ? Math.hypot(at[0] - one.x, at[1] - one.y) : NaN)(window.skiros3d?.pose(one.id))"
"""How far from a point something is drawn, as the page says it; NaN for what is nowhere."""


def _asked(thing: str, at: list[float], far: float) -> dict[str, Any]:
    return {"id": thing, "x": at[0], "y": at[1], "far": far}


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
        if field.is_editable():
            field.fill(text)
        self.page.get_by_role("option").filter(has_text=text).first.click()

    def asked(self, about: str | re.Pattern[str]) -> Locator:
        """What stands at the top of the page and waits for an answer."""
        top = self.page.get_by_role("region", name="Messages that need attention")
        return top.get_by_role("alert").filter(has_text=about)

    def choose_in_tree(self, thing: str) -> Locator:
        """Chooses something in the tree of the World tab."""
        row = self.page.get_by_role("treeitem").filter(has_text=thing).first
        row.click()
        if (
            row.get_attribute("aria-selected") != "true"
        ):  # the tree was read again, and the row went away below the mouse
            row.click()
        self.expect(row).to_have_attribute("aria-selected", "true")
        return row

    # ------------------------------------------------------------------ World

    def load(self, scene: str) -> None:
        self.open("World", "Scenes")
        self.press(f"Load {scene}")
        dialog = self.page.get_by_role("dialog", name=f"Load {scene}")
        self.press("Load", dialog)
        self.expect(dialog).to_have_count(0, timeout=WORK)
        self.expect(self.page.get_by_role("heading", level=1)).to_have_text(scene)

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
        goal = self.page.get_by_role("region", name="Conditions of the goal")
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

    def clicks_on(self, thing: str) -> None:
        """Clicks on something in the 3D view, as soon as that stands."""
        spot, before = self._spot(thing), None
        while spot is None or spot != before:
            self.page.wait_for_timeout(GLANCE)
            spot, before = self._spot(thing), spot
        self.page.mouse.click(spot["x"], spot["y"])

    def _spot(self, thing: str) -> dict[str, float] | None:
        spot: dict[str, float] | None = self.page.evaluate("id => window.skiros3d?.screen(id) ?? null", thing)
        return spot

    def sees(self, thing: str, at: list[float], within: float) -> None:
        """Waits until something is drawn at a point, at most so far from it [m]."""
        self.page.wait_for_function(f"one => {_FAR} <= one.far", arg=_asked(thing, at, within), timeout=WORK)

    def sees_leave(self, thing: str, at: list[float], beyond: float = 0.3) -> None:
        """Waits until something is drawn farther than that from a point [m]."""
        self.page.wait_for_function(f"one => {_FAR} > one.far", arg=_asked(thing, at, beyond), timeout=WORK)

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


def yaw(pose: dict[str, list[float]]) -> float:
    """Returns the heading of a pose [deg]."""
    x, y, z, w = pose["orientation"]
    return math.degrees(math.atan2(2.0 * (w * z + x * y), 1.0 - 2.0 * (y * y + z * z)))


class Engineer(Person):
    """Somebody who moves a robot by hand."""

    def tool(self) -> list[float]:
        """Where the tool is [m], as the page says it, too."""
        position: list[float] = self.ask("/state")["frames"]["arm_1"]["position"]
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
        (seen,) = (one for one in self.ask("/view")["elements"] if one["id"] == part)
        frame = self.ask("/state")["frames"]["arm_1"]
        across = (yaw(seen["pose"]) - yaw(frame) + 90.0) % 180.0 - 90.0  # the fingers close across the part
        self.sets("Turn", "10°")
        for _ in range(round(abs(across) / 10.0)):
            self.jog(f"Turn tool about {PLUS if across > 0 else MINUS}z")
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
                self.jog(f"Tool {PLUS if way > 0 else MINUS}{'xyz'[axis]}")

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
