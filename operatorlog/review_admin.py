"""The page on which moderators read one entry after the other and decide; it is the admin's page of an entry, too."""

from http import HTTPStatus
from typing import Any
from urllib.parse import urlencode

from django.contrib import messages
from django.contrib.admin.utils import unquote
from django.core.exceptions import PermissionDenied
from django.http import Http404, HttpRequest, HttpResponse, HttpResponseRedirect
from django.template.response import TemplateResponse
from django.urls import URLPattern, path, reverse
from django.utils.translation import gettext
from django.views.decorators.http import require_http_methods

from operatorlog import services
from operatorlog.models import Decision, Entry, HidingReason, Visibility
from robots.admin.bases import GuardedAdmin
from robots.kit.clock import SYSTEM
from robots.kit.plain import whole
from robots.sentences import translate

BY_KEY = 9  # reasons that have a digit
REVIEW = "admin:operatorlog_entry_review"


class ReviewAdmin(GuardedAdmin):
    """Shows one entry at a time with what a moderator may do; the verbs note in its history what was done."""

    def get_urls(self) -> list[URLPattern]:
        """Add the page of the entry that has waited longest."""
        review = require_http_methods(["GET", "HEAD", "POST"])(self.review_view)
        return [
            path("review/", self.admin_site.admin_view(review), name="operatorlog_entry_review"),
            *super().get_urls(),
        ]

    def log_change(self, request: HttpRequest, obj: Any, message: Any) -> Any:
        """Note nothing: the verb did."""

    def review_view(self, request: HttpRequest) -> HttpResponse:
        """Show the oldest entry that waits, after those that were left for later; or undo a decision."""
        if not self.has_change_permission(request):
            raise PermissionDenied
        if request.method == "POST":
            return self._undo(request)
        after = whole(request.GET.get("after", "")) or 0
        return self._show(request, services.to_review().filter(pk__gt=after).order_by("pk").first())

    def change_view(
        self, request: HttpRequest, object_id: str, form_url: str = "", extra_context: Any = None
    ) -> HttpResponse:
        """Show an entry; or decide on it and go on to the next that waits."""
        entry = self.get_object(request, unquote(object_id))
        if not self.has_view_or_change_permission(request, entry):
            raise PermissionDenied
        if entry is None:
            raise Http404(gettext("There is no such entry."))
        return self._decide(request, entry) if request.method == "POST" else self._show(request, entry)

    def _decide(self, request: HttpRequest, entry: Entry) -> HttpResponse:
        if not self.has_change_permission(request, entry):
            raise PermissionDenied
        form = request.POST
        try:
            if form.get("visibility") not in Visibility.values:
                raise services.LogError(gettext("Choose what becomes of the entry."))
            made = services.moderate(
                entry, request.user, Visibility(form["visibility"]), _reason(form.get("reason", "")), SYSTEM.now(),
                form.get("words", ""), whole(form.get("revision", "")) or 0,
            )  # fmt: skip
        except services.Outdated as error:
            return self._show(request, entry, translate(error), HTTPStatus.CONFLICT)
        except services.LogError as error:
            return self._show(request, entry, translate(error), HTTPStatus.UNPROCESSABLE_ENTITY)
        return HttpResponseRedirect(f"{reverse(REVIEW)}?{urlencode({'after': _after(request), 'done': made.pk})}")

    def _undo(self, request: HttpRequest) -> HttpResponse:
        key = whole(request.POST.get("undo", ""))
        decision = Decision.objects.filter(pk=key).select_related("entry").first() if key else None
        if decision is None:
            return self._show(request, None, gettext("There is no such decision."), HTTPStatus.NOT_FOUND)
        try:
            done = services.undo(decision, request.user, SYSTEM.now())
        except services.Outdated as error:
            return self._show(request, decision.entry, translate(error), HTTPStatus.CONFLICT)
        except services.LogError as error:
            return self._show(request, decision.entry, translate(error), HTTPStatus.FORBIDDEN)
        said = gettext("It is undone: the entry is as it was before your decision.")
        messages.success(request, said if done else gettext("It is undone."))
        address = reverse("admin:operatorlog_entry_change", args=[decision.entry_id])
        return HttpResponseRedirect(f"{address}?{urlencode({'after': _after(request)})}")

    def _show(self, request: HttpRequest, entry: Entry | None, problem: str = "", status: int = 200) -> HttpResponse:
        """Show an entry; after a problem, with what was chosen and typed."""
        waiting, after = services.to_review(), _after(request)
        context = {
            **self.admin_site.each_context(request), "opts": self.opts, "title": gettext("Review entries"),
            "problem": problem, "after": after, "done": _done(request), "waiting": waiting.count(),
            "earlier": bool(after) and waiting.filter(pk__lte=after).exists(),
            "may_decide": self.has_change_permission(request, entry),
            "may_delete": self.has_delete_permission(request, entry),
        }  # fmt: skip
        if entry is not None:
            context |= _facts(entry.pk, request.POST if problem else {})
        return TemplateResponse(request, "admin/operatorlog/entry/review.html", context, status=status)


def _facts(key: int, typed: Any) -> dict[str, Any]:
    """Return what a moderator reads about an entry, and what their form has."""
    entry = Entry.objects.select_related("author", "robot", "turn", "frame__robot", "moderated_by").get(pk=key)
    reasons = list(HidingReason.objects.filter(active=True))
    known = {one.text: one.pk for one in reasons}
    before = entry.decisions.filter(undone_at=None).last()
    return {
        "entry": entry, "next": entry.pk if entry.waits else None, "appeal": entry.appeals.filter(answer=None).last(),
        "before": before, "text_changed": before is not None and before.text != entry.text,
        "picture_changed": before is not None and before.picture != (entry.frame.file if entry.frame else ""),
        "reasons": [(one, n if n <= BY_KEY else "") for n, one in enumerate(reasons, 1)],
        "chosen": whole(typed.get("reason", "")) if typed else known.get(entry.hidden_reason),
        "words": typed.get("words", "") if typed else
        entry.hidden_words if entry.hidden_reason in known else entry.why_hidden,
    }  # fmt: skip


def _reason(key: str) -> str:
    """Return the text of the chosen reason; empty if none is chosen. Raises LogError."""
    if not key:
        return ""
    number = whole(key)
    found = HidingReason.objects.filter(pk=number, active=True).first() if number is not None else None
    if found is None:
        raise services.LogError(gettext("Choose one of the reasons of the page."))
    return found.text


def _after(request: HttpRequest) -> int:
    """Return the key of the entry that was left for later last; 0 for none."""
    return whole((request.POST if request.method == "POST" else request.GET).get("after", "")) or 0


def _done(request: HttpRequest) -> Decision | None:
    """Return the person's own decision that the page tells, and offers to undo."""
    key = whole(request.GET.get("done", ""))
    own = Decision.objects.filter(by=request.user.pk, undone_at=None).select_related("entry__author")
    return own.filter(pk=key).first() if key else None
