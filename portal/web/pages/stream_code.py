"""`/robots/<slug>/stream-code/`: a fresh one-time code for the operator's stream."""

from django.http import HttpRequest, JsonResponse
from django.shortcuts import get_object_or_404
from django.views.decorators.cache import never_cache
from django.views.decorators.http import require_POST
from redis.exceptions import RedisError

from portal.edge.attempts import within
from portal.live import codes
from robots.kit.clock import SYSTEM
from robots.kit.contract.errors import GrantOver
from robots.models import Robot

TOO_OFTEN = "This page asks for too many codes; wait a minute."
AWAY = "No code can be kept now; the page goes on without."


@never_cache
@require_POST
def stream_code(request: HttpRequest, slug: str) -> JsonResponse:
    """Give a code to the person who drives the robot; everybody else gets none, and a sentence.

    That is no error: a page asks until it learns that its turn has ended.
    """
    robot = get_object_or_404(Robot, slug=slug)
    now = SYSTEM.now()
    try:
        codes.grant_driven(robot, request.user, now)
        if not within(request, "code"):
            return JsonResponse({"text": TOO_OFTEN}, status=429, headers={"Retry-After": "60"})
        code = codes.give(robot, request.user, now)
    except GrantOver as error:
        return JsonResponse({"code": "", "text": str(error)})
    except (RedisError, OSError):
        return JsonResponse({"text": AWAY}, status=503)
    return JsonResponse({"code": code, "seconds": codes.CODE_S})
