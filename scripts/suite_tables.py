#!/usr/bin/env python3
"""Prints the tables of docs/suite.md for the sets with real actuators, from the program itself.

    cargo build --release && python3 scripts/suite_tables.py [--plants 200] [--seed 1]

A cell is E in percent: median / 90 % / largest.
"""
import argparse
import json
import subprocess
import sys


def report(program, name, plants, seed):
    command = [program, "suite", "--set", name, "--plants", str(plants), "--seed", str(seed), "--json"]
    answer = subprocess.run(command, stdout=subprocess.PIPE, check=True)
    return json.loads(answer.stdout)


def cell(found):
    error = found["mean_force_error_percent"]
    diverged = " !" if found["diverged"] else ""
    values = (error["median"], error["quantile_90"], error["largest"])
    # An infinite error is null in JSON.
    return " / ".join("inf" if value is None else f"{value:.1f}" for value in values) + diverged


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--program", default="target/release/palpate")
    parser.add_argument("--plants", type=int, default=200)
    parser.add_argument("--seed", type=int, default=1)
    arguments = parser.parse_args()
    for name in ("desk", "real", "steps"):
        found = report(arguments.program, name, arguments.plants, arguments.seed)
        columns = found["columns"]
        print(f"| `{name}` | " + " | ".join(column["name"] for column in columns) + " |")
        print("|---|" + "---:|" * len(columns))
        for place, condition in enumerate(columns[0]["conditions"]):
            cells = [cell(column["conditions"][place]) for column in columns]
            print(f"| {condition['condition']} | " + " | ".join(cells) + " |")
        print()
        sys.stdout.flush()


if __name__ == "__main__":
    main()
