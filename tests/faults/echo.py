"""An ASGI application that answers with the address from which it takes a request to come."""

import json


async def application(scope, receive, send):
    said = json.dumps({"client": scope["client"][0], "scheme": scope["scheme"]}).encode()
    await send({"type": "http.response.start", "status": 200, "headers": [(b"content-length", b"%d" % len(said))]})
    await send({"type": "http.response.body", "body": said})
