"""Another host on the network: a namespace of its own behind a pair of interfaces, which can be cut."""

import os
import shutil
import subprocess

import pytest

HERE, THERE = "10.203.7.1", "10.203.7.2"


class Host:
    """A namespace; `HERE` is our address as it sees us."""

    name, ours, theirs = "farhand-host", "farhand-here", "farhand-there"

    def __init__(self):
        if os.geteuid() or not shutil.which("ip"):
            pytest.skip("namespaces need root and iproute2")
        self.close()
        if subprocess.run(["ip", "netns", "add", self.name], capture_output=True, check=False).returncode:
            pytest.skip("this system allows no namespaces")
        self._ip("link", "add", self.ours, "type", "veth", "peer", "name", self.theirs, "netns", self.name)
        self._ip("addr", "add", f"{HERE}/30", "dev", self.ours)
        self._ip("-n", self.name, "addr", "add", f"{THERE}/30", "dev", self.theirs)
        for device in ("lo", self.theirs):
            self._ip("-n", self.name, "link", "set", device, "up")
        self.join()

    before = ("ip", "netns", "exec", name)

    @staticmethod
    def _ip(*words):
        subprocess.run(["ip", *words], check=True)

    def cut(self):
        """Nothing passes any more, and nobody is told."""
        self._ip("link", "set", self.ours, "down")

    def join(self):
        self._ip("link", "set", self.ours, "up")

    def close(self):
        subprocess.run(["ip", "netns", "del", self.name], capture_output=True, check=False)
        subprocess.run(["ip", "link", "del", self.ours], capture_output=True, check=False)
