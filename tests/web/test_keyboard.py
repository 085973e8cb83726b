"""Who has no mouse: everything by keys, from a new part to the replay of how it was brought."""

from __future__ import annotations

from typing import TYPE_CHECKING

from .people import WORK, Person

if TYPE_CHECKING:
    from playwright.sync_api import Locator

MOST_TABS = 60
"""So often somebody presses the tab key for one thing, at most."""
READS = 60.0
"""How long somebody looks where the focus is before the next key [ms]."""
HAS_FOCUS = "element => element === document.activeElement || element.contains(document.activeElement)"


class Typist(Person):
    """Somebody who works by keyboard alone."""

    def keys(self, *presses: str) -> None:
        """Presses keys, one after the other."""
        for press in presses:
            self.page.keyboard.press(press)

    def go(self, to: Locator, by: str = "Tab") -> None:
        """Goes on by one key until something has the focus."""
        for _ in range(MOST_TABS):
            if to.count() and to.first.evaluate(HAS_FOCUS):
                return
            self.keys(by)
            self.page.wait_for_timeout(READS)
        self.expect(to).to_be_focused()

    def button(self, name: str) -> Locator:
        return self.page.get_by_role("button", name=name, exact=True)

    def push(self, name: str, by: str = "Tab") -> None:
        """Goes to a button and presses it."""
        self.go(self.button(name), by)
        self.keys("Enter")

    def pick(self, label: str, text: str, by: str = "Tab") -> None:
        """Goes to a field and takes the first of what it offers for a text."""
        self.go(self.page.get_by_role("combobox", name=label, exact=True), by)
        self.page.keyboard.type(text)
        self.expect(self.page.get_by_role("option").filter(has_text=text).first).to_be_visible()
        self.keys("ArrowDown", "Enter")

    def keeps_the_focus(self) -> None:
        """What was pressed, or what had the focus before that, still has it: the next key does not begin at the top."""
        self.page.wait_for_function("() => document.activeElement !== document.body")


def test_a_keyboard_only_user_adds_a_part_runs_stops_and_resets_a_job_and_replays_it(station, visit, expect):
    served = station()
    anna = Typist(visit(served.url), served.url, expect)
    expect(anna.page.get_by_text("connected", exact=True)).to_be_visible()
    adds_a_starter(anna)
    wants_it_in_the_kit(anna)
    has_it_brought_but_stops_on_the_way(anna)
    sees_it_again(anna)


def adds_a_starter(anna: Typist) -> None:
    anna.keys("Alt+4")
    rows = anna.page.get_by_role("treeitem")
    anna.go(rows)
    pallet = rows.filter(has_text="pallet_b")
    anna.go(pallet, by="ArrowDown")
    anna.keys("Enter")
    anna.expect(pallet).to_have_attribute("aria-selected", "true")
    anna.push("Add here")
    anna.expect(anna.page.get_by_role("dialog")).to_be_visible()
    anna.keys("Escape", "Escape")  # the list of the first field, then the dialog
    anna.expect(anna.page.get_by_role("dialog")).to_have_count(0)
    anna.expect(anna.button("Add here")).to_be_focused()
    anna.keys("Enter")
    anna.pick("What", "starter (kitting:Starter)")
    anna.go(anna.page.get_by_role("textbox", name="Name"))
    anna.page.keyboard.type("spare starter")
    anna.expect(anna.page.get_by_text("fits there")).to_be_visible()
    anna.keys("Enter")
    anna.expect(anna.page.get_by_role("dialog")).to_have_count(0)
    anna.expect(rows.filter(has_text="spare starter")).to_have_attribute("aria-selected", "true")
    anna.keeps_the_focus()


def wants_it_in_the_kit(anna: Typist) -> None:
    anna.keys("Alt+1")
    anna.pick("Add a condition …", "ObjectAtLocation")
    anna.pick("object of ObjectAtLocation", "spare starter", by="Shift+Tab")
    anna.pick("location of ObjectAtLocation", "compartment A")
    anna.push("Preview the plan")
    anna.expect(anna.page.get_by_role("list", name="Steps")).to_be_visible(timeout=WORK)
    anna.expect(anna.button("Preview the plan")).to_be_focused()


def has_it_brought_but_stops_on_the_way(anna: Typist) -> None:
    anna.push("Run")
    job = anna.page.get_by_role("region", name="Job", exact=True)
    anna.expect(job.get_by_text("running", exact=True)).to_be_visible(timeout=WORK)
    anna.keys("Control+Shift+Space")
    anna.expect(anna.page.get_by_text("The stop was obeyed.")).to_be_visible()
    anna.go(anna.button("Reset …"), by="Shift+Tab")
    anna.keys("Enter")
    anna.push("I have checked: reset")
    anna.expect(anna.page.get_by_text("Everything is halted")).to_have_count(0)
    anna.keeps_the_focus()
    anna.go(anna.asked("A job is held").get_by_role("button", name="Try again"))
    anna.keys("Enter")
    anna.sees_end("succeeded")
    anna.keeps_the_focus()


def sees_it_again(anna: Typist) -> None:
    anna.push("Show in Task", by="Shift+Tab")
    anna.push("Replay in 3D")
    slider = anna.page.get_by_role("slider", name="Time of the replay")
    anna.go(slider)
    before = float(slider.get_attribute("aria-valuenow") or 0)
    anna.keys("PageUp")
    anna.expect(slider).not_to_have_attribute("aria-valuenow", str(before))
    anna.push("Leave the replay", by="Shift+Tab")
    anna.expect(slider).to_have_count(0)
    anna.keeps_the_focus()
