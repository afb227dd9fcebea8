"""The former place of `robots.contract.errors`, for robot packages written for version 0.1; it goes with 1.0."""

from robots.contract.errors import *  # noqa: F403
