"""Sends webhooks to permitted targets, in order for each job, until they are accepted or given up."""

from __future__ import annotations

import asyncio
import ipaddress
import logging
import random
import socket
import threading
import time
from collections.abc import Callable, Collection
from contextlib import suppress
from dataclasses import dataclass
from functools import partial
from typing import Any
from urllib.parse import urlsplit

import httpx2

from skiros_py.api.webhooks import DeliveryState
from skiros_py.errors import DiskFault, SkirosError, UsageError
from skiros_py.server.webhooks.store import Post, Subscription, WebhookStore, signed
from skiros_py.station.jobs.views import Announcement
from skiros_py.station.session import Session

Address = ipaddress.IPv4Address | ipaddress.IPv6Address

_PORTS = {"http": 80, "https": 443}


def target_of(url: str, allowed: Collection[str]) -> httpx2.URL:
    """Parses a URL, and checks that its host is allowed.

    Args:
        url: The URL.
        allowed: Hosts, optionally with a port, to which webhooks may be sent.

    Raises:
        UsageError: The URL is not valid, or its host is not allowed; the text names the option that allows it.
    """
    try:
        parts = urlsplit(url)
        host, port = parts.hostname or "", parts.port
    except ValueError as error:
        raise UsageError(f"url: {error}: {url[:200]!r} is no address") from None
    if parts.scheme not in _PORTS or not host:
        raise UsageError(f"url: an address begins with https:// or http://, not as {url[:200]!r}")
    if parts.username is not None or parts.fragment or not url.isascii() or any(c <= " " for c in url):
        raise UsageError("url: user names, fragments, blanks and letters beyond ASCII have no place in the address")
    shown = f"[{host}]" if ":" in host else host
    with_port = f"{shown}:{port or _PORTS[parts.scheme]}"
    if not {host, shown, with_port} & {name.lower() for name in allowed}:
        raise UsageError(
            f"url: webhooks to {with_port} are not allowed: start the server with --webhook-host {with_port}"
        )
    return httpx2.URL(url)


def resolve(target: httpx2.URL) -> Address:
    """Resolves a host once; the connection is made to this very address, even if the name resolves differently later.

    Raises:
        UsageError: The host is unknown, or no webhook may be sent to its address.
    """
    try:
        found = socket.getaddrinfo(target.host, target.port or _PORTS[target.scheme], type=socket.SOCK_STREAM)
    except OSError as error:
        raise UsageError(f"{target.host} is not known: {error.strerror or error}") from None
    addresses = [ipaddress.ip_address(str(where[0]).partition("%")[0]) for *_, where in found]
    refused = [address for address in addresses if _never(address)]
    if refused:
        raise UsageError(f"{target.host} is {refused[0]}, and no webhook goes there")
    return addresses[0]


def _never(address: Address) -> bool:
    """Link-local addresses serve the metadata of cloud machines; the others are not hosts at all."""
    mapped = getattr(address, "ipv4_mapped", None) or address
    reserved = mapped.is_reserved and not mapped.is_loopback  # ::1 is in a reserved network, too
    return bool(mapped.is_link_local or mapped.is_multicast or mapped.is_unspecified or reserved)


_log = logging.getLogger(__name__)


@dataclass(frozen=True, slots=True)
class Patience:
    """Intervals and limits of delivery attempts.

    Attributes:
        first: Time between the first two attempts [s]; doubled for each further one.
        longest: Longest time between two attempts [s].
        timeout: Maximum time for a target to answer [s].
        given_up: Time after which a message becomes a dead letter [s].
        at_once: Maximum number of concurrent messages to one target, each of a different job.
        look: Longest time between two checks for new messages [s]; normally :meth:`WebhookSender.wake` announces them.
    """

    first: float = 1.0
    longest: float = 3600.0
    timeout: float = 10.0
    given_up: float = 24 * 3600.0
    at_once: int = 4
    look: float = 1.0

    def wait(self, attempts: int) -> float:
        """Returns the wait after a number of failed attempts [s], randomised by a fifth."""
        return min(self.longest, self.first * 2.0 ** min(attempts, 30)) * random.uniform(0.8, 1.2)  # noqa: S311


