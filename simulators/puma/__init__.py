"""The PUMA 560 in MuJoCo, which is imported by `simulators.common.arm` first."""

import simulators.common.arm  # noqa: F401
