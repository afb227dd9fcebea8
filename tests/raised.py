"""Everything that a library may raise: each built-in exception, and those of the libraries that are used."""

import asyncio
import builtins
import http.client
import queue
import socket
import ssl
import struct
import termios

import cv2
import serial
from av.error import FFmpegError, InvalidDataError
from websockets.exceptions import InvalidURI, WebSocketException

SECRET = "http://admin:S3cret@cam:80/a.jpg"
MADE = {
    UnicodeDecodeError: UnicodeDecodeError("ascii", b"\xc3", 0, 1, "ordinal not in range"),
    UnicodeEncodeError: UnicodeEncodeError("ascii", "ü", 0, 1, "ordinal not in range"),
    UnicodeTranslateError: UnicodeTranslateError("ü", 0, 1, "bad"),
    BaseExceptionGroup: BaseExceptionGroup("several", [SystemExit(1)]),
    ExceptionGroup: ExceptionGroup("several", [ValueError("x")]),
}
KINDS = [
    found for found in vars(builtins).values()
    if isinstance(found, type) and issubclass(found, BaseException) and found is not KeyboardInterrupt
]  # fmt: skip
OF_LIBRARIES = (
    termios.error(5, "Input/output error"), struct.error("unpack requires 4 bytes"), cv2.error("bad size"), socket.gaierror(-2, "Name or service not known"),
    ssl.SSLError(1, "wrong version number"), http.client.InvalidURL(SECRET), http.client.IncompleteRead(b"x"), serial.SerialException(SECRET),
    FFmpegError(1, "Invalid data", SECRET), InvalidDataError(1, "Invalid data", SECRET), WebSocketException(SECRET), InvalidURI(SECRET, "no"),
    queue.Empty(), asyncio.CancelledError(), OSError(28, "No space left on device", SECRET), OSError(), ValueError(), ValueError("\n\n"), KeyError(SECRET),
)  # fmt: skip
ALL = [*{kind: MADE.get(kind) or kind(SECRET) for kind in KINDS}.values(), *OF_LIBRARIES]
ORDINARY = [error for error in ALL if isinstance(error, Exception)]


def name(error):
    return type(error).__name__
