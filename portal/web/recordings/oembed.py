"""`/oembed/`: the frame of a recording, from a moment on, or of a robot, for a site that knows its link (oembed.com).

It uses no session: the answer is the same for everybody, and of what not everybody may see there is none. All
addresses are of the configured site: no header of a request decides them.
"""

from urllib.parse import parse_qs, urlsplit

from django.conf import settings
from django.contrib.auth.models import AnonymousUser
from django.http import Http404, HttpRequest, JsonResponse
from django.shortcuts import get_object_or_404
from django.urls import Resolver404, resolve, reverse
from django.utils.html import format_html
from django.utils.translation import gettext
from django.views.decorators.http import require_safe

from portal.web.pages.serving import limit_rate
from portal.web.recordings import access, moments
from robots.models import Robot

LONGEST = 500  # characters of a link
WIDTH, HEIGHT = 640, 480  # px of a frame, unless less is asked for
CACHE_S = 3600
NO_LINK = "Give a link of this site as url, for example {}."
NOTHING = "No recording or robot that everybody may see has this link."
BAD_SIZE = "Give {} as a whole number of pixels, at least 1."
ONLY_JSON = "Only format=json is offered."


@require_safe
@limit_rate()
def oembed(request: HttpRequest) -> JsonResponse:
    """Return the frame of the page whose link is the parameter `url`, as oEmbed's type "rich"."""
    if request.GET.get("format", "json") != "json":
        return _refused(ONLY_JSON, 501)
    link = request.GET.get("url", "")
    if not link or len(link) > LONGEST:
        return _refused(NO_LINK.format(f"{settings.SITE_ADDRESS}/robots/mercury/"), 400)
    try:
        width, height = _size(request, "maxwidth", WIDTH), _size(request, "maxheight", HEIGHT)
    except ValueError as error:
        return _refused(str(error), 400)
    try:
        title, address = _framed(link)
    except Http404:
        return _refused(NOTHING, 404)
    frame = '<iframe src="{}" width="{}" height="{}" title="{}" loading="lazy"></iframe>'
    told = {
        "version": "1.0", "type": "rich", "title": title,
        "provider_name": settings.SITE_NAME, "provider_url": f"{settings.SITE_ADDRESS}/", "cache_age": CACHE_S,
        "html": format_html(frame, f"{settings.SITE_ADDRESS}{address}", width, height, title),
        "width": width, "height": height,
    }  # fmt: skip
    return JsonResponse(told, headers={"Cache-Control": "public, max-age=300"})


def _refused(text: str, status: int) -> JsonResponse:
    return JsonResponse({"error": text}, status=status, headers={"Cache-Control": "no-store"})


def _size(request: HttpRequest, name: str, usual: int) -> int:
    """Return the size (px) of the frame: the usual one, or less if the request says so. Raises ValueError."""
    text = request.GET.get(name, "")
    if not text:
        return usual
    if not (text.isascii() and text.isdigit() and text.strip("0")):
        raise ValueError(BAD_SIZE.format(name))
    return min(usual, int(text[-9:]) if len(text.lstrip("0")) <= 9 else usual)


def _framed(link: str) -> tuple[str, str]:
    """Return title and path of the frame for a link of ours. Raises Http404 for all others."""
    if not (link.isascii() and link.isprintable()):  # no link of ours
        raise Http404(NOTHING)
    try:
        asked, site = urlsplit(link), urlsplit(settings.SITE_ADDRESS)
        found = resolve(asked.path)
    except (ValueError, Resolver404) as error:
        raise Http404(NOTHING) from error
    if asked.scheme not in ("http", "https") or asked.netloc.lower() != site.netloc.lower():
        raise Http404(NOTHING)
    if found.url_name in ("recording", "embed-recording"):
        return _of_recording(found.kwargs["key"], parse_qs(asked.query).get("t", [""])[0])
    if found.url_name in ("robot", "embed-robot"):
        robot = get_object_or_404(Robot, slug=found.kwargs["slug"], enabled=True)
        return robot.full_name, reverse("embed-robot", args=[robot.slug])
    raise Http404(NOTHING)


def _of_recording(key: str, text: str) -> tuple[str, str]:
    recording, about = access.visible(key, AnonymousUser())
    if about is None or not about.public:
        raise Http404(access.NONE)
    second, _ = moments.moment_in(text, recording)
    address = reverse("embed-recording", args=[recording.key]) + (f"?t={second}" if second else "")
    title = gettext("{title} on {robot}").format(title=about.title, robot=recording.robot.full_name)
    return title, address
