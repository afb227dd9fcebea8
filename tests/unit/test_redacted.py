"""Passwords in addresses stand in no text: not in sentences for people, not in the log."""

import logging
import os
import subprocess
import sys
from urllib.parse import quote

import pytest
from hypothesis import given
from hypothesis import strategies as st

from portal.logs.lines import Line
from robots.kit.addresses import AddressError, check_cameras, check_robot, redacted
from robots.kit.contract.errors import CameraFault, LineGone, RobotError, why

TEXTS = {
    "http://admin:S3cret@cam:80/a.jpg": "http://***@cam:80/a.jpg",
    "[Errno 111] Connection refused: 'rtsp://admin:S3cret@cam:1/live'": "[Errno 111] Connection refused: 'rtsp://***@cam:1/live'",
    "'admin:S3cret@127.0.0.1' is not the name of a machine.": "'***@127.0.0.1' is not the name of a machine.",
    "ws://token-S3cret@robot:9090": "ws://***@robot:9090",
    "redis://:S3cr@et@host:6379/0": "redis://***@host:6379/0",
    "postgres://portal:S3/cret@host/name": "postgres://***@host/name",
    "smtp+tls://user:S3cret@mail:587": "smtp+tls://***@mail:587",
    "http://cam/snap.cgi?usr=admin&pwd=S3cret&u=1": "http://cam/snap.cgi?usr=admin&pwd=***&u=1",
    "rtsp://cam/user=admin_password=S3cret": "rtsp://cam/user=admin_password=***",
    "host=db user=portal password=S3cret port=1": "host=db user=portal password=*** port=1",
    "http://cam/a.jpg?token=S3cret#x": "http://cam/a.jpg?token=***#x",
    "/snap?user=a&pw=S3cret&x=1": "/snap?user=a&pw=***&x=1",
    "PW=S3cret": "PW=***",
    "Authorization: Basic OlMzY3JldA==": "Authorization: Basic ***",
    "{'Authorization': 'Bearer S3cret', 'a': 1}": "{'Authorization': 'Bearer ***', 'a': 1}",
    'Digest username="S3cret", realm="S3cret", nc=00000001, response="S3cret" was refused': "Digest *** was refused",
}  # fmt: skip


@pytest.mark.asvs("16.2.5")
@pytest.mark.parametrize("text", TEXTS)
def test_no_secret_of_an_address_is_left(text):
    assert redacted(text) == TEXTS[text]
    assert redacted(redacted(text)) == TEXTS[text]
    assert "S3cret" not in str(RobotError(text))
    assert "S3cret" not in str(AddressError(text))
    assert "S3cret" not in why(OSError(text))


@pytest.mark.parametrize("text", [
    "", "The camera does not answer.", "write to ada@example.org", "x is 1.5; it must be from 0 to 1 m",
    "The camera asks for Digest authentication.", "Basic authorization fails", "a raw=1 of mpw=2", "Basic",
    "http://cam.example.org:8080/a.jpg?size=2", "File \"/srv/a.py\", line 3, in run", "@", "a@", ":@"[:1],
])  # fmt: skip
def test_other_text_stays(text):
    assert redacted(text) == text


@given(st.text(min_size=1), st.text(min_size=1), st.text())
def test_an_address_built_from_anything_leaves_no_password(user, password, around):
    password = "S3cret" + password
    for quoted in (quote(password, safe=""), password.replace(" ", "").replace("@", "")):
        word = "".join(f"http://{quote(user, safe='')}:{quoted}@cam/x".split())
        assert "S3cret" not in redacted(f"{around} {word} {around}")


@pytest.mark.asvs("16.2.5")
def test_lines_and_tracebacks_of_the_log_have_none():
    try:
        try:
            raise OSError(111, "Connection refused", "rtsp://admin:S3cret@cam/live")
        except OSError as error:
            raise LineGone(f"It cannot be reached: {error}.") from error
    except LineGone:
        record = logging.LogRecord("x", 40, __file__, 1, "%s", ("http://u:S3cret@cam/",), sys.exc_info())
    text = Line("%(levelname)s %(message)s").format(record)
    assert "S3cret" not in text
    assert "rtsp://***@cam/live" in text


@pytest.mark.parametrize("check", [check_robot, check_cameras])
@pytest.mark.parametrize("text", [
    "tcp:admin:S3cret@host:80", "http://admin:S3cret@169.254.169.254/", "http://admin:S3cret@a..b/", "http://admin:S3cret@cam:x/",
    "http://admin:S3/cret@cam/", "ftp://admin:S3cret@cam/",
])  # fmt: skip
def test_a_refused_address_is_refused_without_its_password(check, text):
    with pytest.raises(AddressError) as refused:
        check(text)
    assert "S3" not in str(refused.value)


def test_a_sentence_is_kept_whole():
    assert str(CameraFault("The camera does not answer.")) == "The camera does not answer."


@pytest.mark.asvs("16.2.5")
@pytest.mark.parametrize("name, url", [
    ("DATABASE_URL", "postgres://portal:S3/cret@host/name"), ("DATABASE_URL", "postgres://portal:pw@host:S3cret/name"),
    ("REDIS_URL", "redis://:S3/cret@host:6379/0"), ("REDIS_URL", "rediss://:pw@host:S3cret/0"), ("EMAIL_URL", "smtp+tls://user:S3/cret@host:587"),
])  # fmt: skip
def test_a_url_that_cannot_be_read_is_refused_at_the_start_without_its_password(name, url, tmp_path):
    env = {
        **os.environ,
        "FARHAND_VAR": str(tmp_path),
        "DATABASE_URL": "sqlite:///:memory:",
        "EMAIL_URL": "consolemail://",
        name: url,
    }
    done = subprocess.run(
        [sys.executable, "-c", "import portal.settings"], env=env, capture_output=True, text=True, check=False
    )
    assert done.returncode == 1
    assert f"{name} cannot be read" in done.stderr
    assert "S3" not in done.stdout + done.stderr
