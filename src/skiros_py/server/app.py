"""The application: routes, the gate in front of them, error handlers, and its documentation."""

from __future__ import annotations

from importlib.metadata import version
from importlib.resources import files

from fastapi import FastAPI
from fastapi.openapi.docs import get_swagger_ui_html
from starlette.requests import Request
from starlette.responses import HTMLResponse, JSONResponse
from starlette.staticfiles import StaticFiles
from uvicorn.middleware.proxy_headers import ProxyHeadersMiddleware

from skiros_py.server.access.gate import Gate
from skiros_py.server.access.openapi import GuardedApi
from skiros_py.server.pages import Pages, pages_of
from skiros_py.server.problems import PREFIX, add_problem_handlers
from skiros_py.server.routes import (
    access,
    alarms,
    documents,
    elements,
    events,
    goals,
    jobs,
    modules,
    ontology,
    operation,
    queries,
    robots,
    scenes,
    tasks,
    webhooks,
    world,
)
from skiros_py.server.services import Services

_ROUTERS = (
    jobs.router, jobs.commands_router, jobs.results_router, goals.router, goals.previews_router, world.router,
    elements.router, ontology.router, queries.router, elements.learned_router, world.locks_router, scenes.router,
    scenes.simulation_router, modules.router, documents.router, tasks.router,
    modules.plugins_router, robots.router, alarms.router, events.router, alarms.stop_router, webhooks.router,
    access.router, access.keys_router, access.session_router, operation.data_router, operation.router,
)  # fmt: skip
"""The routes, in the order in which the documentation shows them."""


def create_app(services: Services) -> FastAPI:
    """Creates the ASGI application of a server.

    Args:
        services: The services that its routes use; started and closed by the caller.
    """
    app = GuardedApi(
        title="skiros-py",
        version=version("skiros-py"),
        summary="Order goals, follow and command the robots that pursue them.",
        openapi_url=None,
        docs_url=None,
        redoc_url=None,
        redirect_slashes=False,
        servers=[{"url": services.settings.public_url.rstrip("/")}] if services.settings.public_url else None,
        telemetry={"tracing": False},  # traces are not collected, and take a tenth of the time of a request
    )
    app.state.services = services
    for router in _ROUTERS:
        app.router.routes += router.routes
    add_documentation(app, PREFIX)
    add_problem_handlers(app)
    app.add_middleware(Gate, services, Pages(pages_of(services.settings)))  # the gate also reads and limits bodies
    if services.settings.trusted_proxies:  # before the gate, which sees client and scheme as they report them
        app.add_middleware(ProxyHeadersMiddleware, trusted_hosts=services.settings.proxy_networks)
    return app


def add_documentation(app: FastAPI, prefix: str) -> None:
    """Adds the description ``openapi.json``, the page ``docs`` that shows it, and the files of that page.

    Args:
        app: The application; it has neither yet.
        prefix: Path prefix of the API.
    """

    def description(_request: Request) -> JSONResponse:  # in a thread: it takes a second to build
        return JSONResponse(app.openapi())

    async def page(_request: Request) -> HTMLResponse:
        return get_swagger_ui_html(
            openapi_url="openapi.json",  # relative, since a proxy may serve it below a prefix
            title=app.title,
            swagger_js_url="docs/assets/swagger-ui-bundle.js",
            swagger_css_url="docs/assets/swagger-ui.css",
            swagger_favicon_url="docs/assets/favicon.png",
        )

    app.add_route(f"{prefix}/openapi.json", description, include_in_schema=False)
    app.add_route(f"{prefix}/docs", page, include_in_schema=False)
    app.mount(f"{prefix}/docs/assets", StaticFiles(directory=str(files("fastapi_offline") / "static")))
