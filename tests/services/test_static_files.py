"""The files of pages: compressed when they are built, and sent so to browsers that read it."""

import gzip
import re

import pytest

pytestmark = [pytest.mark.service, pytest.mark.django_db]


@pytest.mark.parametrize("kind", [r"href=\"(/static/app/[^\"]+\.css)", r"src=\"(/static/app/[^\"]+\.js)"])
def test_scripts_and_styles_come_compressed_to_browsers_that_read_it(client, kind):
    address = re.search(kind, client.get("/story/").text)[1]
    plain = client.get(address, headers={"accept-encoding": "identity"})
    short = client.get(address, headers={"accept-encoding": "gzip, deflate"})
    assert "Content-Encoding" not in plain
    assert short["Content-Encoding"] == "gzip"
    assert "Accept-Encoding" in plain["Vary"] and "Accept-Encoding" in short["Vary"]
    body = short.getvalue()
    assert gzip.decompress(body) == plain.getvalue()
    assert 2 * len(body) < int(plain["Content-Length"])
