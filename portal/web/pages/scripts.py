"""JSON for the scripts of a robot's page: people's programs, and codes for the operator's stream."""

import json
from typing import Any

from django.http import HttpRequest, JsonResponse, RawPostDataException
from django.shortcuts import get_object_or_404
from django.utils.translation import gettext
from django.views.decorators.cache import never_cache
from django.views.decorators.http import require_POST
from redis.exceptions import RedisError

from portal.edge.attempts import within
from portal.live import codes
from robots.kit.clock import SYSTEM
from robots.kit.contract.errors import BadRequest, GrantOver, NotPermitted, RobotError
from robots.kit.plain import one_line
from robots.models import Program, Robot
from robots.sentences import translate
from robots.services import programs

LARGEST = 80_000  # bytes: the longest program and name, whose characters take twelve bytes each at most in JSON


def _shown(program: Program, user: Any) -> dict[str, Any]:
    return {
        "id": program.pk, "name": one_line(program.name), "text": program.text, "shared": program.shared,
        "approved": program.approved, "by": program.author.username if program.author else "",
        "mine": program.author_id is not None and program.author_id == user.pk,
    }  # fmt: skip


@never_cache
def programs_of(request: HttpRequest, slug: str) -> JsonResponse:
    """List programs (GET), save one (POST), delete one (DELETE).

    `kind`, in the query and in what is saved, is the command that runs them; without it the robot's first language.
    """
    robot = get_object_or_404(Robot, slug=slug)
    try:
        if request.method == "POST":
            said = _said(request)
            pk = said.get("id")
            saved = programs.save(
                robot, request.user, str(said.get("name", "")), str(said.get("text", "")), said.get("shared") is True,
                SYSTEM.now(), pk if isinstance(pk, int) and not isinstance(pk, bool) else None,
                str(said.get("kind", "")),
            )  # fmt: skip
            return JsonResponse(_shown(saved, request.user))
        if request.method == "DELETE":
            pk = _said(request).get("id")
            programs.delete(robot, request.user, pk if isinstance(pk, int) else 0)
            return JsonResponse({})
        found = programs.visible(robot, request.user, request.GET.get("kind", ""))[:200]
    except RobotError as error:
        status = 403 if isinstance(error, NotPermitted) else 400
        return JsonResponse({"error": translate(error)}, status=status)
    return JsonResponse({"programs": [_shown(p, request.user) for p in found]})


def _said(request: HttpRequest) -> dict[str, Any]:
    try:
        said = json.loads(request.body[: LARGEST + 1])
    except (ValueError, RecursionError, RawPostDataException) as error:
        raise BadRequest(gettext("The request is not JSON.")) from error
    if not isinstance(said, dict):
        raise BadRequest(gettext("The request is not a JSON object."))
    return said


@never_cache
@require_POST
def stream_code(request: HttpRequest, slug: str) -> JsonResponse:
    """Give a code to the person who drives the robot; everybody else gets an empty code and a sentence.

    An empty code is no error: a page asks until it learns that its turn has ended.
    """
    robot = get_object_or_404(Robot, slug=slug)
    now = SYSTEM.now()
    try:
        codes.grant_driven(robot, request.user, now)
        if not within(request, "code"):
            return JsonResponse(
                {"text": gettext("This page asks for too many codes; wait a minute.")},
                status=429,
                headers={"Retry-After": "60"},
            )
        code = codes.give(robot, request.user, now)
    except GrantOver as error:
        return JsonResponse({"code": "", "text": translate(error)})
    except (RedisError, OSError):
        return JsonResponse({"text": gettext("No code can be kept now; the page goes on without.")}, status=503)
    return JsonResponse({"code": code, "seconds": codes.CODE_S})
