"""A real browser for the benchmark of the pages, with its own measurements."""

from __future__ import annotations

import shutil
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

from playwright.sync_api import Browser, CDPSession, Page, sync_playwright

_ARGUMENTS = ["--enable-unsafe-swiftshader", "--enable-precise-memory-info"]
"""Software rendering, as on a machine without a graphics card.

There, the browser has the processor draw what is WebGL as a graphics card would, and puts the page together without
that. ``--use-angle=swiftshader`` would have it do the latter, too, as if there were a card: twice the work for each
frame, which no operator's browser does by itself.
"""
_PATIENCE = 60_000.0


@contextmanager
def browsing() -> Iterator[Browser]:
    """Runs the machine's Chromium, headless, during the block.

    Raises:
        FileNotFoundError: There is none.
    """
    path = shutil.which("chromium")
    if path is None:
        raise FileNotFoundError("this benchmark needs Chromium: apt-get install chromium")
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=path, args=_ARGUMENTS)
        try:
            yield browser
        finally:
            browser.close()


def new_page(browser: Browser) -> Page:
    """Returns a page of a browser with an empty cache."""
    page = browser.new_context(viewport={"width": 1280, "height": 800}).new_page()
    page.set_default_timeout(_PATIENCE)
    return page


def ready(page: Page) -> None:
    """Returns when the page is usable: stop button, first tab and elements in the 3D view are shown."""
    page.get_by_role("button", name="Stop all").wait_for()
    page.get_by_role("tabpanel").get_by_role("button").first.wait_for()
    page.wait_for_function("() => window.skiros3d?.frames > 0 && window.skiros3d.shown().length > 0")


class _Counter:
    """Counts compressed bytes received over the network."""

    def __init__(self, session: CDPSession) -> None:
        self.bytes = {"pages": 0, "api": 0}
        self._urls: dict[str, str] = {}
        session.on("Network.requestWillBeSent", self._begun)
        session.on("Network.dataReceived", self._came)
        session.send("Network.enable")

    def _begun(self, event: dict[str, Any]) -> None:
        self._urls[event["requestId"]] = event["request"]["url"]

    def _came(self, event: dict[str, Any]) -> None:
        kind = "api" if "/api/v1/" in self._urls.get(event["requestId"], "") else "pages"
        self.bytes[kind] += event["encodedDataLength"]


def transferred(page: Page) -> dict[str, int]:
    """Returns the bytes received from now on, separately for the pages and for data; keeps counting."""
    return _Counter(page.context.new_cdp_session(page)).bytes


def heap(page: Page) -> float:
    """Returns the heap of the page's scripts after garbage collection [MiB]."""
    session = page.context.new_cdp_session(page)
    session.send("HeapProfiler.collectGarbage")
    used: float = session.send("Runtime.getHeapUsage")["usedSize"]
    session.detach()
    return used / 2**20


_WATCH = """
([event, done, drawn]) => {
  let begun = null;
  window.addEventListener(event, ({ timeStamp }) => (begun = timeStamp), { capture: true, once: true });
  const there = new Function(`return (${done})`);
  const before = window.skiros3d.frames;
  window.cost = new Promise((resolve, reject) => {
    const look = () => requestAnimationFrame((now) => {
      const seen = begun !== null && there();  // what is there now is painted next, as is what is drawn in this frame
      setTimeout(() => {
        if (seen && (!drawn || window.skiros3d.frames > before)) resolve(performance.now() - begun);
        else if (begun !== null && now - begun > 10000) reject(new Error(`not seen within ten seconds: ${done}`));
        else look();
      });
    });
    look();
  });
}
"""


def cost_of(page: Page, event: str, act: Callable[[], None], done: str, *, drawn: bool = False) -> float:
    """Returns the time from an input to the painted result [ms], by the page's own clock.

    Args:
        page: The page.
        event: What the browser calls the input: ``keydown``.
        act: Makes the input, as a person does.
        done: JavaScript expression that is true when the result is there; it is asked once a frame.
        drawn: Whether the 3D view must be redrawn, too.
    """
    page.evaluate(_WATCH, [event, done, drawn])
    act()
    cost: float = page.evaluate("window.cost")
    return cost
