"""The pages of the admin's models, from its registry: a new model is looked at by itself."""

from django.contrib import admin
from django.test import RequestFactory
from django.urls import reverse


def admin_pages(user):
    """Yield the pages that the person may open: of each model its list, the forms of a new row and of the newest one, its
    history, and what asks before it is deleted."""
    request = RequestFactory().get("/")
    request.user = user
    for model, site in admin.site._registry.items():
        name = f"admin:{model._meta.app_label}_{model._meta.model_name}"
        row = model._default_manager.order_by("-pk").first()
        assert row is not None, f"no row of {model._meta.label} was made"
        yield reverse(f"{name}_changelist")
        if site.has_add_permission(request):
            yield reverse(f"{name}_add")
        yield reverse(f"{name}_change", args=[row.pk])
        yield reverse(f"{name}_history", args=[row.pk])
        if site.has_delete_permission(request, row):
            yield reverse(f"{name}_delete", args=[row.pk])


def lists_that_delete(user):
    """Yield the lists in which rows can be chosen and deleted, which is asked on a page of its own."""
    request = RequestFactory().get("/")
    request.user = user
    for model, site in admin.site._registry.items():
        if "delete_selected" in site.get_actions(request):
            yield reverse(f"admin:{model._meta.app_label}_{model._meta.model_name}_changelist")
