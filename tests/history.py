"""The history of this tree as git knows it, or the reason why git knows nothing."""

import subprocess
from collections.abc import Sequence
from pathlib import Path


class NoHistory(Exception):
    """Git cannot tell, and why not."""


def git(root: Path, *words: str) -> list[str]:
    """Return the lines that git prints."""
    try:
        done = subprocess.run(["git", *words], cwd=root, capture_output=True, text=True, check=False)
    except OSError as error:
        raise NoHistory("git is not installed") from error
    if done.returncode:
        raise NoHistory((done.stderr.strip() or "git failed").splitlines()[0])
    return done.stdout.splitlines()


def commit(root: Path, but: Sequence[str] = ()) -> str:
    """Return the short hash of the commit, with "+changes" where files other than `but` differ; empty: nobody knows."""
    try:
        (short,) = git(root, "rev-parse", "--short=10", "HEAD")
        others = git(root, "status", "--porcelain", "--", ".", *(f":!{path}" for path in but))
    except NoHistory:
        return ""
    return f"{short}+changes" if others else short


def changed(root: Path, since: str, paths: Sequence[str]) -> list[str]:
    """Return which files below these paths differ from a commit, uncommitted changes included."""
    try:
        git(root, "cat-file", "-e", f"{since}^{{commit}}")
    except NoHistory as error:
        raise NoHistory(f"commit {since} is not in this history: {error}") from error
    return git(root, "diff", "--name-only", since, "--", *paths)
