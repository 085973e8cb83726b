"""The Devices view shows devices and signals by what their kinds say, and sets what people may set."""

from __future__ import annotations

import os
import re
from dataclasses import replace
from typing import TYPE_CHECKING, Any

from skiros_py.catalogue.loading import load_catalogue
from skiros_py.ports.signals import Input, Signal

from .people import Person

if TYPE_CHECKING:
    from playwright.sync_api import Locator


def inputs(_cell: Any) -> list[Input]:
    return [Input(Signal("speed_limit", "m/s", help="Greatest speed that people allow."), 0.5)]


def with_a_speed_limit() -> Any:
    catalogue = load_catalogue()
    return replace(catalogue, signals={**catalogue.signals, "limits": inputs})


def test_devices_and_signals_are_shown_closed_opened_and_set(station, visit, expect, axe):
    served = station(catalogue=with_a_speed_limit())
    anna = Person(visit(served.url, "#/modules/devices"), served.url, expect)
    sees_what_each_device_offers(anna)
    closes_and_opens_the_gripper(anna)
    sets_the_speed_limit(anna)
    if folder := os.environ.get("SKIROS_WEB_PICTURES"):
        anna.page.screenshot(path=f"{folder}/devices.png")
    assert axe(anna.page) == []
    jogs_the_gripper(anna)


def device(anna: Person, name: str) -> Locator:
    return anna.page.get_by_role("region", name=name, exact=True)


def signal(anna: Person, name: str) -> Locator:
    return anna.page.get_by_role("listitem", name=name, exact=True)


def sees_what_each_device_offers(anna: Person) -> None:
    for name, kind in (
        ("base_1", "base"),
        ("localiser_1", "localiser"),
        ("arm_1", "arm"),
        ("gripper_1", "gripper"),
        ("camera_1", "camera"),
    ):
        anna.expect(device(anna, name).get_by_text(kind, exact=True)).to_be_visible()
    anna.expect(signal(anna, "gripper_1.gap")).to_contain_text("0.08 m")
    anna.expect(signal(anna, "base_1.x")).to_contain_text("in frame map")
    anna.expect(signal(anna, "gripper_1.gap").locator("path")).to_have_attribute("d", re.compile("L"))
    assert device(anna, "camera_1").get_by_role("button", name="Jog camera_1").count() == 0


def closes_and_opens_the_gripper(anna: Person) -> None:
    anna.press("Close gripper_1")
    anna.expect(device(anna, "gripper_1").get_by_text("closed", exact=True)).to_be_visible()
    assert anna.ask("/devices/gripper_1")["open"] is False
    anna.press("Open gripper_1")
    anna.expect(device(anna, "gripper_1").get_by_text("open", exact=True)).to_be_visible()


def sets_the_speed_limit(anna: Person) -> None:
    limit = signal(anna, "speed_limit")
    anna.expect(limit).to_contain_text("0.5 m/s")
    limit.get_by_role("textbox", name=re.compile("speed_limit")).fill("0.25")
    anna.press("Set speed_limit")
    anna.expect(limit).to_contain_text("0.25 m/s")


def jogs_the_gripper(anna: Person) -> None:
    anna.press("Jog gripper_1")
    anna.press("Gripper gripper_1")
    anna.press("Close")
    anna.expect(anna.page.get_by_text("done", exact=True)).to_be_visible()
    anna.open("Devices")
    anna.expect(signal(anna, "gripper_1.gap")).to_contain_text("0 m")
