"""What becomes of messages: against real HTTP targets."""

import json
import threading
import time
from collections import defaultdict
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from types import SimpleNamespace

import pytest
from standardwebhooks import Webhook as Checker
from standardwebhooks import WebhookVerificationError

from skiros_py.api.webhooks import Deliveries, DeliveryState
from skiros_py.errors import UnknownName
from skiros_py.server.webhooks.sender import Patience, WebhookSender
from skiros_py.server.webhooks.store import Subscription, WebhookStore, new_secret
from skiros_py.tasks.jobs.job import Job, JobOrder, JobState
from skiros_py.tasks.jobs.store import Announcement

_QUICK = Patience(first=0.02, longest=0.1, timeout=0.5, look=0.05)


class _Target:
    """An HTTP server that keeps what it gets and answers as it is told to."""

    def __init__(self, port: int = 0) -> None:
        self.got: list[tuple[dict[str, str], bytes]] = []
        self.answer: Callable[[BaseHTTPRequestHandler, dict], None] = lambda handler, _event: _status(handler, 200)
        target = self

        class Handler(BaseHTTPRequestHandler):
            def do_POST(self) -> None:
                body = self.rfile.read(int(self.headers["content-length"]))
                target.got.append(({k.lower(): v for k, v in self.headers.items()}, body))
                target.answer(self, json.loads(body))

            def log_message(self, *_args: object) -> None:
                pass

        self._server = ThreadingHTTPServer(("127.0.0.1", port), Handler)
        self._server.daemon_threads = True
        self._thread = threading.Thread(target=self._server.serve_forever, args=(0.02,))
        self._thread.start()
        self.port = self._server.server_address[1]

    @property
    def events(self) -> list[dict]:
        return [json.loads(body) for _, body in self.got]

    def close(self) -> None:
        self._server.shutdown()
        self._thread.join()
        self._server.server_close()


def _status(handler: BaseHTTPRequestHandler, status: int, **headers: str) -> None:
    handler.send_response(status)
    for name, value in headers.items():
        handler.send_header(name, value)
    handler.send_header("Content-Length", "0")
    handler.end_headers()


@pytest.fixture
def target() -> Iterator[_Target]:
    made = _Target()
    yield made
    made.close()


class _Jobs:
    """The announcements of a job store."""

    def __init__(self) -> None:
        self.all: list[Announcement] = []
        self.forgotten = 0

    def announce(self, job: str, state: JobState = JobState.ENDED) -> None:
        number = len(self.all) + 1
        made = Job(order=JobOrder(id=job, goal=("x",)), number=number, state=state)
        self.all.append(Announcement(number, time.time(), made, "finish"))

    @property
    def last_announcement(self) -> int:
        return len(self.all)

    def announcements(self, number: int, most: int) -> list[Announcement]:
        return self.all[number : number + most]

    def forget_announcements(self, upto: int) -> None:
        self.forgotten = upto


@contextmanager
def _office(tmp_path, jobs, *, patience=_QUICK, allowed=("127.0.0.1",), dead=None) -> Iterator[tuple]:
    store = WebhookStore(tmp_path / "webhooks.db", "urn:test")
    told = [] if dead is None else dead
    office = WebhookSender(
        store,
        lambda: SimpleNamespace(jobs=SimpleNamespace(store=jobs)),
        lambda one: {"job": one.job.id, "number": one.number},
        allowed,
        on_dead=lambda post, why: told.append((post.job, why)),
        patience=patience,
    )
    office.start()
    try:
        yield store, office
    finally:
        office.close()
        store.close()


_ALL = {"states": (), "jobs": "", "description": "", "active": True}


def _subscribe(store: WebhookStore, url: str, name: str = "wh_1", **more) -> Subscription:
    made = Subscription(id=name, url=url, secret=new_secret(), created=time.time(), **{**_ALL, **more})
    store.add(made, 0)
    return made


def _until(true: Callable[[], bool]) -> None:
    deadline = time.monotonic() + 20.0
    while not true():
        assert time.monotonic() < deadline, "it does not come about"
        time.sleep(0.01)


def _done(store: WebhookStore, number: int) -> Callable[[], bool]:
    return lambda: len(store.posts(None, "done", None, 1000)) == number


