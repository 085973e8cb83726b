"""The pages in a real browser: Debian's Chromium, driven by Playwright, before a real server.

Where the browser or the pages are missing these tests are skipped; with ``SKIROS_WEB_TESTS=required`` they fail, so
that nobody takes what was not tried for good. ``SKIROS_WEB_PAGES`` names the folder of another build of the pages.
"""

from __future__ import annotations

import os
import shutil
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import ExitStack
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any, NoReturn

import pytest
from support.serving import Served, serving

from skiros_py.catalogue.catalogue import Catalogue
from skiros_py.server.pages import installed_pages
from skiros_py.server.settings import ServerSettings
from skiros_py.station.session import Options

if TYPE_CHECKING:
    from playwright.sync_api import Browser, ConsoleMessage, Page

Station = Callable[..., Served]
Visit = Callable[..., "Page"]
Axe = Callable[["Page"], list[str]]

_SOFTWARE = ["--use-angle=swiftshader", "--enable-unsafe-swiftshader"]
"""Renders without a graphics card."""
_PATIENCE = 30_000
"""How long anything on a page may take [ms]: machines that test are busy."""
_GRAVE = {"serious", "critical"}
_AT_REST = """() => {
  const sheet = new CSSStyleSheet();
  sheet.replaceSync("* { transition: none !important; animation: none !important }");
  document.adoptedStyleSheets = [sheet];
  return new Promise((drawn) => requestAnimationFrame(() => requestAnimationFrame(drawn)));
}"""
"""Ends all transitions of a page, those under way and those to come."""
_PATIENT = 5.0
"""For how long a module may hold the control cycle [s]: browser, server and physics share the machine."""
_USUAL = ServerSettings()


def _unavailable(why: str) -> NoReturn:
    if os.environ.get("SKIROS_WEB_TESTS") == "required":
        pytest.fail(why)
    pytest.skip(why)


@pytest.fixture(scope="session")
def chromium() -> str:
    """Path of the browser."""
    if installed_pages() is None:
        _unavailable("the pages are not installed: uv run --group web …")
    return shutil.which("chromium") or _unavailable("there is no chromium: apt-get install chromium")


@pytest.fixture(scope="module")
def browser(chromium: str) -> Iterator[Browser]:
    """A browser for the tests of a module."""
    try:
        from playwright.sync_api import sync_playwright
    except ImportError:
        _unavailable("playwright is not installed: uv run --group browser …")
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=chromium, args=_SOFTWARE)
        yield browser
        browser.close()


@pytest.fixture(scope="session")
def expect() -> Any:
    """Playwright's assertions, which wait."""
    expect = pytest.importorskip("playwright.sync_api").expect
    expect.set_options(timeout=_PATIENCE)
    return expect


@pytest.fixture(scope="session")
def models(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Where the models of robots are kept that pages draw: they are made once for all tests, which takes seconds."""
    return tmp_path_factory.mktemp("models")


@pytest.fixture
def data(tmp_path: Path, models: Path) -> Path:
    """A data directory."""
    (tmp_path / "models").symlink_to(models)
    return tmp_path


@pytest.fixture
def station(data: Path) -> Iterator[Station]:
    """Opens a station with its server: ``station(scene, physics=False, pace=3.0, settings=…)``."""
    # Playwright's event loop is that of this thread; servers are begun and ended in another one.
    with ThreadPoolExecutor(1, "station") as keeper:
        stations = ExitStack()

        def opened(
            scene: str = "kitting",
            *,
            physics: bool = False,
            pace: float = 3.0,
            settings: ServerSettings = _USUAL,
            catalogue: Catalogue | None = None,
        ) -> Served:
            options = Options(fake=not physics, pace=pace, overrun=_PATIENT)
            return keeper.submit(stations.enter_context, serving(scene, data, options, settings, catalogue)).result()

        yield opened
        keeper.submit(stations.close).result()


@dataclass
class Complaints:
    """What a page said on the console that it should not."""

    expected: tuple[str, ...]
    texts: list[str] = field(default_factory=list)

    def hear(self, message: ConsoleMessage) -> None:
        """Notes an error."""
        if message.type == "error":
            self.note(f"error: {message.text} ({message.location.get('url', '')})")

    def note(self, text: str) -> None:
        """Notes a complaint, unless it is expected."""
        if not any(part in text for part in self.expected):
            self.texts.append(text)


@pytest.fixture
def visit(browser: Browser) -> Iterator[Visit]:
    """Opens a page: ``visit(url, at="#/task", expected=(…), color_scheme="dark", locale="de-DE", viewport=…)``.

    An error on the console fails the test, but what is expected there: refused requests are told by the
    browser itself.
    """
    with ExitStack() as stack:
        heard: list[Complaints] = []

        def opened(url: str, at: str = "", expected: tuple[str, ...] = (), **settings: Any) -> Page:
            settings = {"viewport": {"width": 1440, "height": 900}, "locale": "en-GB"} | settings
            context = browser.new_context(**settings)
            stack.callback(context.close)
            context.set_default_timeout(_PATIENCE)
            page = context.new_page()
            complaints = Complaints(expected)
            heard.append(complaints)
            page.on("console", complaints.hear)
            page.on("pageerror", lambda error: complaints.note(f"page error: {error}"))
            page.goto(f"{url}/{at}")
            return page

        yield opened
    assert not [text for complaints in heard for text in complaints.texts]


@pytest.fixture
def axe() -> Axe:
    """Returns the serious findings of axe on a page: accessibility that it lacks.

    What slides or fades, in or out, is taken where that ends: axe takes what is half transparent for pale.
    """
    sync = pytest.importorskip("axe_playwright_python.sync_playwright")

    def findings(page: Page) -> list[str]:
        page.evaluate(_AT_REST)
        found = sync.Axe().run(page).response["violations"]
        return [_finding(one) for one in found if one["impact"] in _GRAVE]

    return findings


def _finding(one: dict[str, Any]) -> str:
    nodes = [f"{node['html'][:200]} ({node.get('failureSummary', '')[:200]})" for node in one["nodes"]]
    return f"{one['id']}: {one['help']}: " + "; ".join(nodes[:5])
