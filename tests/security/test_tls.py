"""Every library that connects by TLS checks the certificate, or the start is refused; tried with a real TLS server."""

import json
import select
import socket
import ssl
import subprocess
import sys

import pytest
from django.conf import settings

from portal.run.processes import housekeeping_process
from tests import starts
from tests.conftest import wait_for
from tests.rig import ROOT, Child, child_env
from tests.security.authority import HOST, Authority, Door
from tests.waiting import CEILING_S


@pytest.fixture(scope="module")
def authority(tmp_path_factory):
    return Authority(tmp_path_factory.mktemp("authority"))


@pytest.fixture
def door(authority):
    made = []

    def opened(serve):
        made.append(Door(authority, serve))
        return made[-1]

    yield opened
    for one in made:
        one.close()


def to_redis(line, secure):
    """Pass everything on, in one thread: OpenSSL reads and writes no connection at once."""
    line, data = secure(line)
    with socket.socket(socket.AF_UNIX) as redis:
        redis.connect(settings.REDIS_URL.removeprefix("unix://"))
        sink = redis
        while data:
            sink.sendall(data)
            ready = [line] if line.pending() else select.select((line, redis), (), ())[0]
            source, sink = (line, redis) if ready[0] is line else (redis, line)
            data = source.recv(65536)


CLIENTS = """
import asyncio, json, os
os.environ["DJANGO_SETTINGS_MODULE"] = "portal.settings"
from portal.run import roles
roles.REDIS_TIMEOUT_S = 60.0  # nothing here is judged by time
import django
django.setup()
import redis.asyncio as aioredis
from django.conf import settings
from django.core.cache import caches
from portal.celery import app
from robots import bus

async def hub():
    connection = aioredis.Redis.from_url(settings.REDIS_URL)
    try:
        await connection.ping()
    finally:
        await connection.aclose()

settings.CELERY_BROKER_TRANSPORT_OPTIONS["max_retries"] = 0

def listen():
    made = bus.listener()
    made.connection_pool.connection_kwargs["socket_connect_timeout"] = 60.0
    made.ping()

def celery(asynchronous):
    with app.connection_for_write() as connection:
        channel = connection.default_channel
        channel._create_client(asynchronous=asynchronous).ping()

WAYS = {
    "the bus": lambda: bus.connection().ping(),
    "its listener": listen,
    "the cache": lambda: caches["default"]._shared.set("tls", 1, 9),
    "the hub": lambda: asyncio.run(hub()),
    "a producer": lambda: celery(False),
    "a consumer": lambda: celery(True),
    "a task": lambda: app.send_task("queueing.tick", queue="of-a-test", retry=False),
}
told = {}
for name, way in WAYS.items():
    try:
        way()
        told[name] = "connected"
    except Exception as error:
        text = f"{type(error).__name__}: {error} {error.__cause__!r}"
        told[name] = "refused" if "CERTIFICATE_VERIFY_FAILED" in text else text
print(json.dumps(told))
"""


def clients(url):
    env = child_env(REDIS_URL=url, FARHAND_ROLE="housekeeping")
    return subprocess.run(
        [sys.executable, "-c", CLIENTS], cwd=ROOT, env=env, capture_output=True, text=True, timeout=CEILING_S
    )


def all_of(done):
    assert done.returncode == 0, done.stderr
    told = json.loads(done.stdout.splitlines()[-1])
    assert len(told) == 7
    return told, set(told.values())


@pytest.mark.asvs("12.3.2")
def test_both_libraries_connect_to_a_redis_of_an_authority_that_is_named(db, redis_server, door, authority):
    one = door(to_redis)
    told, answers = all_of(clients(f"rediss://{HOST}:{one.port}/0?ssl_ca_certs={authority.file}"))
    assert answers == {"connected"}, told
    assert one.opened >= 4


@pytest.mark.asvs("12.3.2")
@pytest.mark.parametrize("what", ["an authority that nobody named", "another name", "another authority"])
def test_both_libraries_refuse_a_certificate_that_does_not_hold(db, redis_server, door, authority, tmp_path, what):
    one = door(to_redis)
    other = Authority(tmp_path).file if what == "another authority" else authority.file
    host = "127.0.0.1" if what == "another name" else HOST
    query = "" if what == "an authority that nobody named" else f"?ssl_ca_certs={other}"
    told, answers = all_of(clients(f"rediss://{host}:{one.port}/0{query}"))
    assert answers == {"refused"}, told
    assert one.opened == 0, "nothing was said, no password either"