def test_a_message_is_a_signed_cloud_event(tmp_path, target):
    jobs = _Jobs()
    with _office(tmp_path, jobs) as (store, office):
        one = _subscribe(store, f"http://127.0.0.1:{target.port}/hook")
        jobs.announce("j1")
        office.wake()
        _until(_done(store, 1))

    headers, body = target.got[0]
    event = json.loads(body)
    assert headers["content-type"] == "application/cloudevents+json"
    assert (event["specversion"], event["type"], event["subject"]) == ("1.0", "io.skiros.job.state.v1", "j1")
    assert event["data"] == {"job": "j1", "number": 1}
    assert Checker(one.secret).verify(body, headers) == event
    with pytest.raises(WebhookVerificationError):
        Checker(one.secret).verify(body.replace(b"j1", b"j2"), headers)


def test_messages_of_one_job_arrive_in_order_even_if_the_target_fails_sometimes(tmp_path, target):
    failing = defaultdict(int)

    def now_and_then(handler: BaseHTTPRequestHandler, event: dict) -> None:
        failing[event["id"]] += 1
        _status(handler, 500 if failing[event["id"]] < 3 and event["data"]["number"] % 2 else 200)

    target.answer = now_and_then
    jobs = _Jobs()
    for number in range(20):
        jobs.announce(f"j{number % 3}")
    with _office(tmp_path, jobs) as (store, _):
        _subscribe(store, f"http://127.0.0.1:{target.port}/")
        _until(_done(store, 20))

    for job in ("j0", "j1", "j2"):
        numbers = [e["data"]["number"] for e in target.events if e["subject"] == job]
        assert numbers == sorted(numbers)
        assert len(set(numbers)) == sum(one.job.id == job for one in jobs.all)


def test_a_webhook_that_cannot_be_read_delays_no_others_and_can_be_removed(tmp_path, target):
    jobs = _Jobs()
    with _office(tmp_path, jobs) as (store, office):
        _subscribe(store, f"http://127.0.0.1:{target.port}/", "wh_torn")
        _subscribe(store, f"http://127.0.0.1:{target.port}/")
        with store._database.transaction() as connection:
            connection.execute("UPDATE subscriptions SET data = '{' WHERE id = 'wh_torn'")
        jobs.announce("j1")
        office.wake()
        _until(_done(store, 1))
        _until(lambda: jobs.forgotten == 1)
        assert [one.id for one in store.subscriptions] == ["wh_1"]
        store.remove("wh_torn")
        with pytest.raises(UnknownName):
            store.remove("wh_torn")


def test_every_try_of_a_message_has_the_same_id(tmp_path, target):
    answers = iter([500, 503, 200])
    target.answer = lambda handler, _event: _status(handler, next(answers))
    jobs = _Jobs()
    jobs.announce("j1")
    with _office(tmp_path, jobs) as (store, _):
        _subscribe(store, f"http://127.0.0.1:{target.port}/")
        _until(_done(store, 1))

    assert len(target.got) == 3
    assert len({event["id"] for event in target.events}) == 1


def test_a_slow_target_does_not_delay_others(tmp_path, target):
    slow, free = _Target(), threading.Event()
    slow.answer = lambda handler, _event: (free.wait(10), _status(handler, 200))
    jobs = _Jobs()
    for number in range(10):
        jobs.announce(f"j{number}")
    try:
        with _office(tmp_path, jobs, patience=Patience(first=0.02, longest=0.1, timeout=8.0, look=0.05)) as (store, _):
            _subscribe(store, f"http://127.0.0.1:{slow.port}/", "wh_slow")
            _subscribe(store, f"http://127.0.0.1:{target.port}/", "wh_quick")
            _until(lambda: len(store.posts("wh_quick", "done", None, 100)) == 10)
            assert not store.posts("wh_slow", "done", None, 100)
            free.set()
            _until(lambda: len(store.posts("wh_slow", "done", None, 100)) == 10)
    finally:
        free.set()
        slow.close()


