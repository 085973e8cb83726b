"""What is always there, in a browser: tabs, stop and reset, alarms and questions, the connection, languages, keys."""

from __future__ import annotations

import re
import socket
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING

import httpx2
import pytest
from support.server_process import ServerProcess
from support.serving import Served

from skiros_py.server.settings import ServerSettings
from skiros_py.skills.context import QuestionKind

if TYPE_CHECKING:
    from playwright.sync_api import Page

TABS = ("Goal", "Task", "Modules", "World")
REFUSED = ("Failed to load resource",)
"""What the browser itself says of requests that are refused or reach nobody."""
EVIL = '<img src=x onerror="window.hacked = 1">'


@contextmanager
def api(served: Served, key: str = "") -> Iterator[httpx2.Client]:
    headers = {"X-API-Key": key} if key else {}
    with httpx2.Client(base_url=f"{served.url}/api/v1", headers=headers, timeout=30) as http:
        yield http


def stop_button(page: Page):
    return page.get_by_role("banner").get_by_role("button", name="Stop all", exact=True)


# ---------------------------------------------------------------------- the frame


def test_the_page_opens_with_the_four_tabs_and_says_that_it_is_connected(station, visit, expect):
    page = visit(station().url)
    for tab in TABS:
        expect(page.get_by_role("tab", name=tab, exact=True)).to_be_visible()
    expect(page.get_by_role("heading", level=1)).to_have_text("kitting")
    expect(page.get_by_text("connected", exact=True)).to_be_visible()
    expect(stop_button(page)).to_be_visible()


@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_axe_finds_nothing_serious_on_any_tab(station, visit, axe, expect, scheme):
    page = visit(station().url, color_scheme=scheme)
    found = {}
    for tab in TABS:
        page.get_by_role("tab", name=tab, exact=True).click()
        expect(page.get_by_role("tab", name=tab, exact=True)).to_have_attribute("aria-selected", "true")
        expect(page.get_by_label("Loading …")).to_have_count(0)
        found[tab] = axe(page)
    assert {tab: one for tab, one in found.items() if one} == {}


@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_axe_finds_nothing_serious_in_banners_dialogs_and_alarms(station, visit, axe, expect, scheme):
    served = station()
    page = visit(served.url, color_scheme=scheme)
    stop_button(page).click()
    expect(page.get_by_text("Everything is halted")).to_be_visible()
    with asking(served):
        expect(page.get_by_text("A robot asks")).to_be_visible()
        found = {"banners": axe(page)}
        page.get_by_role("button", name="Alarms").click()
        expect(page.get_by_role("button", name="Acknowledge").first).to_be_visible()
        found["alarms"] = axe(page)
    page.keyboard.press("Escape")
    page.keyboard.press("Control+k")
    expect(page.get_by_role("textbox", name=re.compile("Tabs, commands"))).to_be_visible()
    found["palette"] = axe(page)
    blurred = "[...document.querySelectorAll('*')].filter(e => getComputedStyle(e).backdropFilter !== 'none').length"
    assert page.evaluate(blurred) == 0  # a blur over the 3D view is drawn again for each frame
    assert found == {"banners": [], "alarms": [], "palette": []}


def test_keyboard_shortcuts_open_tabs_hide_the_view_and_list_themselves(station, visit, expect):
    page = visit(station().url)
    expect(page.get_by_role("tab", name="Goal")).to_be_visible()
    page.keyboard.press("Alt+4")
    expect(page.get_by_role("tab", name="World")).to_have_attribute("aria-selected", "true")
    assert page.url.endswith("#/world")
    page.keyboard.press("Alt+0")
    expect(page.get_by_role("region", name="3D view")).to_have_count(0)
    page.reload()
    expect(page.get_by_role("button", name="Show the 3D view")).to_be_visible()
    page.keyboard.press("Shift+?")
    expect(page.get_by_role("dialog", name="Keys")).to_be_visible()


def test_a_mistyped_address_opens_the_page_nevertheless(station, visit, expect):
    page = visit(station().url, at="#/task/100%")
    expect(page.get_by_role("tab", name="Task")).to_have_attribute("aria-selected", "true")


@pytest.mark.parametrize("width", [640, 1024])
def test_the_page_frame_is_not_cut_off_in_a_narrow_window(station, visit, expect, width):
    page = visit(station().url, viewport={"width": width, "height": 768})
    expect(page.get_by_role("tab", name="World")).to_be_in_viewport(ratio=1)
    expect(stop_button(page)).to_be_in_viewport(ratio=1)
    expect(page.get_by_role("button", name="Signed in")).to_be_in_viewport(ratio=1)
    assert page.evaluate("document.documentElement.scrollWidth") <= width


