"""Few pages are rendered at once; network addresses take turns."""

import asyncio
from itertools import pairwise

import pytest
from django.http import HttpResponse
from django.test import RequestFactory
from hypothesis import given
from hypothesis import strategies as st

from portal.edge.pages import FairSemaphore, FewPages, leave_room

ADDRESSES = ("192.0.2.1", "198.51.100.7", "2001:db8::1", "2001:db8::2")
steps = st.lists(
    st.tuples(st.sampled_from(("ask", "give up", "leave", "leave")), st.integers(0, 30), st.sampled_from(ADDRESSES)),
    max_size=60,
)


async def settle():
    for _ in range(4):
        await asyncio.sleep(0)


@given(steps, st.integers(1, 3))
def test_no_more_are_in_than_may_be_and_nobody_waits_beside_a_free_place(steps, most):
    async def run():
        semaphore = FairSemaphore(most)
        asked, left = [], set()
        for what, which, address in steps:
            if what == "ask":
                asked.append(asyncio.create_task(semaphore.acquire(address)))
            elif asked and what == "give up":
                asked[which % len(asked)].cancel()
            elif asked and (task := asked[which % len(asked)]).done() and not task.cancelled():
                task.result().leave()
                left.add(task)
            if which % 3:  # else the next step comes in the same moment
                continue
            await settle()
            waiting = [task for task in asked if not task.done()]
            inside = [task for task in asked if task.done() and not task.cancelled() and task not in left]
            assert len(inside) <= most
            assert not waiting or len(inside) == most
        while any(not task.done() for task in asked) or set(asked) - left:
            await settle()
            for task in {task for task in asked if task.done()} - left:
                left.add(task)
                if not task.cancelled():
                    task.result().leave()
        assert [await semaphore.acquire("192.0.2.1") for _ in range(most)]

    asyncio.run(run())


@pytest.mark.asvs("15.2.2")
def test_a_crowd_delays_others_by_one_page_each():
    order = []

    async def ask(semaphore, address):
        room = await semaphore.acquire(address)
        order.append(address)
        await settle()
        room.leave()

    async def run():
        semaphore = FairSemaphore(1)
        crowd = [asyncio.create_task(ask(semaphore, "192.0.2.1")) for _ in range(20)]
        await settle()
        others = [asyncio.create_task(ask(semaphore, "198.51.100.7")) for _ in range(4)]
        await asyncio.gather(*crowd, *others)

    asyncio.run(run())
    last = max(place for place, address in enumerate(order) if address == "198.51.100.7")
    assert all(a != b for a, b in pairwise(order[2:last]))


def test_many_addresses_of_one_network_are_one():
    order = []

    async def ask(semaphore, address):
        room = await semaphore.acquire(address)
        order.append(address)
        room.leave()

    async def run():
        semaphore = FairSemaphore(1)
        first = await semaphore.acquire("192.0.2.1")
        tasks = [asyncio.create_task(ask(semaphore, f"2001:db8::{number}")) for number in range(1, 9)]
        await settle()
        tasks.append(asyncio.create_task(ask(semaphore, "198.51.100.7")))
        await settle()
        first.leave()
        await asyncio.gather(*tasks)

    asyncio.run(run())
    assert order.index("198.51.100.7") == 1


def test_a_room_is_left_once():
    async def run():
        semaphore = FairSemaphore(1)
        room = await semaphore.acquire("192.0.2.1")
        room.leave()
        room.leave()
        await semaphore.acquire("192.0.2.1")
        late = asyncio.create_task(semaphore.acquire("192.0.2.1"))
        await settle()
        assert not late.done()
        late.cancel()

    asyncio.run(run())


@pytest.mark.parametrize("leaves", [False, True])
def test_who_waits_for_a_robot_lets_the_next_page_in(settings, monkeypatch, leaves):
    settings.LIMITS = settings.LIMITS | {"PAGES": 1}
    order = []

    async def run():
        release = asyncio.Event()

        async def answer(handler, request):
            order.append(request.path)
            if request.path == "/waits/":
                if leaves:
                    await asyncio.to_thread(leave_room, request)
                await release.wait()
            return HttpResponse(request.path)

        monkeypatch.setattr("django.core.handlers.asgi.ASGIHandler.get_response_async", answer)
        handler = FewPages()
        requests = [RequestFactory().get(path) for path in ("/waits/", "/second/")]
        tasks = [asyncio.create_task(handler.get_response_async(request)) for request in requests]
        while "/second/" not in order and leaves:
            await asyncio.sleep(0)
        await settle()
        before = list(order)
        release.set()
        assert [response.content.decode() for response in await asyncio.gather(*tasks)] == ["/waits/", "/second/"]
        return before

    assert asyncio.run(run()) == (["/waits/", "/second/"] if leaves else ["/waits/"])


def test_outside_the_handler_nothing_is_left():
    leave_room(RequestFactory().get("/"))
