"""The benchmarks: print how fast everything is, and whether that meets the targets, as one JSON document.

python3 dev.py bench [--quick] [--only NAME]... [--out FILE]
"""

import argparse
import importlib
import json
import os
import platform
import sys
from importlib.metadata import version
from pathlib import Path
from typing import Any

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))

from benchmarks.figures import Figure

# In this order: processes that are started inherit what memory this one takes.
BENCHMARKS = {
    "cold": ("processes", "cold"),
    "cached": ("processes", "cached"),
    "atlas": ("processes", "atlas"),
    "thesis": ("processes", "thesis"),
    "neighbours": ("neighbours", "measure"),
    "curves": ("curves", "measure"),
    "survival": ("survival", "measure"),
    "sweeps": ("sweeps", "measure"),
    "strides": ("strides", "measure"),
}


def machine() -> dict[str, Any]:
    """Describe where the figures were taken."""
    return {
        "processor": processor(),
        "cores": os.cpu_count(),
        "load": os.getloadavg(),
        "python": platform.python_version(),
        **{name: version(name) for name in ("numba", "numpy", "scipy", "heyoka")},
    }


def processor() -> str:
    """Name of the processor, if the system tells."""
    path = Path("/proc/cpuinfo")
    lines = path.read_text().splitlines() if path.exists() else []
    names = [line.split(":", 1)[1].strip() for line in lines if line.startswith("model name")]
    return names[0] if names else platform.processor()


def arguments() -> argparse.Namespace:
    """Read the command line."""
    parser = argparse.ArgumentParser(prog="dev.py bench", description="Measure how fast Legspring is.")
    parser.add_argument("--quick", action="store_true", help="fewer strides and rounds: rough figures")
    parser.add_argument("--only", action="append", choices=BENCHMARKS, help="may be repeated")
    parser.add_argument("--out", type=Path, metavar="FILE", help="write the JSON there, too")
    return parser.parse_args()


def main() -> None:
    """Run the benchmarks: the JSON goes to the output, a table to the error stream."""
    options = arguments()
    result: dict[str, Any] = {"machine": machine(), "quick": options.quick, "figures": []}
    print(f"{'':58s} {'':17s} {'must / aim':>14s}", file=sys.stderr)
    for name, (module, function) in BENCHMARKS.items():
        if options.only and name not in options.only:
            continue
        figures: list[Figure] = getattr(importlib.import_module(f"benchmarks.{module}"), function)(options.quick)
        for figure in figures:
            print(figure.line(), file=sys.stderr, flush=True)
            result["figures"].append(figure.as_json())
    result["machine"]["load_at_end"] = os.getloadavg()
    text = json.dumps(result, indent=2)
    print(text)
    if options.out:
        options.out.write_text(text + "\n")


if __name__ == "__main__":
    main()
