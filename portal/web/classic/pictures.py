"""The classic console's pictures: one GIF for each stored still, under a name that cannot be guessed.

"Each image is date and time stamped, so WWW clients that cache the image will only retrieve
the image when it changes (since its filename will be different, due to a different time
stamp)" (Goldberg et al. 1995, section 6.2). Here the name differs too, but one name does not lead to another: it is
signed, for one picture and one person.
"""

import re
from pathlib import Path
from typing import Any

from django.conf import settings
from django.http import Http404, HttpRequest, HttpResponse
from django.shortcuts import get_object_or_404
from django.utils.crypto import constant_time_compare, salted_hmac

from portal.live.snapshot import visible_frame
from robots.kit.drivers.panels import panel_of
from robots.models import Frame, Robot

NAME = re.compile(r"([0-9]{1,18})-[0-9a-f]{64}\Z")
KEEP = "private, max-age=86400, immutable"


def has_classic_console(robot: Robot) -> bool:
    """Return whether the classic console can draw this robot; False if its package is not installed."""
    try:
        return panel_of(robot.driver) is not None
    except (ImportError, OSError):
        return False


def name_of(robot: Robot, frame: Frame | None, user: Any) -> str:
    """Return the name of a picture for `user`, or for everybody who is not signed in.

    The file's name is part of what is signed, because a restored database may use the numbers of pictures again.
    """
    number = frame.pk if frame else 0
    signed = f"{robot.pk}:{number}:{frame.file if frame else ''}:{user.pk or ''}"
    return f"{number}-{salted_hmac('portal.web.classic.picture', signed, algorithm='sha256').hexdigest()}"


def picture(request: HttpRequest, slug: str, name: str) -> HttpResponse:
    """Return the composite GIF of one stored picture, to the person for whom its name was made."""
    robot = get_object_or_404(Robot, slug=slug)
    found = NAME.match(name)
    number = int(found[1]) if found else 0
    frame = Frame.objects.filter(robot=robot, pk=number).first()
    panel = panel_of(robot.driver) if has_classic_console(robot) else None
    if panel is None or not constant_time_compare(name, name_of(robot, frame, request.user)):
        raise Http404("There is no such picture.")
    if frame is not None and visible_frame(frame, request.user) is None:
        raise Http404("This picture is hidden.")
    path = Path(settings.MEDIA_ROOT) / frame.file if frame else None
    drawing = panel.compose(path, robot.description(), frame.joints if frame else [])
    response = HttpResponse(drawing, content_type="image/gif")
    response["Cache-Control"] = KEEP if frame else "no-store"
    return response
