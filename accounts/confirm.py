"""Confirming an address: the link of a mail leads on from any browser, and the mail can be sent again."""

from datetime import timedelta
from typing import Any

from allauth.account import app_settings
from allauth.account.internal.constants import LoginStageKey
from allauth.account.internal.flows.email_verification import send_verification_email_at_login
from allauth.account.internal.stagekit import get_pending_stage
from allauth.account.models import EmailAddress, EmailConfirmationHMAC
from allauth.account.utils import get_next_redirect_url, has_verified_email
from allauth.account.views import ConfirmEmailView
from django.contrib import messages
from django.core import signing
from django.http import HttpRequest, HttpResponse
from django.shortcuts import redirect
from django.urls import reverse
from django.utils.http import urlencode
from django.utils.translation import gettext
from django.views.decorators.http import require_POST

NEXT = "next"


class ConfirmEmail(ConfirmEmailView):  # type: ignore[misc]
    """The page of a mail's link; one by which the address was confirmed before says so, and leads on."""

    def dispatch(self, request: HttpRequest, *args: Any, **kwargs: Any) -> HttpResponse:
        """Lead on at once if the address is confirmed: allauth would call the link invalid."""
        address = _confirmed_by(kwargs["key"])
        if address is None:
            answer: HttpResponse = super().dispatch(request, *args, **kwargs)
            return answer
        _tell_confirmed(request, address.email)
        self.object = EmailConfirmationHMAC(address)
        return redirect(self.get_redirect_url())

    def get_redirect_url(self) -> str:
        """Return the page that the link names; where nobody is signed in, by way of signing in."""
        wanted = self.get_next_url()
        if wanted and not self.request.user.is_authenticated:
            return _with_next("account_login", wanted)
        return str(super().get_redirect_url())


@require_POST
def send_again(request: HttpRequest) -> HttpResponse:
    """Send the mail again to whoever signed up in this browser; a known address gets its mail again, too."""
    login = waiting_login(request)
    if login is None:
        if not request.user.is_authenticated:
            messages.info(request, gettext("Sign in first."))
        return redirect("account_login")
    if _is_confirmed(login):
        _tell_confirmed(request, login.email)
        return redirect(_with_next("account_login", login.redirect_url or "/"))
    if not send_verification_email_at_login(request, login):
        messages.warning(
            request, gettext("A mail was sent within the last three minutes. Wait a little, then send it again.")
        )
    return redirect("account_email_verification_sent")


def waiting_login(request: HttpRequest) -> Any:
    """Return allauth's login of somebody who has to confirm an address, in this browser; None if there is none.

    It has no user if the address that was typed is somebody's already; nothing may tell that from the others.
    """
    stage = get_pending_stage(request)
    return stage.login if stage is not None and stage.key == LoginStageKey.VERIFY_EMAIL.value else None


def entrance(request: HttpRequest, wanted: str) -> str:
    """Return the page by which somebody who is not signed in comes to `wanted`: where they stand with their account."""
    login = waiting_login(request)
    if login is None:
        return _with_next("account_signup", wanted)
    if _is_confirmed(login):
        return _with_next("account_login", wanted)
    return reverse("account_email_verification_sent")


def with_wanted(request: HttpRequest, link: str, account: Any) -> str:
    """Return the link of an account's mail with the page that the person wanted; as it is without one on this site."""
    login = waiting_login(request)
    earlier = login.redirect_url if login is not None and login.user == account else None
    wanted = get_next_redirect_url(request) or earlier
    return f"{link}?{urlencode({NEXT: wanted})}" if wanted else link


def _is_confirmed(login: Any) -> bool:
    """Return whether the address has been confirmed meanwhile, in another browser."""
    return login.user is not None and bool(has_verified_email(login.user, login.email))


def _confirmed_by(key: str) -> EmailAddress | None:
    """Return the confirmed address for which a link was sent; None for one that is open, too old or wrong."""
    try:
        pk = signing.loads(
            key, max_age=timedelta(days=app_settings.EMAIL_CONFIRMATION_EXPIRE_DAYS), salt=app_settings.SALT
        )
    except signing.BadSignature:
        return None
    found: EmailAddress | None = EmailAddress.objects.filter(pk=pk, verified=True).first()
    return found


def _tell_confirmed(request: HttpRequest, email: str) -> None:
    messages.success(request, gettext("You have confirmed %(email)s.") % {"email": email})


def _with_next(page: str, wanted: str) -> str:
    return f"{reverse(page)}?{urlencode({NEXT: wanted})}"
