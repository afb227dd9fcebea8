"""Counts the pages that people are shown, and from how many different network addresses.

They are counted in memory and added to the rows of the day each minute: hits in the database, addresses by Redis. What
a store does not take is offered again. A process that is killed loses the counts of its last minute.
"""

import asyncio
import logging
import re
from collections import defaultdict
from collections.abc import Awaitable, Callable, MutableMapping
from dataclasses import dataclass, field
from datetime import date
from threading import Lock
from typing import Any

from django.db import Error, IntegrityError, transaction
from django.db.models import F
from django.db.models.functions import Coalesce, Greatest
from redis.exceptions import RedisError

from portal.edge.addresses import network_of
from portal.live.threads import ANYBODY
from portal.web.daily.models import DailyFigures
from robots import bus
from robots.kit.clock import SYSTEM
from robots.models import Robot

log = logging.getLogger(__name__)
Scope = MutableMapping[str, Any]
Send = Callable[[MutableMapping[str, Any]], Awaitable[None]]
EVERY_S = 60.0
MOST = 50_000  # pairs of address and robot that a process remembers until Redis has counted them
ALL = ""  # the whole portal, beside the slugs of robots
LEFT_OUT = ("/admin/", "/embed/")
# programs that say so; `preview` and `facebookexternalhit` fetch a page for its card
PROGRAMS = re.compile(
    rb"bot\b|bot/|crawl|spider|slurp|preview|facebookexternalhit|monitor|probe|uptime|headless|curl|wget|python|httpx"
    rb"|okhttp|java/|go-http|libwww|feed|scan|^mozilla/5\.0$",
    re.IGNORECASE,
)
ROBOT = re.compile(r"/(?:robots|classic)/([-a-zA-Z0-9_]{1,40})/")


@dataclass
class Counts:
    """The hits of one day by slug, and the addresses that Redis has not counted; `whole`: none was left out."""

    hits: dict[str, int] = field(default_factory=lambda: defaultdict(int))
    addresses: dict[str, set[str]] = field(default_factory=lambda: defaultdict(set))
    whole: bool = True

    def remembered(self) -> int:
        """Return how many pairs of address and robot are remembered."""
        return sum(map(len, self.addresses.values()))


class Hits:
    """The hits of one process that are not stored yet."""

    def __init__(self, most: int = MOST) -> None:
        self._most, self._days, self._lock = most, dict[date, Counts](), Lock()

    def note(self, day: date, slug: str, address: str) -> None:
        """Count a page; `slug` is that of its robot, or empty."""
        network = network_of(address)
        with self._lock:
            counts = self._days.setdefault(day, Counts())
            for which in {ALL, slug}:
                counts.hits[which] += 1
                self._remember(counts, which, network)

    def _remember(self, counts: Counts, which: str, network: str) -> None:
        if network in counts.addresses[which]:
            return
        if sum(one.remembered() for one in self._days.values()) < self._most:
            counts.addresses[which].add(network)
        else:
            counts.whole = False

    def take(self) -> dict[date, Counts]:
        """Return what is not stored yet; it is forgotten here."""
        with self._lock:
            taken, self._days = self._days, {}
        return taken

    def put_back(self, left: dict[date, Counts]) -> None:
        """Take back what could not be stored."""
        with self._lock:
            for day, counts in left.items():
                mine = self._days.setdefault(day, Counts())
                mine.whole &= counts.whole
                for slug, hits in counts.hits.items():
                    mine.hits[slug] += hits
                for slug, networks in counts.addresses.items():
                    for network in networks:
                        self._remember(mine, slug, network)

    def empty(self) -> bool:
        """Return whether everything is stored."""
        return not self._days


def is_page(scope: Scope) -> bool:
    """Return whether a person's browser asks for a page that counts."""
    if scope["type"] != "http" or scope["method"] != "GET" or scope["path"].startswith(LEFT_OUT):
        return False
    headers = dict(scope["headers"])
    agent = headers.get(b"user-agent", b"")[:400]
    by_person = bool(agent) and not PROGRAMS.search(agent)
    in_advance = b"prefetch" in headers.get(b"sec-purpose", b"") + headers.get(b"purpose", b"")
    return by_person and not in_advance and headers.get(b"sec-fetch-dest", b"document") == b"document"


