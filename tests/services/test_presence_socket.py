"""What a socket stores of a person's presence, and that it stores nothing after its end."""

import threading
from types import SimpleNamespace

import pytest

from portal.live import presence
from robots.kit.clock import SYSTEM
from tests.waiting import CEILING_S

pytestmark = pytest.mark.service
SLOW_S = 0.5


def test_the_presence_that_a_ping_notes_is_never_noted_after_the_socket_has_ended(monkeypatch):
    """The turn would count as connected, and be kept for minutes instead of 20 s."""
    begun, told = threading.Event(), []
    user = SimpleNamespace(pk=7, is_authenticated=True)

    def seen(*_, **__):
        begun.set()
        SYSTEM.sleep(SLOW_S)
        told.append("here")

    monkeypatch.setattr(presence, "current_user", lambda scope: user)
    monkeypatch.setattr(presence, "Robot", SimpleNamespace(objects=SimpleNamespace(get=lambda slug: slug)))
    monkeypatch.setattr(presence.queue, "note_presence", seen)
    monkeypatch.setattr(presence.queue, "note_disconnection", lambda *_: told.append("left"))
    socket = SimpleNamespace(scope={}, closed=False, lost_by="")
    page = presence.Presence(socket, "mercury", SimpleNamespace(continues_elsewhere=lambda person: False))
    ping = threading.Thread(target=page.mark_seen)
    ping.start()
    assert begun.wait(CEILING_S)
    socket.closed = True
    page.mark_left()
    ping.join(CEILING_S)
    assert told == ["here", "left"]
    page.mark_seen()  # one that was begun before, in a thread that waited
    assert told == ["here", "left"]
