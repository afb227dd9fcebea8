"""Static files, sent in pieces: WhiteNoise's own answer is read into memory whole for each reader under ASGI."""

from typing import Any

from django.core.handlers.asgi import ASGIRequest
from django.http import HttpRequest
from whitenoise.middleware import WhiteNoiseMiddleware

from portal.web.pages.serving import PIECE, awaited


class StaticFiles(WhiteNoiseMiddleware):
    """WhiteNoise, with answers that an event loop can send."""

    @staticmethod
    def serve(static_file: Any, request: HttpRequest) -> Any:
        """Return the answer with the file."""
        answer = WhiteNoiseMiddleware.serve(static_file, request)
        if isinstance(request, ASGIRequest):
            answer.block_size = PIECE
            answer.streaming_content = awaited(iter(answer.streaming_content))
        return answer
