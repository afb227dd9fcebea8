"""Static files as the web process sends them."""

import asyncio
import gzip
import re
from pathlib import Path

import pytest
from django.test import AsyncClient

ICON = Path(__file__).resolve().parents[2] / "portal" / "static" / "portal" / "icon.svg"


def asked(method="get", **headers):
    async def go():
        answer = await getattr(AsyncClient(), method)("/static/portal/icon.svg", headers=headers)
        if answer.status_code == 304 or method == "head":  # Django's client has removed the content, as a server does
            return answer, b"".join(answer.streaming_content)
        return answer, b"".join([piece async for piece in answer.streaming_content])

    return asyncio.run(go())


def test_a_file_is_sent_in_pieces_and_whole():
    answer, content = asked()
    assert (answer.status_code, content) == (200, ICON.read_bytes())
    assert answer.is_async, "else it is read into memory first, with a warning in the log"
    assert answer["Content-Length"] == str(len(content))


def test_a_file_that_the_browser_has_is_not_sent_again():
    answer, content = asked(if_none_match=asked()[0]["ETag"])
    assert (answer.status_code, content) == (304, b"")


def test_only_its_head():
    answer, content = asked("head")
    assert (answer.status_code, content) == (200, b"")
    assert answer["Content-Length"] == str(ICON.stat().st_size)


def test_a_part_of_it():
    answer, content = asked(range="bytes=1-9")
    assert (answer.status_code, content) == (206, ICON.read_bytes()[1:10])


@pytest.mark.service
@pytest.mark.django_db
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
