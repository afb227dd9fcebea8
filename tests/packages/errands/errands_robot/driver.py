"""The driver of the Mercury arm."""

from robots.drivers.mercury.driver import Driver

__all__ = ("Driver",)