@pytest.mark.django_db(transaction=True)
def test_a_worker_consumes_by_tls(redis_server, door, authority):
    from celery import current_app

    from robots import bus

    bus.connection().flushall()
    one = door(to_redis)
    current_app.send_task("robots.clean", queue=bus.HOUSEKEEPING)
    assert bus.connection().llen(bus.HOUSEKEEPING) == 1
    spec = housekeeping_process()
    url = f"rediss://{HOST}:{one.port}/0?ssl_ca_certs={authority.file}"
    worker = Child("housekeeping", list(spec.argv), **{**spec.env, "REDIS_URL": url, "FARHAND_SCHEDULE": ""})
    try:
        wait_for(lambda: not bus.connection().llen(bus.HOUSEKEEPING), CEILING_S, "a worker that takes the task")
        assert "insecure" not in worker.said()
    finally:
        worker.stop()


OF_OWN = "For one of your own authority set ssl_ca_certs"
REFUSED = {
    "rediss://localhost/0?ssl_cert_reqs=none": OF_OWN,
    "rediss://localhost/0?ssl_cert_reqs=optional": OF_OWN,
    "rediss://localhost/0?ssl_cert_reqs=": OF_OWN,
    "rediss://localhost/0?ssl_check_hostname=false": OF_OWN,
    "rediss://localhost/0?ssl_check_hostname=0&ssl_ca_certs=a": OF_OWN,
    "rediss://localhost/0?ssl_min_version=1": "not known here",
    "redis://localhost/0?ssl_cert_reqs=required": "not known here",
    "redis://:pa?ssword@localhost/0": "Write / ? # @ : of its password as %2F %3F %23 %40 %3A",
    "rediss+socket://localhost/0": "has to begin with",
    "REDISS://localhost/0": "has to begin with",
    "localhost:6379": "has to begin with",
}


def test_a_process_with_an_address_that_the_libraries_would_read_differently_does_not_start():
    url = next(iter(REFUSED))
    done = clients(url)
    assert done.returncode != 0
    assert REFUSED[url] in done.stderr.splitlines()[-1]


@pytest.mark.asvs("12.3.2")
def test_an_address_that_the_libraries_would_read_differently_is_refused_at_the_start():
    answers = starts.read("REDIS_URL", [{"REDIS_URL": url} for url in REFUSED], child_env(FARHAND_ROLE="housekeeping"))
    for (url, why), (_, error) in zip(REFUSED.items(), answers, strict=True):
        assert error, url
        assert why in error.splitlines()[-1], url
        assert "pa?" not in error
        assert "ssword@" not in error


BY_TLS = "postgres://user:word@db.example/name"


@pytest.mark.asvs("12.3.2")
def test_a_database_by_tls_without_a_check_is_refused_at_the_start():
    cases = []
    for mode in ("allow", "prefer", "require"):
        cases += [{"DATABASE_URL": f"{BY_TLS}?sslmode={mode}"}, {"DATABASE_URL": BY_TLS, "PGSSLMODE": mode}]
    for case, (_, error) in zip(cases, starts.read("DATABASES", cases, child_env()), strict=True):
        assert error, case
        assert "Set sslmode=verify-full" in error.splitlines()[-1], case
        assert "word" not in error


def test_a_database_with_a_check_or_without_tls_is_taken():
    queries = ("", "?sslmode=disable", "?sslmode=verify-full", "?sslmode=verify-ca&sslrootcert=a.pem")
    answers = starts.read("DATABASES", [{"DATABASE_URL": f"{BY_TLS}{query}"} for query in queries], child_env())
    for query, (value, error) in zip(queries, answers, strict=True):
        assert not error
        assert ("verify" in value) == ("verify" in query), "libpq is told"


def psql(line, secure):
    """Say yes to TLS, as PostgreSQL does."""
    assert line.recv(8) == b"\0\0\0\x08\x04\xd2\x16\x2f"
    line.sendall(b"S")
    secure(line)


@pytest.mark.asvs("12.3.2")
@pytest.mark.parametrize("what", ["the authority", "no authority", "another name"])
def test_the_database_gets_nothing_before_its_certificate_holds(door, authority, tmp_path, what):
    psycopg = pytest.importorskip("psycopg")
    one = door(psql)
    host = "127.0.0.1" if what == "another name" else HOST
    root = tmp_path / "empty.pem"
    root.write_bytes(Authority(tmp_path).file.read_bytes() if what == "no authority" else authority.file.read_bytes())
    with pytest.raises(psycopg.OperationalError) as refused:
        psycopg.connect(
            f"postgresql://user:word@{host}:{one.port}/name?sslmode=verify-full&sslrootcert={root}&gssencmode=disable"
        )
    assert ("certificate" in str(refused.value)) == (what != "the authority")
    assert one.opened == (what == "the authority")


