"""Addresses."""
from django.contrib import admin
from django.urls import path
from portal.pages import health
urlpatterns = [path("admin/", admin.site.urls), path("livez", health.livez)]