class WebhookSender:
    """Sends in a thread of its own; a slow target delays only itself. Start it, and close it.

    Args:
        store: The messages to send.
        session: Returns the current session, whose jobs are announced.
        tell: Returns the data of a message.
        allowed: Hosts to which messages may be sent.
        on_dead: Called with each message that is given up.
        patience: Intervals and limits of delivery attempts.
    """

    def __init__(
        self,
        store: WebhookStore,
        session: Callable[[], Session],
        tell: Callable[[Announcement], Any],
        allowed: Collection[str],
        *,
        on_dead: Callable[[Post, str], None] = lambda _post, _why: None,
        patience: Patience = Patience(),
    ) -> None:
        self._store = store
        self._session = session
        self._forgotten = 0
        self._tell = tell
        self._allowed = allowed
        self._on_dead = on_dead
        self._patience = patience
        self._loop: asyncio.AbstractEventLoop | None = None
        self._news: asyncio.Event | None = None
        self._ending = False
        self._under_way: dict[tuple[str, str], asyncio.Task[None]] = {}
        self._unreachable: dict[str, tuple[int, float]] = {}
        self._thread = threading.Thread(target=lambda: asyncio.run(self._work()), name="skiros-webhooks", daemon=True)

    def start(self) -> None:
        """Starts to send."""
        self._thread.start()

    def wake(self) -> None:
        """Announces that there may be new messages; does not block; callable from any thread."""
        loop, news = self._loop, self._news
        if loop is not None and news is not None and (self._ending or self._store.seen is not None):
            with suppress(RuntimeError):  # the event loop has just ended
                loop.call_soon_threadsafe(news.set)

    def close(self) -> None:
        """Stops sending; unfinished messages are sent again by the next sender. May be called twice."""
        self._ending = True
        self.wake()
        if self._thread.ident is not None:
            self._thread.join()

    # ------------------------------------------------------------------ in the thread

    async def _work(self) -> None:
        self._loop, self._news = asyncio.get_running_loop(), asyncio.Event()
        limits = httpx2.Limits(max_connections=100)
        async with httpx2.AsyncClient(
            timeout=self._patience.timeout, follow_redirects=False, trust_env=False, limits=limits
        ) as client:
            while not self._ending:
                self._news.clear()
                try:
                    wait = await self._round(client)
                except SkirosError as error:  # such as a full disk: it may be temporary
                    _log.error("webhooks: %s", error)
                    wait = self._patience.look
                with suppress(TimeoutError):
                    await asyncio.wait_for(self._news.wait(), wait)
            for task in self._under_way.values():
                task.cancel()
            await asyncio.gather(*self._under_way.values(), return_exceptions=True)

    async def _round(self, client: httpx2.AsyncClient) -> float:
        """Fetches new messages and starts those due; returns the time until the next one is due [s]."""
        await asyncio.to_thread(self._fetch)
        wait = self._patience.look
        for subscription in self._store.subscriptions:
            if subscription.active:
                wait = min(wait, await self._serve(client, subscription))
        return max(wait, 0.01)

    async def _serve(self, client: httpx2.AsyncClient, subscription: Subscription) -> float:
        """Starts the messages due of one subscription; returns the time until the next check [s]."""
        now = time.time()
        again = self._unreachable.get(subscription.id, (0, 0.0))[1]
        if again > now:
            return again - now
        # Messages in progress are still among those due.
        for post in await asyncio.to_thread(self._store.due, subscription.id, now, 2 * self._patience.at_once):
            if (post.webhook, post.job) not in self._under_way and self._has_room(post.webhook):
                self._begin(client, subscription, post)
        due = await asyncio.to_thread(self._store.next_due, subscription.id, now)
        return self._patience.look if due is None else due - now

    def _fetch(self) -> None:
        """Creates deliveries of new announcements, in transactions of bounded size."""
        jobs = self._session().jobs.store
        if self._store.seen is None:  # without subscriptions, past announcements need not be kept
            if (last := jobs.last_announcement) > self._forgotten:
                jobs.forget_announcements(last)
                self._forgotten = last
            return
        while (seen := self._store.seen) is not None:
            new = jobs.announcements(seen, _BATCH)
            if not new:
                break
            self._store.take(new, self._tell)
            jobs.forget_announcements(self._store.seen or seen)
        if dropped := self._store.drop_oldest():
            _log.warning("webhooks: %d messages are dead letters: too many were waiting", dropped)

    def _has_room(self, webhook: str) -> bool:
        """Returns whether another message may be sent; a target that was unreachable gets one message at a time."""
        under_way = sum(1 for name, _ in self._under_way if name == webhook)
        return under_way < (1 if webhook in self._unreachable else self._patience.at_once)

    def _begin(self, client: httpx2.AsyncClient, subscription: Subscription, post: Post) -> None:
        key = (post.webhook, post.job)
        task = asyncio.create_task(self._send(client, subscription, post))
        self._under_way[key] = task

        def end(_task: asyncio.Task[None]) -> None:
            self._under_way.pop(key, None)
            if self._news is not None:
                self._news.set()

        task.add_done_callback(end)

    async def _send(self, client: httpx2.AsyncClient, subscription: Subscription, post: Post) -> None:
        status, error, reached = await self._try(client, subscription, post)
        now = time.time()
        if reached:
            self._unreachable.pop(post.webhook, None)
        else:
            failures, _ = self._unreachable.get(post.webhook, (0, 0.0))
            self._unreachable[post.webhook] = (failures + 1, now + self._patience.wait(failures))
        dead = bool(error) and now - post.since > self._patience.given_up and post.attempts > 0
        state = DeliveryState.DEAD if dead else DeliveryState.PENDING if error else DeliveryState.DONE
        due = now + self._patience.wait(post.attempts) if state is DeliveryState.PENDING else 0.0
        settle = partial(self._store.settle, post, state, next_try=due, status=status, error=error)
        while True:
            try:
                await asyncio.to_thread(settle)
                break
            except DiskFault as fault:  # it would be sent again if that were not stored
                _log.error("webhooks: %s", fault)
                await asyncio.sleep(self._patience.look)
        if dead:
            self._on_dead(post, error)

    async def _try(
        self, client: httpx2.AsyncClient, subscription: Subscription, post: Post
    ) -> tuple[int | None, str, bool]:
        """Sends a message once; returns the status of the answer, the error, and whether there was an answer."""
        try:
            target = target_of(subscription.url, self._allowed)
            address = await asyncio.to_thread(resolve, target)
            signature = signed(subscription.secret, post.event, post.body, time.time())
            request = client.build_request(
                "POST",
                target.copy_with(host=str(address)),
                headers={**signature, "Host": str(target.netloc, "ascii")},
                content=post.body,
                extensions={
                    "sni_hostname": str(target.raw_host, "ascii")
                },  # verifies the certificate against the host name
            )
            async with asyncio.timeout(self._patience.timeout):
                response = await client.send(request, stream=True)
                await response.aclose()  # the body does not matter, so a long one is not read
        except UsageError as error:
            return None, str(error), False
        except (httpx2.HTTPError, TimeoutError, OSError) as error:
            return None, f"{type(error).__name__}: {error}".rstrip(": "), False
        if response.is_success:
            return response.status_code, "", True
        where = " (redirects are not followed)" if response.is_redirect else ""
        return response.status_code, f"the target answered {response.status_code}{where}", True


_BATCH = 500
