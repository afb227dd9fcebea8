"""What `manage.py broadcast` and `manage.py edge` refuse, in a sentence, before they send or hear anything."""

import pytest
from django.core.management import call_command
from django.core.management.base import CommandError

KEY = "a key of the tests, long"


@pytest.mark.parametrize(
    ("said", "options"),
    [
        ("16 characters", {"key": ""}),
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
        ("16 characters", {"key": ""}),
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
