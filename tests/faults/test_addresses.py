"""The web process believes X-Forwarded-For and X-Forwarded-Proto from trusted proxies alone."""

import json
import os
import subprocess
import urllib.request

import pytest

from portal.run.processes import web_process
from tests.conftest import wait_for
from tests.rig import ROOT, free_port

pytestmark = pytest.mark.timed


@pytest.fixture
def seen():
    """Start uvicorn with the web process's own arguments, and ask it who it believes to be talking with."""
    made = []

    def ask(proxies, **headers):
        port = free_port()
        argv = [*web_process("127.0.0.1", port).argv, "--app", "tests.faults.echo:application"]
        env = {**os.environ, "FORWARDED_ALLOW_IPS": "127.0.0.1", "FARHAND_TRUSTED_PROXIES": ",".join(proxies)}
        made.append(subprocess.Popen(argv, cwd=ROOT, env=env))
        request = urllib.request.Request(f"http://127.0.0.1:{port}/", headers=headers)

        def answer():
            try:
                with urllib.request.urlopen(request, timeout=5) as got:
                    return json.loads(got.read())
            except OSError:
                return None

        return wait_for(answer, 30, "uvicorn")

    yield ask
    for one in made:
        one.kill()
        one.wait()


@pytest.mark.asvs("4.1.3", "15.3.4")
@pytest.mark.parametrize(
    ("proxies", "told", "client", "scheme"),
    [
        ([], "203.0.113.9", "127.0.0.1", "http"),
        (["10.0.3.0/28"], "203.0.113.9", "127.0.0.1", "http"),
        (["127.0.0.1/32"], "203.0.113.9", "203.0.113.9", "https"),
        (
            ["127.0.0.1/32"],
            "198.51.100.1, 203.0.113.9",
            "203.0.113.9",
            "https",
        ),  # the left one is the client's own word
    ],
)
def test_only_a_trusted_proxy_tells_an_address(seen, proxies, told, client, scheme):
    assert seen(proxies, **{"X-Forwarded-For": told, "X-Forwarded-Proto": "https"}) == {
        "client": client,
        "scheme": scheme,
    }
