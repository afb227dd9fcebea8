"""What `manage.py broadcast` and `manage.py edge` refuse, in a sentence, before they send or hear anything."""

import asyncio
import socket

import pytest
from django.core.management import call_command
from django.core.management.base import CommandError

from portal.management.broadcasting import broadcast_key, listener
from portal.run.processes import broadcast_processes

KEY = "a key of the tests, long"


@pytest.mark.parametrize(
    ("said", "options"),
    [
        ("On eth0, origin and edges need the same FARHAND_BROADCAST_KEY", {"key": "", "interface": "eth0"}),
        ("16 characters", {"key": "short"}),
        ("no multicast group", {"group": "10.0.0.1:5004"}),
        ("no movie that can be broadcast", {}),
        ("25 seconds", {"wait": 0.1}),
        ("25 seconds", {"wait": 26.0}),
        ("m is 1 to 32", {"m": 0}),
        ("hops", {"hops": 300}),
    ],
    ids=str,
)
def test_what_cannot_be_broadcast_is_refused(settings, tmp_path, said, options):
    settings.BROADCAST_KEY = options.pop("key", KEY)
    path = tmp_path / "day.mp4"
    path.write_bytes(b"no movie")
    with pytest.raises(CommandError, match=said):
        call_command("broadcast", str(path), **options)


def test_a_file_that_is_not_there_is_refused(settings, tmp_path):
    settings.BROADCAST_KEY = KEY
    with pytest.raises(CommandError, match="No such file"):
        call_command("broadcast", str(tmp_path / "day.mp4"))


@pytest.mark.parametrize(
    ("said", "options"),
    [
        ("On eth0, origin and edges need the same FARHAND_BROADCAST_KEY", {"key": "", "interface": "eth0"}),
        ("16 characters", {"key": "short"}),
        ("no multicast group", {"group": "239.1.1.1"}),
        ("no interface with this name|No such device", {"interface": "nowhere0"}),
        ("The origin is an address", {"origin": "10.0.0.1:8010"}),
        ("The origin is an address", {"origin": "ftp://origin"}),
        ("Invalid IPv6 URL", {"origin": "http://[::1"}),
        ("memory", {"memory": 0}),
    ],
    ids=str,
)
def test_an_edge_that_cannot_hear_says_why(settings, said, options):
    settings.BROADCAST_KEY = options.pop("key", KEY)
    with pytest.raises(CommandError, match=said):
        call_command("edge", **options)


def test_on_the_machine_itself_origin_and_edges_have_a_key_of_this_installation(settings):
    settings.BROADCAST_KEY = ""
    ours = broadcast_key("lo")
    assert ours == broadcast_key("lo") and len(ours) == 32
    settings.SECRET_KEY = "another installation's, long enough"
    assert broadcast_key("lo") != ours
    settings.BROADCAST_KEY = KEY
    assert broadcast_key("lo") == broadcast_key("eth0") != ours


def test_a_port_that_is_taken_is_told_once_and_waited_for(monkeypatch):
    monkeypatch.setattr("portal.management.broadcasting.AGAIN_S", 0.01)
    said = []

    async def story():
        with socket.create_server(("127.0.0.1", 0)) as taken:
            port = taken.getsockname()[1]
            waiting = asyncio.create_task(listener("127.0.0.1", port, "FARHAND_BROADCAST_PORT", said.append))
            while len(said) < 1:
                await asyncio.sleep(0)
            await asyncio.sleep(0.05)
            assert not waiting.done()
        (await waiting).close()
        return port

    port = asyncio.run(story())
    assert said == [
        f"Port {port} on 127.0.0.1 is taken: stop the other process, or choose another by FARHAND_BROADCAST_PORT. "
        "It is tried every 0.01 s."
    ]


@pytest.mark.parametrize(("port", "edges", "names"), [(0, [8011], []), (8010, [], ["broadcast"]), (8010, [8011, 8012], ["broadcast", "edge 8011", "edge 8012"])])  # fmt: skip
def test_the_supervisor_starts_what_the_settings_say(settings, port, edges, names):
    settings.BROADCAST_PORT, settings.BROADCAST_EDGES = port, edges
    assert [one.name for one in broadcast_processes("127.0.0.1")] == names