def test_eight_windows_of_one_browser_all_follow_the_station(station, visit, expect):
    served = station()
    first = visit(served.url)
    pages = [first, *(first.context.new_page() for _ in range(7))]
    for page in pages[1:]:
        page.goto(served.url)
    for page in pages:
        expect(page.get_by_text("connected", exact=True)).to_be_visible()
    stop_button(pages[-1]).click()
    for page in pages:
        expect(page.get_by_text("Everything is halted")).to_be_visible()


# ---------------------------------------------------------------------- stop and reset


def test_stop_all_halts_everything_until_a_reset(station, visit, expect):
    served = station()
    page = visit(served.url)
    stop_button(page).click()
    expect(page.get_by_text("The stop was obeyed.")).to_be_visible()
    assert served.services.station.session.cycle.halted
    expect(page).to_have_title(re.compile("halted"))
    page.get_by_role("button", name="Reset").click()
    page.get_by_role("button", name="I have checked: reset").click()
    expect(page.get_by_text("Everything is halted")).to_have_count(0)
    assert not served.services.station.session.cycle.halted


@pytest.mark.parametrize("how", ["click", "key"])
def test_stop_all_works_while_a_dialog_is_open_and_text_is_typed(station, visit, expect, how):
    served = station()
    page = visit(served.url)
    expect(stop_button(page)).to_be_visible()
    page.keyboard.press("Control+k")
    expect(page.get_by_role("textbox", name=re.compile("Tabs, commands"))).to_be_focused()
    if how == "key":
        page.keyboard.press("Control+Shift+Space")
    else:
        stop_button(page).click()
    expect(page.get_by_text("The stop was obeyed.")).to_be_visible()
    assert served.services.station.session.cycle.halted


def test_an_undelivered_stop_is_shown_until_it_is_delivered(station, visit, expect):
    served = station()
    page = visit(served.url, expected=REFUSED)
    expect(page.get_by_text("connected", exact=True)).to_be_visible()
    page.route("**/api/v1/stop", lambda route: route.abort())
    stop_button(page).click()
    expect(page.get_by_text("NO ANSWER TO THE STOP")).to_be_visible()
    page.unroute("**/api/v1/stop")
    expect(page.get_by_text("The stop was obeyed.")).to_be_visible()
    assert served.services.station.session.cycle.halted


def test_a_stop_from_elsewhere_is_shown_with_its_author_and_reason(station, visit, expect):
    served = station()
    page = visit(served.url)
    expect(stop_button(page)).to_be_visible()
    with api(served) as http:
        answer = http.post("/stop", json={"reason": "a person is in the cell"}, headers={"X-Skiros-User": "door"})
    assert answer.status_code == 200, answer.text
    banner = page.get_by_role("alert").filter(has_text="Everything is halted")
    expect(banner).to_contain_text("a person is in the cell")
    expect(banner).to_contain_text("door")


# ---------------------------------------------------------------------- questions


@contextmanager
def asking(served: Served, text: str = "Is the pallet full?") -> Iterator[object]:
    """A robot asks while the block runs."""
    questions = served.services.station.session.questions
    asked = questions.ask(QuestionKind.CONFIRM, text, ("yes", "no"), asker="confirm", time=0.0)
    try:
        yield asked
    finally:
        questions.withdraw(asked)


def test_a_question_is_shown_and_answered(station, visit, expect):
    served = station()
    page = visit(served.url)
    with asking(served) as asked:
        expect(page.get_by_role("alert").filter(has_text="Is the pallet full?")).to_be_visible()
        page.get_by_role("button", name="Yes", exact=True).click()
        expect(page.get_by_text("Is the pallet full?")).to_have_count(0)
        assert asked.answer == "yes"


# ---------------------------------------------------------------------- the connection


def free_port() -> int:
    with socket.socket() as listening:
        listening.bind(("127.0.0.1", 0))
        return listening.getsockname()[1]


def test_a_lost_connection_is_shown_and_restored_when_the_server_is_back(visit, expect, data: Path):
    port = free_port()
    with ServerProcess("kitting", "--fake", data=data, port=port) as first:
        page = visit(first.url, expected=REFUSED)
        expect(page.get_by_text("connected", exact=True)).to_be_visible()
        first.kill()
        expect(page.get_by_text("Connection lost")).to_be_visible()
    with ServerProcess("--fake", data=data, port=port) as second:
        expect(page.get_by_text("Connection lost")).to_have_count(0, timeout=30_000)
        stop_button(page).click()
        expect(page.get_by_text("The stop was obeyed.")).to_be_visible()
        with second.client() as client:
            client.http.post("/reset").raise_for_status()
        expect(page.get_by_text("Everything is halted")).to_have_count(0)  # events come again


