"""A camera that asks for a user and a password: it alone gets them, by basic or digest authentication."""

import base64
import hashlib
import http.server
import json
import logging
import re
import threading
from contextlib import closing

import cv2
import numpy as np
import pytest

from portal.logs.lines import Line
from robots.kit import addresses
from robots.kit.contract.errors import CameraFault
from robots.models import Incident, Robot
from tests.conftest import wait_for
from workers.housekeeping import probe
from workers.media.source import SnapshotCamera, open_camera

USER, PASSWORD, WRITTEN = "ädmin", "S3cret:p@ss/wörd", "%C3%A4dmin:S3cret%3Ap%40ss%2Fw%C3%B6rd"
JPEG = cv2.imencode(".jpg", np.full((48, 64), 120, np.uint8))[1].tobytes()
NONCE, REALM = "dcd98b7102dd2f0e8b11d0f600bfb0c093", "the lab, room 2"
DIGEST = f'Digest realm="{REALM}", nonce="{NONCE}"'


class Handler(http.server.BaseHTTPRequestHandler):
    protocol_version = "HTTP/1.1"

    def do_GET(self):
        said = self.headers.get("Authorization")
        self.server.asked.append((self.path, said))
        stream = self.path.startswith("/stream")
        if self.server.challenges and not self.right(said):
            self.send_response(401)
            for challenge in self.server.challenges:
                self.send_header("WWW-Authenticate", challenge)
            self.send_header("Content-Length", "4")
            self.end_headers()
            self.wfile.write(b"nope")
            return
        self.send_response(200)
        if stream:
            self.send_header("Content-Type", "multipart/x-mixed-replace; boundary=b")
            self.end_headers()
            for _ in range(200):
                if self.server.over.wait(0.02):
                    return
                self.wfile.write(
                    b"--b\r\nContent-Type: image/jpeg\r\nContent-Length: %d\r\n\r\n%s\r\n" % (len(JPEG), JPEG)
                )
            return
        self.send_header("Content-Length", str(len(JPEG)))
        self.end_headers()
        self.wfile.write(JPEG)

    def right(self, said):
        """Judge by RFC 7617 and RFC 7616, written anew."""
        scheme, _, rest = (said or "").partition(" ")
        if scheme == self.server.refuse:
            return False
        if scheme == "Basic":
            return base64.b64decode(rest) == f"{self.server.user}:{self.server.password}".encode()
        if scheme != "Digest":
            return False
        told = {name: value.strip('"') for name, value in re.findall(r'(\w+)=("[^"]*"|[^,\s]+)', rest)}
        made = hashlib.sha256 if told.get("algorithm") == "SHA-256" else hashlib.md5

        def h(text):
            return made(text.encode()).hexdigest()

        user = told["username"].encode("latin-1").decode()
        inner = h(f"{user}:{told['realm']}:{self.server.password}"), h(f"GET:{self.path}")
        if "qop" in told:
            self.server.counted.append(int(told["nc"], 16))
            wanted = h(f"{inner[0]}:{NONCE}:{told['nc']}:{told['cnonce']}:auth:{inner[1]}")
        else:
            wanted = h(f"{inner[0]}:{NONCE}:{inner[1]}")
        return (
            user == self.server.user
            and told["uri"] == self.path
            and told["nonce"] == NONCE
            and told["response"] == wanted
        )

    def log_message(self, *_):
        pass


@pytest.fixture
def camera():
    server = http.server.ThreadingHTTPServer(("127.0.0.1", 0), Handler)
    server.challenges, server.asked, server.counted, server.over = [], [], [], threading.Event()
    server.user, server.password, server.refuse = USER, PASSWORD, ""
    server.at = f"127.0.0.1:{server.server_port}"
    threading.Thread(target=server.serve_forever, args=(0.02,), daemon=True).start()
    yield server
    server.over.set()
    server.shutdown()
    server.server_close()


WAYS = {
    "basic": ['Basic realm="lab"'],
    "digest": [f'{DIGEST}, qop="auth", algorithm=MD5'],
    "digest of RFC 2069": [DIGEST],
    "digest of two kinds": [f'{DIGEST}, qop="auth, auth-int", algorithm=SHA-256', f"{DIGEST}, algorithm=MD5"],
    "one that is not known": [f"{DIGEST}, algorithm=SHA-512-256", f'{DIGEST}, qop="auth"'],
    "both in one header": [f'Basic realm="lab", {DIGEST}, qop="auth"'],
    "basic beside others": ["Negotiate", 'Bearer realm="x"', 'Basic realm="lab"'],
}  # fmt: skip


