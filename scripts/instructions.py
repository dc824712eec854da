#!/usr/bin/env python3
"""Counts the instructions of one tick, by method and class, and compares them with the table.

    scripts/instructions.py --program P            fail if a tick costs more than in the table
    scripts/instructions.py --program P --update   write a new table

P is the program of an optimised build. Its rows, of the class `loop`, are ticks of `palpate run` on the simulated
device: loop, safety, device and renderer. Without P they are left out.

Valgrind counts, so the numbers do not depend on the machine's speed or load; they do depend on the
compiler and its target. A count may exceed its row by 5 % and 5 instructions.
"""

import argparse
import csv
import json
import os
import pathlib
import re
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parent.parent
TABLE = ROOT / "crates/palpate-core/benches/instructions.csv"
# Methods and durations [s] of the runs of the loop.
LOOP_METHODS = ["basic", "hfcr", "coupled"]
LOOP_SECONDS = [1, 3]


def build():
    """Builds the counted program and returns its path."""
    command = ["cargo", "bench", "-p", "palpate-core", "--bench", "instructions", "--no-run"]
    command += ["--message-format", "json-render-diagnostics"]
    # An incremental build inlines less and gives higher counts.
    whole = {**os.environ, "CARGO_INCREMENTAL": "0"}
    output = subprocess.run(
        command, cwd=ROOT, check=True, stdout=subprocess.PIPE, text=True, env=whole
    )
    messages = map(json.loads, output.stdout.splitlines())
    paths = [m["executable"] for m in messages if m.get("executable")]
    (path,) = [p for p in paths if "instructions" in pathlib.Path(p).name]
    return path


def count(program):
    """Runs the program under callgrind: {(method, class): instructions per tick}."""
    with tempfile.TemporaryDirectory() as folder:
        out = pathlib.Path(folder) / "out"
        command = ["valgrind", "--tool=callgrind", f"--callgrind-out-file={out}"]
        # Each call of `lap` ends a dump: odd dumps hold the setup, even dumps the ticks.
        command += ["--dump-before=*instructions::lap*", program, "--count"]
        run = subprocess.run(command, capture_output=True, text=True)
        if run.returncode != 0:
            sys.exit(run.stderr)
        parts = [line.rsplit(",", 1) for line in run.stdout.splitlines()]
        totals = []
        for index in range(2, 2 * len(parts) + 1, 2):
            dump = out.with_name(f"{out.name}.{index}").read_text()
            totals.append(int(re.search(r"^(?:summary|totals): (\d+)", dump, re.M)[1]))
    counts = {}
    for (once, twice), (first, second) in zip(zip(parts[::2], parts[1::2]),
                                              zip(totals[::2], totals[1::2])):
        assert once[0] == twice[0], (once, twice)
        ticks = int(twice[1]) - int(once[1])
        counts[tuple(once[0].split(","))] = (second - first) / ticks
    return counts


def count_loop(program):
    """Runs `palpate run` in simulated time under callgrind: {(method, "loop"): instructions per tick}."""
    counts = {}
    for method in LOOP_METHODS:
        totals = []
        for seconds in LOOP_SECONDS:
            command = ["valgrind", "--tool=callgrind", "--callgrind-out-file=/dev/null", program, "run"]
            command += ["experiments/wall.toml", "--method", method, "--fast", "--duration", str(seconds)]
            run = subprocess.run(command, cwd=ROOT, capture_output=True, text=True)
            if run.returncode != 0:
                sys.exit(run.stderr)
            totals.append(int(re.search(r"Collected : (\d+)", run.stderr)[1]))
        # The difference excludes start and end. The scene has 1000 ticks a second.
        once, twice = LOOP_SECONDS
        counts[method, "loop"] = (totals[1] - totals[0]) / (1000 * (twice - once))
    return counts


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--program", help="program of an optimised build, for the ticks of a loop")
    parser.add_argument("--update", action="store_true", help="write a new table")
    arguments = parser.parse_args()
    counts = count(build())
    if arguments.program:
        counts |= count_loop(arguments.program)
    elif arguments.update:
        parser.error("a new table needs --program")

    if arguments.update:
        with TABLE.open("w", newline="") as file:
            writer = csv.writer(file, lineterminator="\n")
            writer.writerow(["method", "class", "instructions_per_tick"])
            writer.writerows([*name, f"{value:.1f}"] for name, value in counts.items())
        print(f"wrote {TABLE.relative_to(ROOT)}")
    with TABLE.open(newline="") as file:
        rows = csv.DictReader(file)
        table = {(r["method"], r["class"]): float(r["instructions_per_tick"]) for r in rows}

    if not arguments.program:
        print("without --program: no row of a loop")
        table = {name: value for name, value in table.items() if name[1] != "loop"}
    failures = [f"{name} is no longer measured" for name in table.keys() - counts.keys()]
    print(f"{'instructions per tick':28}{'now':>8}{'table':>8}")
    for name, value in counts.items():
        stated = table.get(name)
        print(f"{name[0]:16}{name[1]:12}{value:8.1f}{stated if stated is not None else '-':>8}")
        if stated is None:
            failures.append(f"{name} is not in the table")
        elif value > 1.05 * stated + 5:
            failures.append(f"{name} takes {value:.1f} instructions, but {stated} in the table")
    for failure in failures:
        print(f"FAILED: {failure}", file=sys.stderr)
    sys.exit(bool(failures))


if __name__ == "__main__":
    main()
