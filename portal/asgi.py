"""ASGI entry point for pages and sockets."""

import os
from typing import Any

os.environ.setdefault("DJANGO_SETTINGS_MODULE", "portal.settings")

import django

django.setup(set_prefix=False)

from channels.routing import ProtocolTypeRouter, URLRouter  # noqa: E402
from channels.sessions import CookieMiddleware  # noqa: E402
from django.urls import path, re_path  # noqa: E402

from portal.limits.pages import FewPages  # noqa: E402
from portal.limits.requests import Bounded  # noqa: E402
from portal.live.consumers import RobotConsumer  # noqa: E402
from portal.live.operators import OperatorConsumer  # noqa: E402
from portal.live.origins import OwnOrigin, Refused  # noqa: E402
from portal.live.person import PersonConsumer  # noqa: E402

nowhere: Any = Refused(404, "There is no socket at this address.\n")
sockets = URLRouter(
    [
        path("ws/me/", PersonConsumer.as_asgi()),
        path("ws/robots/<slug:slug>/", RobotConsumer.as_asgi()),
        path("ws/operators/<slug:slug>/", OperatorConsumer.as_asgi()),
        re_path("", nowhere),  # last
    ]
)
application = Bounded(ProtocolTypeRouter({"http": FewPages(), "websocket": OwnOrigin(CookieMiddleware(sockets))}))
