"""Run a benchmark by name: `make bench NAME=click_to_image`; without a name, list them."""

import sys
from importlib import import_module
from pathlib import Path


def main() -> None:
    """Run one."""
    known = sorted(
        p.stem for p in Path(__file__).parent.glob("*.py") if not p.stem.startswith("_") and p.stem != "stage"
    )
    if len(sys.argv) < 2 or sys.argv[1] not in known:
        sys.exit(f"make bench NAME=… with one of: {', '.join(known)}")
    import_module(f"benchmarks.{sys.argv[1]}").main()


if __name__ == "__main__":
    main()
