"""A scene of many things in the pages: what an operator does with it, and how long until it is seen."""

from __future__ import annotations

import math

import httpx2
from playwright.sync_api import Browser, Page
from rest_server import Server
from web_browser import cost_of, new_page, ready

__all__ = ["large_scene"]

_AT_ONCE = 100
_TRIES = 5
_ROW = "[role=treeitem]"


def large_scene(browser: Browser, server: Server, pages: str, objects: int) -> dict[str, list[float]]:
    """Returns how long each interaction takes, try by try [ms].

    Args:
        browser: The browser.
        server: A server with the kitting scene on a pretending robot.
        pages: Address of its pages.
        objects: How many parts are added, side by side on the floor.
    """
    _fill(server, objects)
    page = new_page(browser)
    page.goto(f"{pages}#/world")
    ready(page)
    page.wait_for_function(f"() => window.skiros3d.shown().length >= {objects}")
    page.get_by_role("tree").get_by_role("treeitem").first.wait_for()
    costs = {
        "opening a branch of the tree": [_branch(page) for _ in range(_TRIES)],
        "selecting in the tree": [_select(page, f"starter_{number}") for number in range(11, 11 + _TRIES)],
        "selecting in 3D": [_click(page, f"starter_{number}") for number in range(41, 41 + _TRIES)],
        "turning the 3D view": [_turn(page) for _ in range(_TRIES)],
        "searching": [_search(page, f"starter_{number}") for number in (1234, 987, 1501, 432, 777)],
    }
    page.context.close()
    return costs


def _fill(server: Server, objects: int) -> None:
    """Adds parts in rows beside each other; the pretending robot does not mind them."""
    side = math.ceil(math.sqrt(objects))
    operations = [
        {
            "op": "add",
            "class": "kitting:Starter",
            "placement": {"relation": "sk:on", "place": "floor"},
            "properties": {
                "sk:pose": {
                    "position": [-1.5 + 6.0 * (number % side) / side, -2.5 + 5.0 * (number // side) / side, 0.0],
                    "orientation": [0.0, 0.0, 0.0, 1.0],
                }
            },
        }
        for number in range(objects)
    ]
    with httpx2.Client(base_url=server.url, timeout=60.0) as client:
        for first in range(0, objects, _AT_ONCE):
            body = {"operations": operations[first : first + _AT_ONCE]}
            client.post("/world/transactions", json=body).raise_for_status()


def _row(name: str) -> str:
    return f"[...document.querySelectorAll('{_ROW}')].find((row) => row.textContent.includes('{name}'))"


def _branch(page: Page) -> float:
    """Closes and opens the branch that has all of them."""
    rows = f"document.querySelectorAll('{_ROW}').length"
    floor = _row("floor")
    key = "new KeyboardEvent('keydown', {{ key: '{0}', code: '{0}', bubbles: true }})"
    page.evaluate(f"{floor}.focus()")
    page.evaluate(f"document.activeElement.dispatchEvent({key.format('ArrowLeft')})")
    page.wait_for_function(f"() => {floor}.getAttribute('aria-expanded') === 'false'")
    cost = cost_of(
        page,
        f"document.activeElement.dispatchEvent({key.format('ArrowRight')})",
        f"{floor}.getAttribute('aria-expanded') === 'true' && {rows} > 10",
    )
    page.wait_for_timeout(200.0)
    return cost


def _select(page: Page, name: str) -> float:
    """Clicks on a row of the tree, until its details are there and it is selected."""
    page.get_by_role("tree").evaluate("(tree) => tree.parentElement.scrollTo(0, 0)")
    page.wait_for_timeout(200.0)
    rows = page.get_by_role("treeitem").filter(has_text="starter")
    row = rows.nth(int(name.rsplit("_", 1)[-1]) % rows.count())
    row.evaluate("(row) => row.setAttribute('data-asked', '')")
    cost = cost_of(
        page,
        "document.querySelector('[data-asked]').click()",
        "document.querySelector('[data-asked]').getAttribute('aria-selected') === 'true'",
    )
    row.evaluate("(row) => row.removeAttribute('data-asked')")
    page.wait_for_timeout(200.0)
    return cost


def _click(page: Page, name: str) -> float:
    """Clicks on a thing in 3D, until the tree shows it selected."""
    spot = f"window.skiros3d.screen('{name}')"
    act = f"""
      const spot = {spot}, canvas = document.querySelector("canvas");
      for (const type of ["pointermove", "pointerdown", "pointerup", "click"])
        canvas.dispatchEvent(new PointerEvent(type, {{
          clientX: spot.x, clientY: spot.y, bubbles: true, button: 0, pointerId: 1, isPrimary: true, pointerType: "mouse",
        }}))
    """
    selected = f"document.querySelector('{_ROW}[aria-selected=true]')"
    page.evaluate(f"() => {{ window.before = {selected}?.textContent ?? '' }}")
    cost = cost_of(page, act, f"({selected}?.textContent ?? window.before) !== window.before")
    page.wait_for_timeout(200.0)
    return cost


def _turn(page: Page) -> float:
    """Turns the view by a key, until the next picture is there."""
    page.locator("canvas").evaluate("(canvas) => canvas.closest('[tabindex]').focus()")
    page.evaluate("() => { window.framesBefore = window.skiros3d.frames }")
    key = "new KeyboardEvent('keydown', { key: 'ArrowLeft', code: 'ArrowLeft', bubbles: true })"
    cost = cost_of(
        page, f"document.activeElement.dispatchEvent({key})", "window.skiros3d.frames > window.framesBefore"
    )
    page.wait_for_timeout(300.0)
    return cost


def _search(page: Page, name: str) -> float:
    """Searches for a thing by its id, until it is listed."""
    box = page.get_by_label("Search by name, id or class").first
    box.fill("")
    page.wait_for_timeout(400.0)
    box.evaluate("(box) => box.setAttribute('data-asked', '')")
    act = f"""
      const box = document.querySelector("input[data-asked]");
      Object.getOwnPropertyDescriptor(HTMLInputElement.prototype, "value").set.call(box, "{name}");
      box.dispatchEvent(new Event("input", {{ bubbles: true }}))
    """
    cost = cost_of(page, act, f"document.body.innerText.includes('{name}')")
    box.fill("")
    return cost
