"""Tells the queues again and again that people can reach this web process and that it reaches the database."""

import asyncio
import logging
from concurrent.futures import ThreadPoolExecutor

from django.db import Error, close_old_connections, connection

from robots.bus import web_uptime
from robots.kit.clock import SYSTEM

log = logging.getLogger(__name__)


def tell() -> None:
    """Tell it once, but not while the database is away: then nobody's presence can be noted."""
    try:
        with connection.cursor() as cursor:
            cursor.execute("SELECT 1")
    except Error:
        return
    web_uptime.tell(SYSTEM.now())


def _look() -> None:
    close_old_connections()
    tell()


async def tell_on() -> None:
    """Tell it until the process ends; an event loop that is blocked tells nothing."""
    thread = ThreadPoolExecutor(1, "uptime")  # with a connection of its own
    while True:
        try:
            await asyncio.get_running_loop().run_in_executor(thread, _look)
        except Exception:
            log.exception("the queues were not told that the web process runs")
        await asyncio.sleep(web_uptime.TELL_S)