@pytest.mark.parametrize("way", WAYS)
def test_a_camera_gets_user_and_password_as_it_asks_for_them(camera, tmp_path, way):
    camera.challenges = WAYS[way]
    with closing(open_camera(f"http://{WRITTEN}@{camera.at}/Bücher/snap shot.jpg?größe=2", tmp_path)) as opened:
        for _ in range(3):
            assert opened.grab(0.01).shape == (48, 64)
    first, *others = camera.asked
    assert first[1] is None, "nothing is said before it is asked for"
    assert len(others) == 3, "the camera asks once"
    assert {said.split()[0] for _, said in others} == {"Basic" if way.startswith("basic") else "Digest"}
    assert camera.counted == ([] if "2069" in way or "basic" in way else [1, 2, 3])
    assert first[0].startswith("/B%C3%BCcher/snap%20shot.jpg?gr%C3%B6%C3%9Fe=2&exposure=")


@pytest.mark.parametrize("way", ["basic", "digest"])
def test_a_stream_gets_them_too(camera, tmp_path, way):
    camera.challenges, camera.user, camera.password = WAYS[way], "admin", "S3cret%"
    with closing(open_camera(f"http://admin:S3cret%25@{camera.at}/stream.mjpg", tmp_path)) as opened:
        wait_for(lambda: _seen(opened), 20, "a picture")
    assert camera.asked[0][1] is None


def _seen(opened):
    try:
        return opened.grab(None).shape == (48, 64)
    except CameraFault:
        return False


@pytest.mark.parametrize("place", ["", "someone:else@", "%C3%A4dmin:S3cret%21@"])
@pytest.mark.parametrize("way", WAYS)
def test_wrong_ones_are_said_in_a_sentence(camera, way, place):
    camera.challenges = WAYS[way]
    with closing(SnapshotCamera(f"http://{place}{camera.at}/snapshot.jpg")) as opened:
        for _ in range(2):
            with pytest.raises(CameraFault, match="refuses the user" if place else "asks for a user") as told:
                opened.grab(None)
            assert "S3cret" not in str(told.value)
    assert len(camera.asked) <= 4


@pytest.mark.parametrize("realm", ["x, basic y", "x, Basic realm=y, z", "Basic ", 'x", basic  ="y'])
def test_a_camera_that_asks_for_digest_alone_never_gets_the_password(camera, tmp_path, realm):
    camera.challenges = [f'Digest realm="{realm}", nonce="{NONCE}", algorithm=SHA-512']
    opened = open_camera(f"http://{WRITTEN}@{camera.at}/a.jpg", tmp_path)
    with closing(opened), pytest.raises(CameraFault):
        opened.grab(0.01)
    assert {said for _, said in camera.asked} == {None}
    camera.challenges = [f'Digest realm="{realm}", nonce="{NONCE}", qop="auth"']
    with closing(open_camera(f"http://{WRITTEN}@{camera.at}/a.jpg", tmp_path)) as opened:
        assert opened.grab(0.01).shape == (48, 64)
    assert camera.asked[-1][1].startswith("Digest ")


def test_a_challenge_that_cannot_be_read_is_refused(camera):
    for challenges in (
        ["Digest"], ["Digest realm"], ['Digest realm="a"'], [""], ["Digest realm=, nonce=,"], ["x" * 5000],
        ["Digest " + ",=" * 900], [f"{DIGEST}, qop=auth-int"], [f"{DIGEST}, algorithm=MD5-sess"],
    ):  # fmt: skip
        camera.challenges = challenges
        with (
            closing(SnapshotCamera(f"http://{WRITTEN}@{camera.at}/a.jpg")) as opened,
            pytest.raises(CameraFault, match="refuses"),
        ):
            opened.grab(None)


def test_each_connection_to_a_camera_is_checked_before_anything_is_sent(camera, monkeypatch):
    """A camera that closes its connections is looked up each time; its name may lead elsewhere by then."""
    camera.challenges, checked, answer = WAYS["digest"], [], Handler.send_response
    monkeypatch.setattr(addresses, "check_resolved", lambda *place: checked.append(place))

    def close_then(handler, *what):
        answer(handler, *what)
        handler.send_header("Connection", "close")

    monkeypatch.setattr(Handler, "send_response", close_then)
    with closing(SnapshotCamera(f"http://{WRITTEN}@{camera.at}/a.jpg")) as opened:
        opened.grab(None)
        opened.grab(None)
        assert len(camera.asked) == len(checked) == 3
        monkeypatch.setattr(addresses, "check_resolved", lambda *place: addresses.check_host("169.254.169.254"))
        with pytest.raises(CameraFault, match="machine's own services"):
            opened.grab(None)
    assert len(camera.asked) == 3


