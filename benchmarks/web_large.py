"""A scene of many elements in the pages: latencies of an operator's interactions."""

from __future__ import annotations

import math
import re

import httpx2
from playwright.sync_api import Browser, Locator, Page
from rest_server import Server
from web_browser import cost_of, new_page, ready

_AT_ONCE = 500
_TRIES = 7
_CLASSES = ("Starter", "Alternator", "Compressor", "RelayBox")
_PLACE = "pallet_a"
_TREE = "document.querySelector('[role=tree]')"
_SEARCH = "Search by name, id or class"
_NOWHERE = (400.0, 80.0)
"""A position without elements in the 3D view [px]."""
_SETTLED = 400.0
"""Idle time of the pages between two attempts [ms]."""


def large_scene(browser: Browser, server: Server, pages: str, objects: int) -> dict[str, list[float]]:
    """Returns the latency of each interaction, for each attempt [ms].

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
    _row(page, _PLACE).wait_for()
    page.wait_for_timeout(5 * _SETTLED)
    costs = {
        "opening a branch": [_branch(page) for _ in range(_TRIES)],
        "arrow key in the tree": [_arrow(page) for _ in range(_TRIES)],
        "selecting in the tree, until its details": [_select(page, number + 14) for number in range(_TRIES)],
        "selecting in 3D, until tree and details": [_click(page, f"starter_{41 + 7 * n}") for n in range(_TRIES)],
        "pointing at a thing in 3D": [_point(page, f"starter_{44 + 7 * n}") for n in range(_TRIES)],
        "turning the 3D view": [_turn(page) for _ in range(_TRIES)],
        "searching": [_search(page, f"starter_{123 + 31 * number}") for number in range(_TRIES)],
    }
    page.context.close()
    return costs


def _fill(server: Server, objects: int) -> None:
    """Adds parts in rows side by side, which the fake robot ignores."""
    side = math.ceil(math.sqrt(objects))
    operations = [
        {
            "op": "add",
            "class": f"kitting:{_CLASSES[number % len(_CLASSES)]}",
            "placement": {"relation": "sk:in", "place": _PLACE},
            "properties": {
                "sk:pose": {
                    "position": [-3.0 + 6.0 * (number % side) / side, -3.0 + 6.0 * (number // side) / side, 0.0],
                    "orientation": [0.0, 0.0, 0.0, 1.0],
                    "frame": None,
                }
            },
        }
        for number in range(objects)
    ]
    with httpx2.Client(base_url=server.url, timeout=120.0) as client:
        for first in range(0, objects, _AT_ONCE):
            body = {"reason": "many", "operations": operations[first : first + _AT_ONCE]}
            client.post("/world/transactions", json=body).raise_for_status()


def _row(page: Page, name: str) -> Locator:
    return page.get_by_role("treeitem").filter(has_text=name).first


def _branch(page: Page) -> float:
    """Expands the branch that contains all of them."""
    page.get_by_role("tree").evaluate("(tree) => tree.parentElement.scrollTo(0, 0)")
    _row(page, _PLACE).click()
    page.wait_for_timeout(_SETTLED)
    if _row(page, _PLACE).get_attribute("aria-expanded") == "true":
        page.keyboard.press("ArrowLeft")
    page.wait_for_timeout(_SETTLED)
    page.evaluate("() => void (window.heightBefore = document.querySelector('[role=tree]').clientHeight)")
    done = f"{_TREE}.clientHeight > window.heightBefore && document.querySelectorAll('[role=treeitem]').length > 20"
    return cost_of(page, "keydown", lambda: page.keyboard.press("ArrowRight"), done)


def _arrow(page: Page) -> float:
    """Goes to the next row."""
    page.wait_for_timeout(_SETTLED)
    page.evaluate("() => void (window.rowBefore = document.activeElement)")
    done = "document.activeElement !== window.rowBefore && document.activeElement.role === 'treeitem'"
    return cost_of(page, "keydown", lambda: page.keyboard.press("ArrowDown"), done)


def _marked(name: str) -> str:
    """Whether it is marked in the tree and its details are shown."""
    return f"""
      [...document.querySelectorAll("[role=treeitem][aria-selected=true]")].some(
        (row) => /{name}(?!\\d)/.test(row.textContent),
      ) &&
      document.querySelector("section[aria-label] table")?.closest("section").textContent.includes("{name}")
    """


def _select(page: Page, number: int) -> float:
    """Clicks on a row of the tree."""
    page.get_by_role("tree").evaluate("(tree) => tree.parentElement.scrollTo(0, 2000)")
    page.wait_for_timeout(_SETTLED)
    row = page.get_by_role("treeitem", name=re.compile("alternator_")).nth(number)
    name = re.search(r"alternator_\d+", row.text_content() or "")
    spot = row.bounding_box()
    if name is None or spot is None:
        raise LookupError("the tree has no such row")
    x, y = spot["x"] + 90.0, spot["y"] + 8.0
    page.mouse.move(x, y)
    page.wait_for_timeout(_SETTLED)
    return cost_of(page, "mousedown", lambda: page.mouse.click(x, y), _marked(name[0]), drawn=True)


def _spot(page: Page, name: str) -> tuple[float, float]:
    spot = page.evaluate(f"window.skiros3d.screen('{name}')")
    return spot["x"], spot["y"]


def _click(page: Page, name: str) -> float:
    """Clicks on an element in 3D."""
    x, y = _spot(page, name)
    page.mouse.move(x, y)
    page.wait_for_timeout(_SETTLED)
    return cost_of(page, "pointerdown", lambda: page.mouse.click(x, y), _marked(name), drawn=True)


def _point(page: Page, name: str) -> float:
    """Moves the pointer to an element, until it is drawn as hovered, with its label."""
    x, y = _spot(page, name)
    page.mouse.click(*_NOWHERE)
    page.wait_for_timeout(_SETTLED)
    done = "document.querySelector('[data-picture]').parentElement.innerText.includes('Starter')"
    return cost_of(page, "pointermove", lambda: page.mouse.move(x, y), done, drawn=True)


def _turn(page: Page) -> float:
    """Turns the view with a key."""
    page.get_by_role("application").focus()
    page.wait_for_timeout(_SETTLED)
    return cost_of(page, "keydown", lambda: page.keyboard.press("ArrowLeft"), "true", drawn=True)


def _search(page: Page, name: str) -> float:
    """Searches for an id, until only that element is listed."""
    box = page.get_by_label(_SEARCH).first
    box.fill("")
    page.wait_for_timeout(2 * _SETTLED)
    box.focus()
    done = f"{_TREE}?.textContent.includes('{name}') && document.querySelectorAll('[role=treeitem]').length === 1"
    return cost_of(page, "input", lambda: page.keyboard.insert_text(name), done)
