"""``skiros serve``: a station that factory systems, clients and people reach over the network."""

from __future__ import annotations

import shlex
import signal
import sys
import tempfile
from collections.abc import Iterator
from contextlib import ExitStack, closing, contextmanager, suppress
from dataclasses import fields, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

import click

from skiros_py.cli.ending import STOPS, end_now, end_unless, no_warnings_on_stderr
from skiros_py.cli.options import JSON, PLANNER, SKILLS, cell_options, data_option
from skiros_py.cli.output import NOT_REACHED, REACHED, STOPPED, answer
from skiros_py.errors import FileError, SkirosError, UsageError, escaped
from skiros_py.interruptions import UserStop
from skiros_py.system import require_extra

if TYPE_CHECKING:
    from socket import socket

    from skiros_py.server.services import Services
    from skiros_py.server.serving import Serving
    from skiros_py.server.settings import ServerSettings
    from skiros_py.station.session import Options


_OF_ACCESS = ("access.db", "access.db-wal", "access.db-shm", "access.db-commits")


@contextmanager
def rollback_first_start(data: Path) -> Iterator[None]:
    """Removes the data directory if the block created it and then failed.

    The world in it is discarded by its owner; files that others added meanwhile are kept.
    """
    made = [folder for folder in (data, *data.parents) if not folder.exists()]
    try:
        yield
    except SkirosError:
        if made:
            _remove(made)
        raise


def _remove(made: list[Path]) -> None:
    """Removes folders, the innermost first; failures are ignored."""
    from skiros_py.server.access.keys import KeyStore
    from skiros_py.world.journal.data_directory import DirectoryLock

    data = made[0]
    with suppress(OSError, FileError):  # FileError: somebody else uses it by now
        lock = DirectoryLock(data)
        try:
            more: object = {file.name for file in data.iterdir()} - {*_OF_ACCESS, "lock"}
            if not more:
                with closing(KeyStore(data)) as keys:
                    more = keys.all()
            if not more:  # than a server makes before it opens its world
                for name in (*_OF_ACCESS, "lock"):
                    (data / name).unlink(missing_ok=True)
        finally:
            lock.release()
        for folder in made:
            folder.rmdir()


_OVERRUN = 0.5
"""For how long a module may hold the control cycle at a pace [s]: it shares the interpreter with requests here."""
_OVERRUN_SIMULATED = 2.0
"""The same for simulated robots: their time stands still meanwhile, and a busy machine is not the module's fault."""
_ENDING = 9.0
"""Maximum time from the first signal to the end of the process [s]."""


@click.command(
    "serve",
    epilog="""\b
Examples:
  skiros serve kitting
  skiros serve kitting --data cell
  skiros serve --data cell --port 8080 --log json
  skiros serve kitting --data try --fake --pace max
""",
)
@click.argument("scene", required=False, default="")
@data_option(required=False)
@click.option("--host", default="127.0.0.1", show_default=True, help="Address; other than loopback requires keys.")
@click.option("--port", type=click.IntRange(0, 65535), default=8000, show_default=True, help="0 for any free one.")
@cell_options("real")
@click.option("--robot", metavar="NAME", help="The robot to use.  [default: all robots of the scene]")
@SKILLS
@PLANNER
@click.option(
    "--auth",
    "authentication",
    type=click.Choice(["auto", "keys", "none"]),
    default="auto",
    show_default=True,
    help="Whether requests need a key; auto: as soon as there is one.",
)
@click.option(
    "--allow-host", "allowed_hosts", multiple=True, metavar="NAME", help="Another name of the server; may be repeated."
)
@click.option(
    "--allow-origin",
    "allowed_origins",
    multiple=True,
    metavar="ORIGIN",
    help="Web pages that may use it, such as https://mes.example.",
)
@click.option("--public-url", default="", metavar="URL", help="Where a proxy serves it: https://robots.example/cell-1.")
@click.option(
    "--trusted-proxy",
    "trusted_proxies",
    multiple=True,
    metavar="NETWORK",
    help="Proxies whose X-Forwarded-For and X-Forwarded-Proto are believed; may be repeated.",
)
@click.option(
    "--webhook-host", "webhook_hosts", multiple=True, metavar="HOST", help="Permitted target of webhooks: HOST[:PORT]."
)
@click.option(
    "--log", type=click.Choice(["console", "json"]), default="console", show_default=True, help="Format of the log."
)
@JSON
def command(scene: str, data: Path | None, log: Literal["console", "json"], as_json: bool, **given: Any) -> int:
    """Serves SCENE, or the world that lives in the data directory, until Ctrl-C or SIGTERM.

    SCENE is the first content of a new data directory, and can be left out afterwards: world, jobs and keys live on
    there; without --data all of that is gone at the end. The API is below /api/v1, with a page that describes it at
    /api/v1/docs; where the web pages are installed, they are at /. At the end the robots come to a standstill, and
    running jobs wait for a person at the next start.
    """
    require_extra("server", "skiros serve")
    from skiros_py.server.monitoring import log_to
    from skiros_py.server.serving import bind, switching_quickly
    from skiros_py.server.settings import ServerSettings
    from skiros_py.station.session import Options

    settings = ServerSettings(**{one.name: given.pop(one.name) for one in fields(ServerSettings) if one.name in given})
    overrun = _OVERRUN if given["driver"] else _OVERRUN_SIMULATED
    options = Options(data=data, overrun=None if given["pace"] is None else overrun, **given)
    if data is None and not scene:
        raise UsageError(
            "say what is served: skiros serve SCENE, or skiros serve --data DIR where a world lives already"
        )
    if data is not None and not (scene or _lives(data)):
        raise UsageError(f"{data}: no world lives here yet; say with which scene it begins: skiros serve SCENE …")
    with ExitStack() as stack:
        stack.enter_context(switching_quickly())
        listening = stack.enter_context(closing(bind(settings)))
        stops = stack.enter_context(_Stops(as_json=as_json).heard())
        if data is None:
            options = replace(options, data=Path(stack.enter_context(tempfile.TemporaryDirectory(prefix="skiros-"))))
            click.echo("data    for this time only: --data DIR keeps world, jobs and keys", err=True)
        no_warnings_on_stderr()
        log_to(sys.stderr, form=log)
        with suppress(UserStop):  # ended before it was up
            _serve(scene, options, settings, listening, stops, as_json=as_json)
    return REACHED