def test_thousands_of_messages_for_a_dead_or_resting_target_delay_no_other(tmp_path, target):
    gone = _Target()
    gone.close()
    jobs = _Jobs()
    for number in range(2000):
        jobs.announce(f"j{number % 700}")
    with _office(tmp_path, jobs) as (store, _):
        _subscribe(store, f"http://127.0.0.1:{gone.port}/", "wh_dead")
        _subscribe(store, f"http://127.0.0.1:{target.port}/", "wh_resting", active=False)
        _subscribe(store, f"http://127.0.0.1:{target.port}/", "wh_well", jobs="j1")
        wanted = sum(one.job.id.startswith("j1") for one in jobs.all)
        _until(lambda: len(target.got) == wanted)

    for job in {event["subject"] for event in target.events}:
        numbers = [event["data"]["number"] for event in target.events if event["subject"] == job]
        assert numbers == sorted(set(numbers))


def test_when_the_queue_is_full_the_oldest_messages_become_dead_letters(tmp_path, target, monkeypatch):
    monkeypatch.setattr("skiros_py.server.webhooks.store._LETTERBOX", 5)
    jobs = _Jobs()
    for _ in range(8):
        jobs.announce("j1")
    with _office(tmp_path, jobs) as (store, office):
        _subscribe(store, f"http://127.0.0.1:{target.port}/", active=False)
        _until(lambda: len(store.posts(None, "dead", None, 10)) == 3)
        store.change("wh_1", active=True)
        office.wake()
        _until(_done(store, 5))
    assert [event["data"]["number"] for event in target.events] == [4, 5, 6, 7, 8]


def test_a_redirect_is_not_followed(tmp_path, target):
    inner = _Target()
    target.answer = lambda handler, _event: _status(handler, 307, Location=f"http://127.0.0.1:{inner.port}/secret")
    jobs = _Jobs()
    jobs.announce("j1")
    try:
        with _office(tmp_path, jobs, allowed=(f"127.0.0.1:{target.port}",)) as (store, _):
            _subscribe(store, f"http://127.0.0.1:{target.port}/")
            _until(lambda: len(target.got) >= 3)
            (post,) = store.posts(None, None, None, 10)
            assert "redirects are not followed" in post.error
            assert not inner.got
    finally:
        inner.close()


def test_an_endless_response_of_a_target_is_not_read(tmp_path, target):
    written = []

    def flood(handler: BaseHTTPRequestHandler, _event: dict) -> None:
        handler.send_response(200)
        handler.end_headers()
        try:
            for _ in range(1000):
                handler.wfile.write(b"x" * 100_000)
                written.append(100_000)
        except OSError:
            written.append(-1)

    target.answer = flood
    jobs = _Jobs()
    jobs.announce("j1")
    with _office(tmp_path, jobs) as (store, _):
        _subscribe(store, f"http://127.0.0.1:{target.port}/")
        _until(_done(store, 1))
        _until(lambda: bool(written) and written[-1] == -1)


def test_an_unreachable_target_gets_all_messages_when_it_is_back(tmp_path):
    gone = _Target()
    port = gone.port
    gone.close()
    jobs = _Jobs()
    for number in range(5):
        jobs.announce(f"j{number}")
    with _office(tmp_path, jobs) as (store, _):
        _subscribe(store, f"http://127.0.0.1:{port}/")
        _until(lambda: any(post.attempts > 1 for post in store.posts(None, "pending", None, 10)))
        back = _Target(port)
        try:
            _until(_done(store, 5))
        finally:
            back.close()
    assert {event["subject"] for event in back.events} == {f"j{n}" for n in range(5)}


def test_a_message_undelivered_for_a_day_is_a_dead_letter_and_the_next_one_is_sent(tmp_path, target):
    target.answer = lambda handler, event: _status(handler, 500 if event["data"]["number"] == 1 else 200)
    jobs, dead = _Jobs(), []
    jobs.announce("j1")
    jobs.announce("j1")
    patience = Patience(first=0.02, longest=0.05, timeout=0.5, look=0.05, given_up=0.2)
    with _office(tmp_path, jobs, patience=patience, dead=dead) as (store, office):
        _subscribe(store, f"http://127.0.0.1:{target.port}/")
        _until(lambda: len(store.posts(None, "dead", None, 10)) == 1)
        _until(_done(store, 1))
        assert dead == [("j1", "the target answered 500")]
        target.answer = lambda handler, _event: _status(handler, 200)
        store.redeliver("wh_1", 1, time.time())
        office.wake()
        _until(_done(store, 2))


