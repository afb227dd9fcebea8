"""The admin app with the portal's own site."""

from django.contrib.admin.apps import AdminConfig


class StaffConfig(AdminConfig):
    """Django's admin; its site is `StaffSite`."""

    default_site = "portal.web.staff.site.StaffSite"
