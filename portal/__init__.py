"""The portal: pages, sockets, settings, and the supervisor of all processes."""

from portal.celery import app as celery_app

__all__ = ["celery_app"]
