"""What the frames of a page's sockets say."""

import json

from portal.live.pieces import MARK


def read(data):
    """Return the message of a frame; an empty one of bytes, and of a piece of a long text."""
    return json.loads(data) if isinstance(data, str) and not data.startswith(MARK) else {}
