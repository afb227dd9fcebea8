"""The choice of a member of staff whether alerts come by mail, on their own page."""

from django.contrib import messages
from django.contrib.auth.decorators import login_required
from django.core.exceptions import PermissionDenied
from django.http import HttpRequest, HttpResponse
from django.shortcuts import redirect
from django.utils.translation import gettext
from django.views.decorators.http import require_POST

from portal.web.alerts.models import AlertChoice, may_be_told


@require_POST
@login_required
def choose(request: HttpRequest) -> HttpResponse:
    """Store the choice."""
    if not may_be_told(request.user):
        raise PermissionDenied("Alerts are for staff who may change robots.")
    by_mail = request.POST.get("by_mail") == "on"
    AlertChoice.objects.update_or_create(user_id=request.user.pk or 0, defaults={"by_mail": by_mail})
    messages.success(request, gettext("Alerts come by e-mail.") if by_mail else gettext("No alerts come by e-mail."))
    return redirect("me")
