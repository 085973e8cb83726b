"""The web pages: files of an installed distribution; if there is none, one page that names what to install."""

from __future__ import annotations

import logging
import os
import re
from collections.abc import Iterator
from mimetypes import guess_type
from pathlib import Path, PurePosixPath

from starlette.datastructures import Headers
from starlette.exceptions import HTTPException
from starlette.responses import FileResponse, HTMLResponse, Response
from starlette.staticfiles import NotModifiedResponse, StaticFiles
from starlette.types import Receive, Scope, Send

from skiros_py.errors import UsageError
from skiros_py.plugins.installation import installation
from skiros_py.plugins.loading import load
from skiros_py.plugins.plugin import Plugin
from skiros_py.server.problems import Problem
from skiros_py.server.settings import ServerSettings

GROUP, NAME = "skiros.pages", "web"
"""Entry point with which a distribution provides its pages: a :class:`pathlib.Path` of a folder."""

_INDEX = "index.html"
_READ = frozenset({"GET", "HEAD"})
_NO_PAGES = frozenset({"api", "metrics", "healthz", "readyz"})
"""First segments of paths that are for programs."""
_HASHED = "assets"
_PACKED = (("br", ".br"), ("gzip", ".gz"))
"""Encodings of precompressed files beside the originals, smallest first."""
_TYPES = {".js": "text/javascript", ".mjs": "text/javascript", ".woff2": "font/woff2", ".map": "application/json"}
"""MIME types that browsers require and that are missing in the tables of some machines."""
_POLICY = (
    "default-src 'self'",
    "script-src 'self'",
    "style-src 'self' 'unsafe-inline'",
    "img-src 'self' data: blob:",
    "connect-src 'self' blob: data:",
    "worker-src 'self' blob:",
    "frame-ancestors 'none'",
    "base-uri 'none'",
    "form-action 'self'",
)
_HEADERS = {"Content-Security-Policy": "; ".join(_POLICY), "Cross-Origin-Opener-Policy": "same-origin"}
_FOREVER = "public, max-age=31536000, immutable"
_ANEW = "no-cache"
_log = logging.getLogger(__name__)


def is_page(method: str, path: str) -> bool:
    """Returns whether a request is for a page: it only reads, and not from the API, health or metrics."""
    return method in _READ and path.removeprefix("/").partition("/")[0] not in _NO_PAGES


def installed_pages() -> Path | None:
    """Returns the folder of the installed pages; None if there are none, or the folder contains no pages."""
    for entry in installation().of(GROUP):
        if entry.name == NAME:
            plugin = load(entry)
            folder = plugin.value if isinstance(plugin, Plugin) else None
            if isinstance(folder, Path) and (folder / _INDEX).is_file():
                return folder
            _log.warning("%s holds no pages: install it again (%s)", entry.distribution, folder or plugin)
    return None


def pages_of(settings: ServerSettings) -> Path | None:
    """Returns the folder of the pages of a server; None for none."""
    return installed_pages() if settings.pages == "installed" else settings.pages


class Pages:
    """ASGI application that serves the pages; only for requests accepted by :func:`is_page`.

    Args:
        folder: Folder with ``index.html`` and the files that it uses; names of files below ``assets`` contain a hash of
            their content. None for none.

    Raises:
        UsageError: The folder has no ``index.html``.
    """

    def __init__(self, folder: Path | None) -> None:
        if folder is not None and not (folder / _INDEX).is_file():
            raise UsageError(f"{folder}: there is no {_INDEX}: build the pages first")
        self._files = None if folder is None else _Files(directory=folder)

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Answers a request.

        Raises:
            Problem: There is no such page.
        """
        if self._files is None:
            await self._without(scope)(scope, receive, send)
            return
        try:
            await self._files(scope, receive, send)
        except HTTPException as error:  # 401 is raised for files that cannot be read: answered like missing files
            raise _missing(scope) from error

    def _without(self, scope: Scope) -> Response:
        if scope["path"] != "/":
            raise _missing(scope)
        return HTMLResponse(_WITHOUT, headers={**_HEADERS, "Cache-Control": _ANEW})


def _missing(scope: Scope) -> Problem:
    path = scope["path"][:200]
    return Problem(404, "NotFound", f"there is no page {path!a}; pages are below /, the API is below /api/v1")


class _Files(StaticFiles):
    """Serves files, compressed if the browser accepts that; paths without a file are routes of the first page."""

    async def get_response(self, path: str, scope: Scope) -> Response:
        try:
            return await super().get_response(path, scope)
        except HTTPException:
            if PurePosixPath(path).suffix:
                raise
        return await super().get_response(_INDEX, scope)

    def file_response(
        self,
        full_path: str | os.PathLike[str],
        stat_result: os.stat_result,
        scope: Scope,
        status_code: int = 200,
    ) -> Response:
        asked, path = Headers(scope=scope), Path(full_path)
        headers = {**_HEADERS, "Vary": "Accept-Encoding", "Cache-Control": self._kept(path)}
        chosen, stat = path, stat_result
        for encoding, packed in _packed(path, asked.get("accept-encoding", "")):
            chosen, stat = packed, packed.stat()
            headers["Content-Encoding"] = encoding
            break
        type_ = _TYPES.get(path.suffix) or guess_type(path.name)[0] or "application/octet-stream"
        response = FileResponse(chosen, status_code, headers, type_, stat_result=stat)
        if self.is_not_modified(response.headers, asked):
            return NotModifiedResponse(response.headers)
        return response

    def _kept(self, path: Path) -> str:
        """Returns how long browsers may cache a file: forever if its name contains a hash of its content."""
        return _FOREVER if _HASHED in path.parts[len(Path(os.path.realpath(str(self.directory))).parts) :] else _ANEW


def _packed(path: Path, accepted: str) -> Iterator[tuple[str, Path]]:
    """Yields the compressed variants of a file that a browser accepts, best first."""
    takes = set(_taken(accepted))
    for encoding, suffix in _PACKED:
        packed = path.with_name(path.name + suffix)
        if encoding in takes and packed.is_file():
            yield encoding, packed


def _taken(accepted: str) -> Iterator[str]:
    for one in accepted.lower().split(","):
        name, _, quality = one.partition(";")
        if not re.fullmatch(r"\s*q\s*=\s*0(\.0*)?\s*", quality):
            yield name.strip()


_WITHOUT = """<!doctype html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
<title>skiros-py</title>
<style>
:root { color-scheme: light dark; }
body { font: 1rem/1.5 system-ui, sans-serif; max-width: 42rem; margin: 3rem auto; padding: 0 1rem; }
code { font-family: ui-monospace, monospace; }
</style>
</head>
<body>
<h1>skiros-py</h1>
<p>The server runs, and its REST API is below <code>/api/v1</code>: <a href="api/v1/docs">its documentation</a>.</p>
<p>The pages for people are not installed here. They come with</p>
<ul>
<li><code>uv run --group web skiros serve &hellip;</code> in a checkout,</li>
<li><code>pip install skiros-web</code> everywhere else; then start the server again.</li>
</ul>
</body>
</html>
"""