def mail_server(line, secure):
    line.sendall(b"220 here\r\n")
    reader = line.makefile("rb")
    for said in reader:
        if said.upper().startswith(b"EHLO"):
            line.sendall(b"250-here\r\n250-STARTTLS\r\n250 AUTH PLAIN\r\n")
        elif said.upper().startswith(b"STARTTLS"):
            line.sendall(b"220 go on\r\n")
            reader.detach()
            secure(line)
            return
        else:
            line.sendall(b"500 what?\r\n")


def mail_server_by_tls(line, secure):
    secure(line)


@pytest.mark.asvs("12.3.2")
@pytest.mark.parametrize("scheme", ["smtp+tls", "smtp+ssl"])
def test_a_mail_server_gets_no_password_before_its_certificate_holds(door, authority, scheme):
    import environ
    from django.core.mail import get_connection

    one = door(mail_server if scheme == "smtp+tls" else mail_server_by_tls)
    read = environ.Env.email_url_config(f"{scheme}://user:word@{HOST}:{one.port}")
    mail = get_connection(
        read["EMAIL_BACKEND"], host=read["EMAIL_HOST"], port=read["EMAIL_PORT"], username=read["EMAIL_HOST_USER"],
        password=read["EMAIL_HOST_PASSWORD"], use_tls=read.get("EMAIL_USE_TLS", False),
        use_ssl=read.get("EMAIL_USE_SSL", False), timeout=CEILING_S,
    )  # fmt: skip
    with pytest.raises(ssl.SSLCertVerificationError):
        mail.open()
    assert one.opened == 0


def camera(line, secure):
    """Answer as a camera with a motion JPEG does."""
    line, _ = secure(line)
    import cv2
    import numpy as np

    picture = cv2.imencode(".jpg", np.zeros((48, 64), np.uint8))[1].tobytes()
    line.sendall(b"HTTP/1.0 200 OK\r\nContent-Type: multipart/x-mixed-replace; boundary=b\r\n\r\n")
    part = b"--b\r\nContent-Type: image/jpeg\r\nContent-Length: %d\r\n\r\n" % len(picture)
    while True:
        line.sendall(part + picture + b"\r\n")


def snapshot(line, secure):
    line, _ = secure(line)
    import cv2
    import numpy as np

    picture = cv2.imencode(".jpg", np.zeros((48, 64), np.uint8))[1].tobytes()
    line.sendall(b"HTTP/1.0 200 OK\r\nContent-Type: image/jpeg\r\nContent-Length: %d\r\n\r\n" % len(picture) + picture)


SEES = """
import sys
from pathlib import Path
from robots.kit.contract.errors import CameraFault
from workers.media.source import open_camera
source = open_camera(sys.argv[1], Path())
for _ in range(int(sys.argv[2])):
    try:
        print(source.grab(None).shape)
        break
    except CameraFault as error:
        print(error)
"""
HEARS = """
import sys
from pathlib import Path
from workers.media import microphone
microphone.TIMEOUT_S = float(sys.argv[2])
try:
    microphone.Microphone(sys.argv[1], Path())
except microphone.MicrophoneFault as error:
    print(error)
"""


@pytest.mark.asvs("12.3.2")
@pytest.mark.parametrize("what", ["the authority", "no authority", "another name"])
@pytest.mark.parametrize("way", ["snapshot", "stream", "microphone"])
def test_a_camera_and_a_microphone_by_tls_are_checked_whoever_reads_them(door, authority, way, what):
    one = door(snapshot if way == "snapshot" else camera)
    host = "127.0.0.1" if what == "another name" else HOST
    address = f"https://{host}:{one.port}/{'snapshot.jpg' if way == 'snapshot' else 'stream.mjpg'}"
    trusted = {} if what == "no authority" else {"SSL_CERT_FILE": str(authority.file)}
    holds = what == "the authority"
    done = subprocess.run(
        [sys.executable, "-c", HEARS if way == "microphone" else SEES, address, "60" if holds else "1"], cwd=ROOT,
        env={**child_env(), "DJANGO_SETTINGS_MODULE": "portal.settings", **trusted}, capture_output=True, text=True,
        timeout=CEILING_S,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    assert bool(one.opened) == holds, done.stdout
    if way != "microphone":
        assert ("(48, 64)" in done.stdout) == holds
