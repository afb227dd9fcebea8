"""A broadcast in the machine's own network: multicast on the loopback, repairs and segments by HTTP."""

import asyncio
import random
import socket

import pytest
import uvicorn

from portal.broadcast import answers, multicast, running
from portal.broadcast.carousel import Carousel
from portal.broadcast.edge import Edge
from portal.broadcast.repairs import Repairs
from portal.run.serve import config
from tests.broadcasting import KEY, movie, same

GROUP = "239.8.1.77"


def free_port():
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as line:
        line.bind(("127.0.0.1", 0))
        return line.getsockname()[1]


@pytest.fixture
def group():
    """A group that can be heard on the loopback of this machine."""
    group = GROUP, free_port()
    try:
        with multicast.receiver(group, "lo") as hears, multicast.sender("lo") as sends:
            hears.settimeout(2)
            sends.sendto(b"?", group)
            assert hears.recv(10) == b"?"
    except OSError as error:
        pytest.skip(f"no multicast on the loopback of this machine: {error}")
    return group


async def played(group, shown, count, loss):
    """Return the edges of a broadcast after they have the movie, and its repairs."""
    with multicast.sender("lo") as sends:
        carousel = Carousel(KEY, shown.contents, shown.starts_ns, 4, running.now_ns(), 10**6)
        origin = Repairs(carousel, KEY, 10**7, running.now_ns)
        server = uvicorn.Server(config("127.0.0.1", 0, answers.application(origin.answer)))
        serving = asyncio.create_task(server.serve())
        while not server.started:
            await asyncio.sleep(0.01)
        port = server.servers[0].sockets[0].getsockname()[1]
        sending = asyncio.create_task(running.Sending(carousel, running.Line(sends, group)).run())
        lines, edges, hearing = [], [], []
        for seed in range(count):
            numbers = random.Random(seed)
            lines.append(multicast.receiver(group, "lo"))
            edges.append(Edge(KEY, numbers.random))
            one = running.Receiving(
                edges[-1],
                running.Line(lines[-1], group),
                f"http://127.0.0.1:{port}",
                lambda n=numbers: n.random() < loss,
            )
            hearing.append(asyncio.create_task(one.run()))
            await asyncio.sleep(0.03)
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as stranger:
            stranger.sendto(b"x" * 2000, group) if loss else None
        async with asyncio.timeout(60):
            while not all(same(edge, shown) for edge in edges):
                await asyncio.sleep(0.05)
        for task in (sending, *hearing):
            task.cancel()
        server.should_exit = True
        await serving
        for line in lines:
            line.close()
        return edges, origin


def test_ten_edges_play_one_broadcast(group):
    shown = movie(4, 20_000, 300)
    edges, origin = asyncio.run(played(group, shown, 10, 0.01))
    assert all(same(edge, shown) for edge in edges)
    assert sum(edge.repaired for edge in edges) == origin.bytes_sent > 0


def test_a_network_that_loses_half_is_repaired_by_http(group):
    shown = movie(3, 5000, 300)
    edges, _ = asyncio.run(played(group, shown, 2, 0.5))
    assert all(edge.packets_lost > 0 < edge.repaired for edge in edges)