def robot_of(path: str) -> str:
    """Return the slug of the robot that a page is about; empty for other pages."""
    match = ROBOT.match(path)
    return match[1] if match else ALL


class CountedPages:
    """ASGI middleware that counts pages; the answer is passed on as it is."""

    def __init__(self, app: Any) -> None:
        self._app, self.hits = app, Hits()
        self._task: asyncio.Task[None] | None = None

    async def __call__(self, scope: Scope, receive: Any, send: Send) -> None:
        """Answer, and count the answer if it is a page."""
        if not is_page(scope):
            await self._app(scope, receive, send)
            return

        async def counted(message: MutableMapping[str, Any]) -> None:
            if _shows_a_page(message):
                self._note(scope)
            await send(message)

        await self._app(scope, receive, counted)

    def _note(self, scope: Scope) -> None:
        address = str((scope.get("client") or ("",))[0])
        self.hits.note(SYSTEM.now().date(), robot_of(scope["path"]), address)
        if self._task is None or self._task.done():
            self._task = asyncio.create_task(self._keep())

    async def _keep(self) -> None:
        """Store each minute, and once after the last hit."""
        while not self.hits.empty():
            await asyncio.sleep(EVERY_S)
            await ANYBODY.orm(store)(self.hits)


def _shows_a_page(message: MutableMapping[str, Any]) -> bool:
    if message["type"] != "http.response.start" or message["status"] != 200:
        return False
    kinds = (value for key, value in message.get("headers", ()) if key.lower() == b"content-type")
    return next(kinds, b"").startswith(b"text/html")


def store(hits: Hits) -> None:
    """Add to the rows of the days what is not stored yet; what a store does not take stays."""
    now, left = SYSTEM.now(), dict[date, Counts]()
    for day, counts in hits.take().items():
        try:
            robots = _robots(counts)
            _add_hits(day, counts, robots)
            counts.hits.clear()
            _count_addresses(day, counts, robots, now)
        except (Error, RedisError, OSError) as error:
            log.warning("hits of %s wait for a store: %s", day, error)
            left[day] = counts
    hits.put_back(left)


def _robots(counts: Counts) -> dict[str, int | None]:
    """Return the keys of rows by slug, of those robots that there are, and of the whole portal."""
    slugs = counts.hits.keys() | counts.addresses.keys()
    return {ALL: None, **dict(Robot.objects.filter(slug__in=slugs).values_list("slug", "pk"))}


@transaction.atomic
def _add_hits(day: date, counts: Counts, robots: dict[str, int | None]) -> None:
    """Add all hits or none, so that they may be offered again."""
    for slug, hits in counts.hits.items():
        if slug in robots:
            change(day, robots[slug], hits=Coalesce(F("hits"), 0) + hits)


def _count_addresses(day: date, counts: Counts, robots: dict[str, int | None], now: Any) -> None:
    seen = {robots[slug] or bus.PORTAL: networks for slug, networks in counts.addresses.items() if slug in robots}
    try:
        found, began = bus.count_addresses(day, seen, now)
    except ValueError:  # the day is over
        counts.whole, found, began = False, dict.fromkeys(seen, 0), False
    if began:  # what was counted before is gone with its salt
        DailyFigures.objects.filter(day=day, addresses__gt=0).update(addresses_whole=False)
    for which, count in found.items():
        robot = None if which == bus.PORTAL else which
        if count:
            change(day, robot, addresses=Greatest(Coalesce(F("addresses"), 0), count))
        if not counts.whole:
            change(day, robot, addresses_whole=False)


def change(day: date, robot: int | None, **values: Any) -> None:
    """Change the row of a day and robot (None: of the portal), which is made if there is none."""
    rows = DailyFigures.objects.filter(day=day, robot=robot)
    if rows.update(**values):
        return
    try:
        with transaction.atomic():
            DailyFigures.objects.create(day=day, robot_id=robot)
    except IntegrityError:  # another process was quicker, or the robot was removed
        pass
    rows.update(**values)