def test_a_camera_may_ask_anew_and_a_new_answer_follows(camera):
    camera.challenges = WAYS["basic"]
    with closing(SnapshotCamera(f"http://{WRITTEN}@{camera.at}/a.jpg")) as opened:
        opened.grab(None)
        camera.refuse = "Basic"
        camera.challenges = WAYS["digest"]
        opened.grab(None)
        opened.grab(None)
    assert [said and said.split()[0] for _, said in camera.asked] == [None, "Basic", "Basic", "Digest", "Digest"]


@pytest.mark.parametrize(
    "address, port", [("http://[::1]/a.jpg", 80), ("https://[::1]/a.jpg", 443), ("http://[::1]:81/a.jpg", 81)]
)
def test_an_address_of_version_6_is_one(address, port):
    made = SnapshotCamera(address)
    assert (made._host, made._port) == ("::1", port)


@pytest.mark.parametrize("written", ["a%0D%0AX-Forged: 1:b", "a%22b:c", "a:b%00"])
def test_what_cannot_be_sent_is_refused_before_anything_is(camera, written):
    with pytest.raises(CameraFault, match="cannot be sent"):
        SnapshotCamera(f"http://{written}@{camera.at}/a.jpg")
    assert not camera.asked


@pytest.mark.asvs("16.2.5")
@pytest.mark.django_db(transaction=True)
@pytest.mark.parametrize("address", [
    "http://admin:S3~cret@{at}/snapshot.jpg", "http://admin:S3~cret@{at}/stream.mjpg", "rtsp://admin:S3~cret@{at}/live",
    "http://admin:S3~cret@a..b/snapshot.jpg", "http://admin:S3~cret@169.254.1.1/snapshot.jpg", "http://admin:S3~cret@169.254.1.1/live",
    "http://admin:S3~cret@127.0.0.1:1/stream.mjpg", "http://admin:S3~cret@127.0.0.1:x/a.jpg", "http://admin:S3~/cret@127.0.0.1/a.jpg",
])  # fmt: skip
def test_a_fault_tells_no_password_to_row_page_or_log(camera, robot, people, client, caplog, address):
    from tests.services.owner import made_owner

    camera.challenges = WAYS["digest"]
    Robot.objects.update(camera=address.format(at=camera.at), address="tcp:127.0.0.1:9")
    with caplog.at_level(logging.DEBUG):
        found = probe.probe(Robot.objects.get())
        owner = made_owner(robot, people)
        pictures = type(owner.pictures)(owner.owned.robot, owner.clock, owner.owned.picture)
        with pytest.raises(CameraFault) as told:
            pictures.grab(None)
        owner.connection.refuse(told.value)
    client.force_login(people["ada"])
    page = client.get(f"/robots/{robot.slug}/").content.decode()
    rows = [str(vars(row)) for row in (*Incident.objects.all(), Robot.objects.defer("camera").get())]
    lines = [Line("%(message)s").format(record) for record in caplog.records]
    for text in (json.dumps(found), str(told.value), page, *rows, *lines):
        assert "S3~" not in text, text[max(0, text.find("S3~") - 60) :][:120]
    pictures.close()


@pytest.mark.django_db
def test_staff_who_may_only_look_do_not_see_it(robot, django_user_model, client):
    from django.contrib.auth.models import Permission

    Robot.objects.update(camera="http://admin:S3cret@cam/a.jpg", microphone="rtsp://admin:S3cret@mic/a")
    viewer = django_user_model.objects.create_user("vic", "vic@example.org", "correct horse 42", is_staff=True)
    viewer.user_permissions.set(Permission.objects.filter(codename="view_robot"))
    client.force_login(viewer)
    page = client.get(f"/admin/robots/robot/{robot.pk}/change/").content.decode()
    assert "S3cret" not in page
    assert "http://***@cam/a.jpg" in page
    assert "rtsp://***@mic/a" in page
    root = django_user_model.objects.create_superuser("root2", "root2@example.org", "correct horse 42")
    client.force_login(root)
    assert "http://admin:S3cret@cam/a.jpg" in client.get(f"/admin/robots/robot/{robot.pk}/change/").content.decode()