def _lives(data: Path) -> bool:
    return (data / "journal.db").exists()


def _serve(
    scene: str, options: Options, settings: ServerSettings, listening: socket, stops: _Stops, *, as_json: bool
) -> None:
    from skiros_py.server.pages import pages_of
    from skiros_py.server.services import Services
    from skiros_py.server.serving import Serving, announced, url_of
    from skiros_py.station.session import Session
    from skiros_py.station.worlds import why_not_loaded

    data = options.data
    assert data is not None
    lives = _lives(data)
    click.echo(f"opening {data if lives else scene} …", err=True)
    with ExitStack() as stack:
        with rollback_first_start(data):
            services = stack.enter_context(Services(lambda: Session(scene, options), data, settings))
        why = why_not_loaded(data, services.station.session.world, scene) if scene and lives else ""
        if why:
            click.echo(f"world   {escaped(why)}; choose another --data to begin it", err=True)
        url = url_of(listening)

        def on_listening() -> None:
            stack.enter_context(announced(data, url, services.keys.local_token))
            _say_where(services, url, data, as_json=as_json)
            if pages_of(settings) is not None and not as_json:  # a program that starts the server opens no pages
                click.echo(f"pages   {settings.public_url.rstrip('/') or url}/ for people", err=True)
                models = (group.model for group in services.station.session.spec.groups if group.model)
                services.station.robot_models.prepare(models)  # takes some seconds once

        serving = Serving(services, listening, on_listening)
        stops.serving = serving
        serving.run()
        click.echo("ending  the robots come to a standstill; running jobs wait for a person", err=True)


def _say_where(services: Services, url: str, data: Path, *, as_json: bool) -> None:
    if as_json:
        answer({"url": url, "data": str(data)})
    click.echo(f"serving {url}, API reference at {url}/api/v1/docs", err=True)
    if services.authenticator.keys_needed:
        click.echo("access  with a key; your own programs on this machine find theirs through --data", err=True)
    else:
        locking = f"skiros key create NAME --role admin --data {shlex.quote(str(data))}"
        click.echo(f"access  for all users of this machine; to require keys, run '{locking}'", err=True)


class _Stops:
    """Handles Ctrl-C and SIGTERM: the first ends the server in an orderly way, the second immediately.

    Attributes:
        serving: What the first of them ends; before it is set, they end the opening.
    """

    serving: Serving | None = None

    def __init__(self, *, as_json: bool) -> None:
        self._as_json = as_json
        self._asked = self._left = False

    @contextmanager
    def heard(self) -> Iterator[_Stops]:
        """Handles them while the block runs, and ensures that it ends."""
        for number in STOPS:
            signal.signal(number, self._hear)
        try:
            yield self
        finally:
            self._left = True

    def _hear(self, _number: int, _frame: object) -> None:
        if self._asked:
            end_now(STOPPED)
        self._asked = True
        text = f"something does not come to its end within {_ENDING:.0f} s: the server ends without it"
        end_unless(lambda: self._left, text, NOT_REACHED, as_json=self._as_json, within=_ENDING)
        if self.serving is None:
            raise UserStop
        self.serving.end()
