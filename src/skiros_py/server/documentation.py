"""The API's description as a page to read and to try out, without a network: factory nets have none."""

from __future__ import annotations

from importlib.resources import files

from fastapi import FastAPI
from fastapi.openapi.docs import get_swagger_ui_html
from starlette.requests import Request
from starlette.responses import HTMLResponse, JSONResponse
from starlette.staticfiles import StaticFiles


def add_documentation(app: FastAPI, prefix: str) -> None:
    """Adds the description ``openapi.json``, the page ``docs`` about it, and what that is made of.

    Args:
        app: The application; it has neither of its own.
        prefix: Where the API lies.
    """
    assets = f"{prefix}/docs/assets"

    def description(_request: Request) -> JSONResponse:  # in a thread: it takes a second to make
        return JSONResponse(app.openapi())

    async def page(_request: Request) -> HTMLResponse:
        return get_swagger_ui_html(
            openapi_url=f"{prefix}/openapi.json",
            title=app.title,
            swagger_js_url=f"{assets}/swagger-ui-bundle.js",
            swagger_css_url=f"{assets}/swagger-ui.css",
            swagger_favicon_url=f"{assets}/favicon.png",
        )

    app.add_route(f"{prefix}/openapi.json", description, include_in_schema=False)
    app.add_route(f"{prefix}/docs", page, include_in_schema=False)
    app.mount(assets, StaticFiles(directory=str(files("fastapi_offline") / "static")))