def test_a_restart_sends_undelivered_messages_and_repeats_no_delivered_ones(tmp_path, target):
    jobs = _Jobs()
    jobs.announce("j1")
    with _office(tmp_path, jobs) as (store, _):
        _subscribe(store, f"http://127.0.0.1:{target.port}/")
        _until(_done(store, 1))
    jobs.announce("j1")
    with _office(tmp_path, jobs) as (store, _):
        _until(_done(store, 2))

    assert [event["data"]["number"] for event in target.events] == [1, 2]
    assert [event["sequence"] for event in target.events] == sorted(e["sequence"] for e in target.events)


def test_a_webhook_receives_only_its_selected_events(tmp_path, target):
    jobs = _Jobs()
    jobs.announce("line-1-a", JobState.RUNNING)
    jobs.announce("line-1-a", JobState.ENDED)
    jobs.announce("line-2-a", JobState.ENDED)
    with _office(tmp_path, jobs) as (store, _):
        _subscribe(store, f"http://127.0.0.1:{target.port}/", states=("Ended",), jobs="line-1-")
        _until(_done(store, 1))
        _until(lambda: jobs.forgotten == 3)

    assert [event["data"]["number"] for event in target.events] == [2]


def test_without_webhooks_announcements_are_not_kept(tmp_path):
    jobs = _Jobs()
    for _ in range(3):
        jobs.announce("j1")
    with _office(tmp_path, jobs):
        _until(lambda: jobs.forgotten == 3)


def test_a_resting_webhook_receives_missed_messages_later(tmp_path, target):
    jobs = _Jobs()
    jobs.announce("j1")
    with _office(tmp_path, jobs) as (store, office):
        _subscribe(store, f"http://127.0.0.1:{target.port}/", active=False)
        _until(lambda: len(store.posts(None, "pending", None, 10)) == 1)
        assert not target.got
        store.change("wh_1", active=True)
        office.wake()
        _until(_done(store, 1))


def test_without_allowed_hosts_nothing_is_sent(tmp_path, target):
    jobs = _Jobs()
    jobs.announce("j1")
    with _office(tmp_path, jobs, allowed=()) as (store, _):
        _subscribe(store, f"http://127.0.0.1:{target.port}/")
        _until(lambda: any("--webhook-host" in post.error for post in store.posts(None, "pending", None, 10)))
    assert not target.got


def test_webhook_secrets_are_readable_only_by_the_owner_of_the_file(tmp_path):
    store = WebhookStore(tmp_path / "webhooks.db", "urn:test")
    store.close()
    assert (tmp_path / "webhooks.db").stat().st_mode & 0o077 == 0
    assert DeliveryState("dead") is DeliveryState.DEAD


def test_pages_of_messages_of_several_webhooks_are_complete_and_without_repeats(tmp_path):
    store = WebhookStore(tmp_path / "webhooks.db", "urn:test")
    for name in ("wh_1", "wh_2", "wh_3"):
        _subscribe(store, "http://127.0.0.1:1/", name)
        for _ in range(2):
            store.ping(name, time.time())

    shown, before = [], None
    while page := store.posts(None, "pending", before, 2):
        shown += [(post.number, post.webhook) for post in page]
        before = shown[-1]
    store.close()

    assert shown == [(number, f"wh_{name}") for number in (2, 1) for name in (3, 2, 1)]


def test_a_delivery_is_listed_without_its_body(tmp_path):
    store = WebhookStore(tmp_path / "webhooks.db", "urn:test")
    _subscribe(store, "http://127.0.0.1:1/")
    store.ping("wh_1", 1_800_000_000.0)

    (listed,) = Deliveries(items=store.posts(None, None, None, 10), next=None).model_dump(mode="json")["items"]
    store.close()

    assert "body" not in listed
    assert (listed["created"], listed["next_try"]) == ("2027-01-15T08:00:00Z", None)
