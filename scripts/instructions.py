#!/usr/bin/env python3
"""Counts the instructions of one tick, by method and class, and compares them with the table.

    scripts/instructions.py --program P            fail if a tick costs more than in the table
    scripts/instructions.py --program P --update   write a new table

P is the program of an optimised build. Its rows are ticks of `palpate run` on the simulated device (class `loop`:
loop, safety, device and renderer), rows of a table that `palpate render` reads and evaluates, and ticks of a recording
that `palpate info` reads. Without P they are left out.

Valgrind counts, so the numbers do not depend on the machine's speed or load; they do depend on the
compiler and its target. A count may exceed its row by 5 % and 5 instructions.
"""

import argparse
import csv
import functools
import json
import math
import os
import pathlib
import re
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parent.parent
TABLE = ROOT / "crates/palpate-core/benches/instructions.csv"
# Classes that are commands of the program, and the numbers of ticks or rows of their two runs.
COMMANDS = ["loop", "render", "info"]
TICKS = [1000, 5000]
# Methods of the loop.
LOOP_METHODS = ["basic", "hfcr", "coupled"]


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


def instructions_of(*command):
    """Runs a command under callgrind and returns its number of instructions."""
    whole = ["valgrind", "--tool=callgrind", "--callgrind-out-file=/dev/null", *map(str, command)]
    run = subprocess.run(whole, cwd=ROOT, capture_output=True, text=True)
    if run.returncode != 0:
        sys.exit(run.stderr)
    return int(re.search(r"Collected : (\d+)", run.stderr)[1])


def per_tick(command):
    """Returns the instructions per tick of a command, a function of the number of ticks: without start and end."""
    few, many = TICKS
    return (instructions_of(*command(many)) - instructions_of(*command(few))) / (many - few)


def count_commands(program):
    """Counts the instructions of commands of the program: {(method, class): instructions per tick or row}."""

    def run(method, ticks, *more):
        scene = ["run", "experiments/wall.toml", "--method", method]
        return [program, *scene, "--fast", "--duration", ticks / 1000, *more]

    with tempfile.TemporaryDirectory() as folder:

        def table(ticks):
            path = pathlib.Path(folder) / f"{ticks}.csv"
            rows = (f"{i / 1000},{0.01 * math.sin(0.01 * i)}\n" for i in range(ticks))
            path.write_text("t_s,position_m\n" + "".join(rows))
            contact = ["--stiffness", 1000, "--mass", 0.1, "--period", 0.001, "--method", "basic"]
            return [program, "render", path, *contact]

        def recording(ticks):
            path = pathlib.Path(folder) / f"{ticks}.mcap"
            made = run("basic", ticks, "--record", path)
            subprocess.run(list(map(str, made)), cwd=ROOT, check=True, capture_output=True)
            return [program, "info", path]

        loops = {(name, "loop"): functools.partial(run, name) for name in LOOP_METHODS}
        commands = {**loops, ("basic", "render"): table, ("basic", "info"): recording}
        return {name: per_tick(command) for name, command in commands.items()}


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--program", help="program of an optimised build")
    parser.add_argument("--update", action="store_true", help="write a new table")
    arguments = parser.parse_args()
    counts = count(build())
    if arguments.program:
        counts |= count_commands(arguments.program)
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
        print("without --program: no rows of its commands")
        table = {name: value for name, value in table.items() if name[1] not in COMMANDS}
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
