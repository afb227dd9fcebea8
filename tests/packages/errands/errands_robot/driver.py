"""The driver of the Mercury arm."""

from robots.kit.drivers.mercury.driver import Driver

__all__ = ("Driver",)