# ---------------------------------------------------------------------- keys and roles


def key_of(served: Served, role: str) -> tuple[str, str]:
    """Makes a key; returns its id and itself."""
    with api(served, served.services.keys.local_token) as http:
        made = http.post("/keys", json={"name": "anna", "role": role}).json()
    return made["key"]["id"], made["secret"]


def sign_in(page: Page, key: str) -> None:
    page.get_by_label("Key", exact=True).fill(key)
    page.get_by_role("button", name="Sign in").click()


def test_a_key_signs_in_and_the_login_can_be_ended(station, visit, axe, expect):
    served = station(settings=ServerSettings(authentication="keys"))
    _, key = key_of(served, "operator")
    page = visit(served.url, expected=REFUSED)
    sign_in(page, "sk_00000000_wrong")
    expect(page.get_by_role("alert")).to_contain_text("is not valid")
    assert axe(page) == []
    sign_in(page, key)
    expect(page.get_by_role("button", name="Signed in: anna, operator")).to_be_visible()
    page.get_by_role("button", name="Signed in: anna").click()
    page.get_by_role("button", name="Sign out").click()
    expect(page.get_by_label("Key", exact=True)).to_be_visible()


def test_a_viewer_sees_everything_but_may_not_stop(station, visit, expect):
    served = station(settings=ServerSettings(authentication="keys"))
    _, key = key_of(served, "viewer")
    page = visit(served.url, expected=REFUSED)
    sign_in(page, key)
    for tab in TABS:
        expect(page.get_by_role("tab", name=tab, exact=True)).to_be_visible()
    expect(stop_button(page)).to_have_attribute("aria-disabled", "true")


def test_after_a_revoked_key_and_a_new_login_the_page_is_unchanged(station, visit, expect):
    served = station(settings=ServerSettings(authentication="keys"))
    (number, key), (_, other) = key_of(served, "operator"), key_of(served, "operator")
    page = visit(served.url, at="#/world", expected=REFUSED)
    sign_in(page, key)
    expect(page.get_by_text("connected", exact=True)).to_be_visible()
    page.evaluate("document.querySelector('main').dataset.draft = 'mine'")
    with api(served, served.services.keys.local_token) as http:
        http.delete(f"/keys/{number}").raise_for_status()
    expect(page.get_by_role("dialog", name="Sign in again")).to_be_visible()
    sign_in(page, other)
    expect(page.get_by_role("dialog", name="Sign in again")).to_have_count(0)
    assert page.evaluate("document.querySelector('main').dataset.draft") == "mine"
    expect(page.get_by_text("connected", exact=True)).to_be_visible()


# ---------------------------------------------------------------------- words


def test_the_page_uses_the_browser_language_and_remembers_a_choice(station, visit, expect):
    page = visit(station().url, locale="de-DE")
    expect(page.get_by_role("tab", name="Aufgabe")).to_be_visible()
    expect(page.get_by_role("button", name="Alles anhalten")).to_be_visible()
    assert page.evaluate("document.documentElement.lang") == "de"
    page.get_by_role("button", name="Sprache: English").click()
    expect(page.get_by_role("tab", name="Task")).to_be_visible()
    page.reload()
    expect(page.get_by_role("tab", name="Task")).to_be_visible()


def test_a_label_that_looks_like_html_is_shown_as_text(station, visit, expect):
    served = station()
    with api(served) as http:
        element = {"class": "kitting:Starter", "label": EVIL, "placement": {"relation": "sk:in", "place": "pallet_a"}}
        http.post("/elements", json=element).raise_for_status()
    page = visit(served.url, at="#/world")
    with asking(served, f"Is {EVIL} there?"):
        expect(page.get_by_role("alert").filter(has_text=EVIL)).to_be_visible()
        page.keyboard.press("Control+k")
        page.get_by_role("textbox", name=re.compile("Tabs, commands")).fill("onerror")
        expect(page.get_by_role("dialog").get_by_text(EVIL)).to_be_visible()
        page.keyboard.press("Escape")
        for tab in TABS:
            page.get_by_role("tab", name=tab, exact=True).click()
            expect(page.get_by_label("Loading …")).to_have_count(0)
    assert page.locator("img").count() == 0
    assert page.evaluate("window.hacked") is None
