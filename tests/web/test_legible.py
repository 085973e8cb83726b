"""What people read and touch: trees and timelines of jobs, controls for fingers, undo by keys."""

from __future__ import annotations

import re

import httpx2

GOAL = ["InKit(Starter, kit_1)", "InKit(Alternator, kit_1)", "ObjectAtLocation(RelayBox, kit_1_c)"]
FINGER = 44
"""Least size of a control for fingers [px]."""
_SIZES = """() => [...document.querySelectorAll('.react-flow__node-box [class*=title], svg[role=group] text')]
  .map((one) => one.getBoundingClientRect().width / one.offsetWidth * parseFloat(getComputedStyle(one).fontSize)
    || parseFloat(getComputedStyle(one).fontSize))"""
"""Sizes of the texts of a tree or timeline as drawn [px]."""
_SMALL = """(least) => [...document.querySelectorAll('main button:not(.mantine-Anchor-root)')]
  .map((one) => [one.getAttribute('aria-label') || one.textContent, one.getBoundingClientRect()])
  .filter(([, box]) => box.width > 0 && (box.width < least || box.height < least)).map(([name]) => name)"""


def test_tree_and_timeline_of_a_job_of_twelve_steps_are_readable_at_first(station, visit, expect):
    served = station(pace=1.0)
    with httpx2.Client(base_url=f"{served.url}/api/v1") as http:
        http.put("/jobs/three", json={"goal": GOAL}).raise_for_status()
    page = visit(served.url, at="#/task/three")
    bar = page.get_by_role(
        "button", name=re.compile("(drives to|takes .* from|puts .* into) .*: running, attempt 1")
    ).first
    expect(bar).to_be_visible()
    assert min(page.evaluate(_SIZES)) >= 11
    page.get_by_role("tab", name="Tree", exact=True).click()
    node = page.locator(".react-flow__node-box").filter(has_text="running").last
    expect(node).to_be_in_viewport(ratio=0.9)
    assert min(page.evaluate(_SIZES)) >= 11


def test_on_a_telephone_joints_are_told_apart_and_controls_have_room_for_fingers(station, visit, expect):
    phone = {"viewport": {"width": 390, "height": 844}, "has_touch": True, "is_mobile": True}
    page = visit(station().url, at="#/modules/jog", **phone)
    page.get_by_role("tab", name="Jog and teach").click()
    first, last = (page.get_by_role("group", name=f"panda_joint{number}") for number in (1, 7))
    for joint, name in ((first, "joint1"), (last, "joint7")):
        text = joint.get_by_text(name, exact=True)
        expect(text).to_be_visible()
        assert text.evaluate("one => one.scrollWidth <= one.clientWidth")
    assert page.evaluate(_SMALL, FINGER) == []
    assert page.evaluate("document.documentElement.scrollWidth") <= 390


def test_a_removed_element_comes_back_and_goes_again_by_keys(station, visit, expect):
    served = station()
    page = visit(served.url, at="#/world")
    row = page.get_by_role("treeitem").filter(has_text="starter_1")
    expect(row).to_be_visible()
    with httpx2.Client(base_url=f"{served.url}/api/v1") as http:
        http.delete("/elements/starter_1", headers={"If-Match": "*"}).raise_for_status()
    expect(row).to_have_count(0)
    expect(page.get_by_role("button", name="Undo change").first).to_be_enabled()
    page.keyboard.press("Control+z")
    expect(row).to_be_visible()
    expect(page.get_by_role("button", name="Redo what")).to_be_enabled()
    page.keyboard.press("Control+Shift+z")
    expect(row).to_have_count(0)


def test_a_robot_that_only_pretends_is_named_as_such(station, visit, expect):
    page = visit(station().url)
    expect(page.get_by_role("note").filter(has_text="Pretended, without physics")).to_be_visible()
    expect(page.get_by_text("robot not moving (pretended)")).to_be_visible()


def test_a_template_that_was_removed_comes_back_and_goes_again_by_keys(station, visit, expect):
    served = station()
    stored = f"{served.url}/api/v1/documents/template/fill"
    goal = [{"condition": "InKit", "arguments": ["Starter", "kit_1"]}]
    httpx2.put(stored, json={"data": {"goal": goal}}).raise_for_status()
    page = visit(served.url, at="#/goal")
    page.get_by_role("combobox", name="Template").click()
    page.get_by_role("option", name="fill").click()
    form = page.get_by_role("region", name="Template “fill”")
    form.get_by_role("button", name="Delete this template").click()
    page.get_by_role("dialog").get_by_role("button", name="Remove").click()
    expect(form).to_have_count(0)
    expect(page.get_by_role("dialog")).to_have_count(0)
    page.keyboard.press("Control+z")
    expect(form).to_be_visible()
    assert httpx2.get(stored).json()["data"]["goal"] == goal
    page.keyboard.press("Control+Shift+z")
    expect(form).to_have_count(0)
    assert httpx2.get(stored).status_code == 404
