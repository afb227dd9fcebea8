"""ASGI entry point for pages and sockets."""

import os
from typing import Any

os.environ.setdefault("DJANGO_SETTINGS_MODULE", "portal.settings")

import django
from django.apps import apps

if not apps.ready:  # a second time would set the log up anew
    django.setup(set_prefix=False)

from channels.routing import ProtocolTypeRouter, URLRouter
from channels.sessions import CookieMiddleware
from django.urls import path, re_path

from portal.edge.origins import OwnOrigin, Refused
from portal.edge.pages import FewPages
from portal.edge.requests import Bounded
from portal.live.access import OperatorAccess
from portal.live.person_socket import PersonSocket
from portal.live.robot_socket import RobotSocket
from portal.web.daily.hits import CountedPages

nowhere: Any = Refused(404, "There is no socket at this address.\n")
sockets = URLRouter(
    [
        path("ws/me/", PersonSocket.as_asgi()),
        path("ws/robots/<slug:slug>/", RobotSocket.as_asgi()),
        path("ws/operators/<slug:slug>/", RobotSocket.as_asgi(access=OperatorAccess)),
        re_path("", nowhere),  # last
    ]
)
application = Bounded(
    ProtocolTypeRouter({"http": CountedPages(FewPages()), "websocket": OwnOrigin(CookieMiddleware(sockets))})
)
