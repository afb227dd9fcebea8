"""A web process that runs tells the queues so, and one that is gone or stands still tells nothing."""

import signal

import pytest

from robots import bus
from robots.bus import web_uptime
from robots.kit.clock import SYSTEM
from tests.conftest import wait_for

pytestmark = [pytest.mark.timed, pytest.mark.django_db(transaction=True)]


def told():
    return bus.connection().get(bus.web_up_key())


def test_it_is_told_while_the_process_answers_and_begins_anew_after_it_stood_still(redis_server, house):
    web_uptime.forget()
    web = house.web_process()
    first = wait_for(told, 30, "the web process's word")
    assert web_uptime.up_since(SYSTEM.now()) < SYSTEM.now()
    web.process.send_signal(signal.SIGSTOP)
    try:
        wait_for(lambda: told() is None, 60, "the end of its word")
        now = SYSTEM.now()
        assert web_uptime.up_since(now) == now, "nobody can say that they are present"
    finally:
        web.process.send_signal(signal.SIGCONT)
    again = wait_for(told, 60, "its word again")
    assert float(again) > float(first)
    house.close_web()
    wait_for(lambda: told() is None, 60, "the end of its word")
