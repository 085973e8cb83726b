"""Pages for people: files of a folder, or words about what is missing; and what is no page."""

from __future__ import annotations

import gzip
import sys
from pathlib import Path

import pytest
from starlette.requests import Request
from starlette.testclient import TestClient
from starlette.types import ASGIApp, Receive, Scope, Send

from skiros_py.errors import UsageError
from skiros_py.server.pages import Pages, installed_pages, is_page, pages_of
from skiros_py.server.problems import Problem, problem_response
from skiros_py.server.settings import ServerSettings

INDEX = b"<!doctype html><title>cell</title>"
SCRIPT = b"console.log('here')" * 20


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    pages = tmp_path / "pages"
    (pages / "assets").mkdir(parents=True)
    (pages / "index.html").write_bytes(INDEX)
    (pages / "assets" / "index-a1b2.js").write_bytes(SCRIPT)
    (pages / "assets" / "index-a1b2.js.gz").write_bytes(gzip.compress(SCRIPT, mtime=0))
    (pages / "assets" / "index-a1b2.js.br").write_bytes(b"as if by brotli")
    (pages / "assets" / "text-c3d4.woff2").write_bytes(b"font")
    (pages / "favicon.svg").write_bytes(b"<svg/>")
    (tmp_path / "secret.txt").write_text("secret")
    (pages / "way-out.txt").symlink_to(tmp_path / "secret.txt")
    return pages


def telling(pages: Pages) -> ASGIApp:
    """Answers problems as the gate does."""

    async def app(scope: Scope, receive: Receive, send: Send) -> None:
        try:
            await pages(scope, receive, send)
        except Problem as problem:
            await problem_response(Request(scope), problem)(scope, receive, send)

    return app


@pytest.fixture
def client(folder: Path) -> TestClient:
    return TestClient(telling(Pages(folder)), base_url="http://127.0.0.1", headers={"Accept-Encoding": "identity"})


@pytest.fixture
def without() -> TestClient:
    return TestClient(telling(Pages(None)), base_url="http://127.0.0.1")


@pytest.mark.parametrize(
    ("method", "path", "page"),
    [
        ("GET", "/", True),
        ("HEAD", "/assets/x.js", True),
        ("GET", "/apiary", True),
        ("POST", "/", False),
        ("GET", "/api", False),
        ("GET", "/api/v1/world", False),
        ("GET", "/api/v1/modules/\n", False),
        ("GET", "/metrics", False),
        ("GET", "/healthz", False),
        ("GET", "/readyz", False),
    ],
)
def test_page_files_are_served_and_api_paths_are_not_pages(method: str, path: str, page: bool) -> None:
    assert is_page(method, path) is page


def test_the_first_page_is_always_revalidated_and_declares_its_sources(client: TestClient) -> None:
    page = client.get("/")

    assert (page.status_code, page.content, page.headers["cache-control"]) == (200, INDEX, "no-cache")
    policy = page.headers["content-security-policy"]
    assert "default-src 'self'" in policy
    assert "script-src 'self';" in policy
    assert "frame-ancestors 'none'" in policy
    again = client.get("/", headers={"If-None-Match": page.headers["etag"]})
    assert (again.status_code, again.content) == (304, b"")


def test_files_named_by_their_hash_are_cached_forever(client: TestClient) -> None:
    script = client.get("/assets/index-a1b2.js")

    assert script.content == SCRIPT
    assert script.headers["cache-control"] == "public, max-age=31536000, immutable"
    assert client.get("/favicon.svg").headers["cache-control"] == "no-cache"


@pytest.mark.parametrize(
    ("accepted", "encoding"),
    [
        ("gzip, deflate, br", "br"),
        ("gzip", "gzip"),
        ("GZIP;q=0.5, br;q=0", "gzip"),
        ("br; q=0.0, gzip; q=0", None),
        ("", None),
    ],
)
def test_a_compressed_file_is_sent_if_the_browser_accepts_it(
    client: TestClient, accepted: str, encoding: str | None
) -> None:
    with client.stream("GET", "/assets/index-a1b2.js", headers={"Accept-Encoding": accepted}) as script:
        sent = b"".join(script.iter_raw())

    assert script.headers.get("content-encoding") == encoding
    assert (script.headers["vary"], script.headers["content-type"]) == (
        "Accept-Encoding",
        "text/javascript; charset=utf-8",
    )
    assert len(sent) == int(script.headers["content-length"])
    assert sent == {"br": b"as if by brotli", "gzip": gzip.compress(SCRIPT, mtime=0), None: SCRIPT}[encoding]


