"""Other ways to send pictures to many viewers, for `fan_out`; and the process that makes the pictures.

``python -m benchmarks._fans serve WAY PORT REDIS`` and ``python -m benchmarks._fans publish WAY REDIS``.
"""

import asyncio
import base64
import hashlib
import resource
import struct
import sys
import time
from typing import Any

import redis.asyncio as aioredis
import uvloop

from robots.kit.packets import PICTURE_HEAD

SIZE, EVERY_S = 6000, 0.1  # bytes of a picture, as the iRat's; seconds between two
CHANNEL = "farhand:mercury:frames"
GUID = b"258EAFA5-E914-47DA-95CA-C5AB0DC85B11"  # RFC 6455
LAYERS = {"group": "RedisChannelLayer", "group_pubsub": "RedisPubSubChannelLayer"}


def layer_of(way: str, store: str) -> Any:
    """Return a channel layer as channels_redis documents it."""
    from benchmarks._beside import needed

    needed("channels_redis")
    if way == "group_pubsub":
        from channels_redis.pubsub import RedisPubSubChannelLayer

        return RedisPubSubChannelLayer(hosts=[store])
    from channels_redis.core import RedisChannelLayer

    return RedisChannelLayer(hosts=[store])


async def publish(way: str, store: str) -> None:
    """Publish a picture ten times a second until standard input ends."""
    picture, n = bytes(SIZE - PICTURE_HEAD.size), 0
    layer = layer_of(way, store) if way in LAYERS else None
    client = aioredis.Redis.from_url(store)
    due = time.monotonic()
    while True:
        due = max(due + EVERY_S, time.monotonic())
        await asyncio.sleep(due - time.monotonic())
        n += 1
        data = PICTURE_HEAD.pack(2, 0, n, int(time.time() * 1000), 0, 0) + picture
        if layer is not None:
            await layer.group_send("pictures", {"type": "picture", "data": data})
        else:
            await client.publish(CHANNEL, data)


class Raw(asyncio.Protocol):
    """The least that a server can do: answer the handshake, then write what it is given."""

    here: set["Raw"] = set()

    def connection_made(self, transport: Any) -> None:
        """Wait for the handshake."""
        self.transport = transport

    def data_received(self, data: bytes) -> None:
        """Answer the handshake; ignore the rest."""
        if self in self.here or b"\r\n\r\n" not in data:
            return
        (key,) = [line[19:].strip() for line in data.split(b"\r\n") if line[:18].lower() == b"sec-websocket-key:"]
        accept = base64.b64encode(hashlib.sha1(key + GUID, usedforsecurity=False).digest())
        self.transport.write(
            b"HTTP/1.1 101 Switching Protocols\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n"
            b"Sec-WebSocket-Accept: " + accept + b"\r\n\r\n"
        )
        self.here.add(self)

    def connection_lost(self, exc: Exception | None) -> None:
        """Forget it."""
        self.here.discard(self)


async def serve_raw(port: int, store: str) -> None:
    """Serve the raw way."""
    await asyncio.get_running_loop().create_server(Raw, "127.0.0.1", port)
    pubsub = aioredis.Redis.from_url(store, socket_timeout=None).pubsub(ignore_subscribe_messages=True)
    await pubsub.subscribe(CHANNEL)
    while True:
        message = await pubsub.get_message(timeout=30.0)
        if message is None:
            continue
        frame = b"\x82\x7e" + struct.pack("!H", len(message["data"])) + message["data"]
        for one in Raw.here:
            one.transport.write(frame)


async def serve_channels(way: str, port: int, store: str) -> None:
    """Serve a Channels consumer for each viewer, with pictures by `group_send`."""
    layer = layer_of(way, store)
    import uvicorn
    from channels.generic.websocket import AsyncWebsocketConsumer
    from django.conf import settings

    settings.configure(CHANNEL_LAYERS={})
    import channels.consumer

    channels.consumer.get_channel_layer = lambda alias: layer

    class Viewer(AsyncWebsocketConsumer):  # type: ignore[misc]
        async def connect(self) -> None:
            await self.channel_layer.group_add("pictures", self.channel_name)
            await self.accept()

        async def picture(self, event: dict[str, Any]) -> None:
            await self.send(bytes_data=event["data"])

    config = uvicorn.Config(
        Viewer.as_asgi(), port=port, ws="websockets-sansio", ws_per_message_deflate=False, access_log=False,
        log_level="warning", lifespan="off", loop="uvloop",
    )  # fmt: skip
    await uvicorn.Server(config).serve()


def many_files() -> None:
    """Allow as many sockets as the system does."""
    _, hard = resource.getrlimit(resource.RLIMIT_NOFILE)
    resource.setrlimit(resource.RLIMIT_NOFILE, (hard, hard))


def main() -> None:
    """Serve or publish."""
    many_files()
    match sys.argv[1:]:
        case ["publish", way, store]:
            uvloop.run(publish(way, store))
        case ["serve", "raw", port, store]:
            uvloop.run(serve_raw(int(port), store))
        case ["serve", way, port, store]:
            uvloop.run(serve_channels(way, int(port), store))
        case _:
            sys.exit(__doc__)


if __name__ == "__main__":
    main()
