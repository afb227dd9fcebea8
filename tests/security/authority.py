"""A certificate authority of the tests' own, and a TLS server with its certificate."""

import contextlib
import socket
import ssl
import threading
from datetime import timedelta

from cryptography import x509
from cryptography.hazmat.primitives import hashes, serialization
from cryptography.hazmat.primitives.asymmetric import ec

from robots.kit.clock import SYSTEM
from tests.waiting import CEILING_S

HOST = "localhost"  # the certificate's; 127.0.0.1 is the same server by a name that it has no certificate for


class Authority:
    """A certificate authority of the test's own, with one server's certificate."""

    def __init__(self, folder):
        self.key = ec.generate_private_key(ec.SECP256R1())
        own = x509.Name([x509.NameAttribute(x509.NameOID.COMMON_NAME, "an authority")])
        root = self._made(own, own, self.key, x509.BasicConstraints(ca=True, path_length=None))
        self.file = folder / "authority.pem"
        self.file.write_bytes(root.public_bytes(serialization.Encoding.PEM))
        key = ec.generate_private_key(ec.SECP256R1())
        name = x509.Name([x509.NameAttribute(x509.NameOID.COMMON_NAME, HOST)])
        server = self._made(own, name, key, x509.SubjectAlternativeName([x509.DNSName(HOST)]))
        self.server = folder / "server.pem"
        self.server.write_bytes(
            key.private_bytes(
                serialization.Encoding.PEM, serialization.PrivateFormat.PKCS8, serialization.NoEncryption()
            )
            + server.public_bytes(serialization.Encoding.PEM)
        )

    def _made(self, issuer, name, key, extension):
        now = SYSTEM.now()
        made = x509.CertificateBuilder().issuer_name(issuer).subject_name(name).public_key(key.public_key())
        made = made.serial_number(x509.random_serial_number()).add_extension(extension, critical=False)
        made = made.not_valid_before(now - timedelta(days=1)).not_valid_after(now + timedelta(days=1))
        identifier = x509.SubjectKeyIdentifier.from_public_key(key.public_key())
        known = x509.AuthorityKeyIdentifier.from_issuer_public_key(self.key.public_key())
        made = made.add_extension(identifier, critical=False).add_extension(known, critical=False)
        return made.sign(self.key, hashes.SHA256())


class Door:
    """A TLS server that gives each connection to `serve`; counts what clients said before and after the handshake."""

    def __init__(self, authority, serve):
        self._context = ssl.SSLContext(ssl.PROTOCOL_TLS_SERVER)
        self._context.load_cert_chain(authority.server)
        self._serve = serve
        self.opened = 0
        self._door = socket.create_server(("127.0.0.1", 0))
        self.port = self._door.getsockname()[1]
        threading.Thread(target=self._run, daemon=True).start()

    def _run(self):
        with contextlib.suppress(OSError):
            while True:
                line, _ = self._door.accept()
                threading.Thread(target=self._one, args=(line,), daemon=True).start()

    def _one(self, line):
        with contextlib.ExitStack() as ends, contextlib.suppress(OSError):
            ends.enter_context(line)
            line.settimeout(CEILING_S)
            self._serve(line, lambda line: self._secure(line, ends))

    def _secure(self, line, ends):
        line = ends.enter_context(self._context.wrap_socket(line, server_side=True, do_handshake_on_connect=False))
        line.do_handshake()
        first = line.recv(65536)  # after TLS 1.3's handshake a client that refuses the certificate says so only here
        if first:
            self.opened += 1
        return line, first

    def close(self):
        self._door.close()