def test_fonts_have_the_same_media_type_on_every_machine(client: TestClient) -> None:
    assert client.get("/assets/text-c3d4.woff2").headers["content-type"] == "font/woff2"


@pytest.mark.parametrize("path", ["/jobs/kit-17", "/world", "/assets", "/a/b/c/"])
def test_an_address_of_the_page_application_is_answered_with_the_index_page(client: TestClient, path: str) -> None:
    page = client.get(path)

    assert (page.status_code, page.content, page.headers["cache-control"]) == (200, INDEX, "no-cache")


@pytest.mark.parametrize("path", ["/nothing.js", "/assets/gone-1234.css", f"/{'x' * 300}.js"])
def test_a_missing_page_file_is_answered_with_a_problem_document(client: TestClient, path: str) -> None:
    answer = client.get(path)

    assert (answer.status_code, answer.headers["content-type"]) == (404, "application/problem+json")
    assert "there is no page" in answer.json()["detail"]


@pytest.mark.parametrize(
    "path", ["/%2e%2e/secret.txt", "/..%2fsecret.txt", "//etc/hosts.txt", "/%5c..%5csecret.txt", "/way-out.txt"]
)
def test_no_file_outside_the_page_folder_is_served(client: TestClient, path: str) -> None:
    answer = client.get(path)

    assert answer.status_code == 404
    assert b"secret\n" not in answer.content


def test_a_head_request_is_answered_without_a_body(client: TestClient) -> None:
    head = client.head("/")

    assert (head.status_code, head.content, int(head.headers["content-length"])) == (200, b"", len(INDEX))


def test_without_pages_the_root_explains_what_to_install_and_links_the_api(without: TestClient) -> None:
    page = without.get("/")

    assert (page.status_code, page.headers["content-type"]) == (200, "text/html; charset=utf-8")
    assert all(words in page.text for words in ('href="api/v1/docs"', "pip install skiros-web", "--group web"))
    assert "<script" not in page.text
    assert without.get("/world").status_code == without.get("/x.js").status_code == 404


def test_a_folder_without_an_index_page_is_refused(tmp_path: Path) -> None:
    with pytest.raises(UsageError, match=r"index\.html"):
        Pages(tmp_path)


def test_configured_pages_take_precedence_over_installed_ones(folder: Path) -> None:
    assert pages_of(ServerSettings(pages=folder)) == folder
    assert pages_of(ServerSettings(pages=None)) is None
    assert pages_of(ServerSettings()) == installed_pages()


def installed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, module: str) -> None:
    """Installs a distribution with pages before all others, as pip would."""
    info = tmp_path / "skiros_web-9.9.dist-info"
    info.mkdir()
    (info / "METADATA").write_text("Metadata-Version: 2.1\nName: skiros-web\nVersion: 9.9\n")
    (info / "entry_points.txt").write_text("[skiros.pages]\nweb = pages_of_a_test:PAGES\n")
    (tmp_path / "pages_of_a_test.py").write_text(module)
    monkeypatch.syspath_prepend(tmp_path)
    monkeypatch.delitem(sys.modules, "pages_of_a_test", raising=False)


def test_installed_pages_are_found_by_their_entry_point(
    tmp_path: Path, folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    installed(tmp_path, monkeypatch, f"from pathlib import Path\nPAGES = Path({str(folder)!r})\n")

    assert installed_pages() == folder


@pytest.mark.parametrize(
    "module", ["raise RuntimeError('broken')", "PAGES = 'a text'", "from pathlib import Path\nPAGES = Path('/none')"]
)
def test_invalid_installed_pages_are_logged_and_left_out(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture, module: str
) -> None:
    installed(tmp_path, monkeypatch, module)

    assert installed_pages() is None
    assert "skiros-web 9.9 holds no pages" in caplog.text
