"""The admin of robots: Django imports this package, and each module registers its pages."""

from robots.admin import catalogue, records

__all__ = ("catalogue", "records")
