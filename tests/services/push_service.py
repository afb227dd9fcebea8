"""A browser and a push service of the tests' own, after RFC 8030, 8291 and 8292, without the portal's libraries for it."""

import base64
import json
import threading
from dataclasses import dataclass, field

from cryptography.hazmat.primitives.asymmetric import ec, utils
from cryptography.hazmat.primitives.ciphers.aead import AESGCM
from cryptography.hazmat.primitives.hashes import SHA256
from cryptography.hazmat.primitives.kdf.hkdf import HKDF
from cryptography.hazmat.primitives.serialization import Encoding, PublicFormat

from tests.security.authority import HOST, Door
from tests.waiting import CEILING_S

CREATED = b"HTTP/1.1 201 Created\r\nContent-Length: 0\r\n\r\n"


def answer(status, *headers):
    return b"\r\n".join([b"HTTP/1.1 %d X" % status, b"Content-Length: 0", *headers, b"", b""])


def read_b64(text):
    return base64.urlsafe_b64decode(text + "=" * (-len(text) % 4))


def write_b64(data):
    return base64.urlsafe_b64encode(data).decode().rstrip("=")


def point(key):
    return key.public_key().public_bytes(Encoding.X962, PublicFormat.UncompressedPoint)


def derived(salt, secret, info, length):
    return HKDF(SHA256(), length, salt, info).derive(secret)


@dataclass
class Browser:
    """A browser that has subscribed: its keys, and its address at a push service."""

    endpoint: str
    key: ec.EllipticCurvePrivateKey = field(default_factory=lambda: ec.generate_private_key(ec.SECP256R1()))
    secret: bytes = bytes(range(16))

    @property
    def fields(self):
        """What its page sends to the portal."""
        return {"endpoint": self.endpoint, "p256dh": write_b64(point(self.key)), "auth": write_b64(self.secret)}

    def decrypt(self, body):
        """Return the content of a message of one record (RFC 8188, RFC 8291). Raises InvalidTag if it is not for it."""
        salt, length = body[:16], body[20]
        sender, record = body[21 : 21 + length], body[21 + length :]
        shared = self.key.exchange(ec.ECDH(), ec.EllipticCurvePublicKey.from_encoded_point(ec.SECP256R1(), sender))
        ikm = derived(self.secret, shared, b"WebPush: info\0" + point(self.key) + sender, 32)
        key = derived(salt, ikm, b"Content-Encoding: aes128gcm\0", 16)
        nonce = derived(salt, ikm, b"Content-Encoding: nonce\0", 12)
        padded = AESGCM(key).decrypt(nonce, record, None).rstrip(b"\0")
        assert padded.endswith(b"\2"), "the last record"
        return padded[:-1]


@dataclass
class Heard:
    """A request to the push service."""

    line: str
    headers: dict
    body: bytes

    def message(self, browser):
        return json.loads(browser.decrypt(self.body))

    def claims(self):
        """Return the claims of the signature, and the key by which it was made. Raises InvalidSignature."""
        scheme, _, rest = self.headers["authorization"].partition(" ")
        assert scheme == "vapid"
        found = dict(one.strip().split("=", 1) for one in rest.split(","))
        signed, _, signature = found["t"].rpartition(".")
        raw = read_b64(signature)
        assert len(raw) == 64
        r, s = (int.from_bytes(raw[at : at + 32]) for at in (0, 32))
        key = ec.EllipticCurvePublicKey.from_encoded_point(ec.SECP256R1(), read_b64(found["k"]))
        key.verify(utils.encode_dss_signature(r, s), signed.encode(), ec.ECDSA(SHA256()))
        head, claims = (json.loads(read_b64(part)) for part in signed.split("."))
        assert head["alg"] == "ES256"
        return claims, found["k"]


class PushService:
    """A push service by TLS: what it heard, and what it answers, one after the other, or 201."""

    def __init__(self, authority):
        self.heard, self.answers = [], []
        self.hangs = threading.Event()  # while it is set, nobody is answered
        self.let_go = threading.Event()
        self._door = Door(authority, self._serve)
        self.url = f"https://{HOST}:{self._door.port}"

    def browser(self, name="one"):
        return Browser(f"{self.url}/push/{name}")

    def _serve(self, line, secure):
        line, data = secure(line)
        while b"\r\n\r\n" not in data or len(data.partition(b"\r\n\r\n")[2]) < _length(data):
            more = line.recv(65536)
            if not more:
                return
            data += more
        head, _, body = data.partition(b"\r\n\r\n")
        first, *rest = head.decode().split("\r\n")
        self.heard.append(Heard(first, {k.lower(): v for k, v in (one.split(": ", 1) for one in rest)}, body))
        if self.hangs.is_set():
            self.let_go.wait(CEILING_S)
            return
        line.sendall(self.answers.pop(0) if self.answers else CREATED)

    def close(self):
        self.let_go.set()
        self._door.close()


def _length(data):
    lines = data.partition(b"\r\n\r\n")[0].lower().splitlines()
    return next(int(one.split(b":")[1]) for one in lines if one.startswith(b"content-length"))
