"""The Devices view shows devices and signals by what their kinds say, and sets what people may set."""

from __future__ import annotations

import math
import os
import re
from collections.abc import Callable
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import pytest
from integration.test_outside_devices import CUBE, LAB, LINK, ONTOLOGY, install_cell, install_devices

from skiros_py.catalogue.loading import load_catalogue
from skiros_py.ports.board import DeviceBoard, DeviceHandle
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


# ---------------------------------------------------------------------- kinds of an outside distribution

SEEN = """<visual><origin xyz="0 0 0.05"/><geometry><box size="0.3 0.2 0.1"/></geometry></visual>"""
PLATE = """
lab:Turntable sk:solid '[{"kind": "box", "size": [0.9, 0.5, 0.05], "at": [0, 0, -0.025]}]'^^rdf:JSON .
"""


def test_devices_of_outside_kinds_are_drawn_where_their_frames_and_joints_are(site, tmp_path, station, visit, expect):
    install_devices(site)
    install_cell(site, LINK.replace("<inertial>", SEEN + "<inertial>"), ONTOLOGY + CUBE + PLATE)
    scene = tmp_path / "lab.ttl"
    scene.write_text(LAB, encoding="utf-8")
    served = station(str(scene))
    anna = Person(visit(served.url, "#/world"), served.url, expect)
    until(anna, lambda: joints(anna, "robot_1") != {} != joints(anna, "plate_1") and anna.drawn("robot_1") is not None)

    moves_the_devices(served.services.station)

    until(anna, lambda: turned(anna, "robot_1") > math.pi / 4.0 - 0.01)
    assert anna.drawn("robot_1") == pytest.approx([0.0, 0.75, 0.0], abs=0.02)
    assert anna.drawn("cube_1") == pytest.approx([2.0, 0.3, 0.52], abs=0.01)
    assert turned(anna, "plate_1") == pytest.approx(math.pi / 2.0, abs=0.02)
    assert turned(anna, "robot_1") == pytest.approx(math.pi / 4.0, abs=0.02)
    assert [joints(anna, "robot_1")[name] for name in "abc"] == pytest.approx([0.1, 0.2, 0.3], abs=0.01)
    assert joints(anna, "plate_1")["turn"] == pytest.approx(math.pi / 2.0, abs=0.02)  # its own model, from its URDF
    if folder := os.environ.get("SKIROS_WEB_PICTURES"):
        anna.page.screenshot(path=f"{folder}/outside_devices.png")


def moves_the_devices(station: Any) -> None:
    """Drives the base aside, turns it and the turntable, and bends the fingers."""

    def start(session: Any) -> Any:
        return session.cycle.start(moving(session.cycle.board), "moving")

    station.control.call(start)


def moving(board: DeviceBoard) -> Any:
    lab = pytest.importorskip("lab_devices")
    base, plate, hand = (DeviceHandle(board, id_) for id_ in ("base_1", "plate_1", "hand_1"))
    for cycle in range(200):  # 1 s
        turn = math.pi / 2.0 if cycle >= 100 else 0.0
        base.command(lab.OmniTwist(0.0, 0.0 if turn else 1.5, turn))
        plate.command(lab.TableTarget(math.pi / 2.0))
        hand.command(lab.HandTarget((0.1, 0.2, 0.3)))
        yield


def until(anna: Person, so: Callable[[], bool]) -> None:
    """Waits for what the page draws."""
    for _ in range(300):
        if so():
            return
        anna.page.wait_for_timeout(100)
    pytest.fail("it is not drawn so within 30 s")


def joints(anna: Person, model: str) -> dict[str, float]:
    """Returns the positions of the joints in a drawn model, by name."""
    found: dict[str, float] = anna.page.evaluate("id => window.skiros3d?.joints(id) ?? {}", model)
    return found


def turned(anna: Person, thing: str) -> float:
    """About which angle something is drawn turned [rad]."""
    *_, z, w = anna.page.evaluate("id => window.skiros3d.pose(id)", thing)
    return 2.0 * math.atan2(z, w)
