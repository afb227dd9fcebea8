"""The portal: how a request gets in."""

from portal.celery import app as celery_app

__all__ = ["celery_app"]
