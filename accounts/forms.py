"""The sign-up form: a known address costs the same work as a new one."""

import secrets
from typing import Any

from allauth.account.forms import SignupForm as BaseSignupForm
from django.contrib import messages
from django.db import IntegrityError, transaction
from django.http import HttpRequest, HttpResponse
from django.shortcuts import redirect
from django.utils.translation import gettext, gettext_lazy

from accounts import handles

RULES = gettext_lazy(
    "8 characters or more, not only digits. No word that many people use, and nothing of yours or of ours."
)


class SignupForm(BaseSignupForm):  # type: ignore[misc]
    """allauth's form, which takes as long for a known address as for a new one."""

    def __init__(self, *args: Any, **kwargs: Any) -> None:
        super().__init__(*args, **kwargs)
        self.fields["username"].help_text = handles.RULES
        self.fields["password1"].help_text = RULES

    def try_save(self, request: HttpRequest) -> tuple[Any, HttpResponse | None]:
        """Create the account; for a known address, create one, roll it back, and mail that an account exists."""
        try:
            if self.account_already_exists:
                self._rehearse(request)
            with transaction.atomic():
                found: tuple[Any, HttpResponse | None] = super().try_save(request)
        except IntegrityError:  # somebody took the handle between check and insert
            messages.error(request, gettext("Somebody has just taken that handle; choose another one."))
            return None, redirect("account_signup")
        return found

    def _rehearse(self, request: HttpRequest) -> None:
        given = self.cleaned_data["email"]
        self.cleaned_data["email"] = f"{secrets.token_hex(8)}@invalid.example"
        self.account_already_exists = False
        try:
            with transaction.atomic():
                self.save(request)
                transaction.set_rollback(True)
        finally:
            self.cleaned_data["email"], self.account_already_exists = given, True
