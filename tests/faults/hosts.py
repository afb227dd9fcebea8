"""Another host on the network: a namespace of its own behind a pair of interfaces, which can be cut."""

import os
import shutil
import subprocess

import pytest


class Host:
    """A namespace; `here` is our address as it sees us. Test runs side by side have different ones."""

    def __init__(self):
        number = os.getpid()
        self.name, self.ours, self.theirs = f"fh{number}", f"fh{number}a", f"fh{number}b"
        net, first = f"10.203.{number >> 6 & 255}", (number & 63) * 4
        self.here, there = f"{net}.{first + 1}", f"{net}.{first + 2}"
        self.before = ("ip", "netns", "exec", self.name)
        if os.geteuid() or not shutil.which("ip"):
            pytest.skip("namespaces need root and iproute2")
        self.close()
        if subprocess.run(["ip", "netns", "add", self.name], capture_output=True, check=False).returncode:
            pytest.skip("this system allows no namespaces")
        self._ip("link", "add", self.ours, "type", "veth", "peer", "name", self.theirs, "netns", self.name)
        self._ip("addr", "add", f"{self.here}/30", "dev", self.ours)
        self._ip("-n", self.name, "addr", "add", f"{there}/30", "dev", self.theirs)
        for device in ("lo", self.theirs):
            self._ip("-n", self.name, "link", "set", device, "up")
        self.join()

    @staticmethod
    def _ip(*words):
        subprocess.run(["ip", *words], check=True)

    def cut(self):
        """Let nothing pass any more, and tell nobody."""
        self._ip("link", "set", self.ours, "down")

    def join(self):
        self._ip("link", "set", self.ours, "up")

    def close(self):
        subprocess.run(["ip", "netns", "del", self.name], capture_output=True, check=False)
        subprocess.run(["ip", "link", "del", self.ours], capture_output=True, check=False)
