#!/usr/bin/env python3
"""Computes the tables of docs/results/suite.md for the sets with real actuators.

    cargo build --release && python3 scripts/suite_tables.py [--plants 200] [--seed 1] [--seeds 7] [--sets desk,real]

A cell is E in percent: median / 90 % / largest; for several seeds median and 90 %, each as the median over the seeds
with its range.
"""
import argparse
import json
import subprocess
import sys


def report(program, name, plants, seed, seeds):
    command = [program, "suite", "--set", name, "--plants", str(plants), "--seed", str(seed)]
    command += ["--seeds", str(seeds), "--json"]
    answer = subprocess.run(command, stdout=subprocess.PIPE, check=True)
    return json.loads(answer.stdout)


def spread(found):
    return f"{found['median']:.1f} ({found['least']:.1f}-{found['largest']:.1f})"


def cell(found):
    if "over_seeds" in found:
        over = found["over_seeds"]
        return f"{spread(over['median_percent'])} / {spread(over['quantile_90_percent'])}"
    error = found["mean_force_error_percent"]
    diverged = " !" if found["diverged"] else ""
    values = (error["median"], error["quantile_90"], error["largest"])
    # JSON represents an infinite error as null.
    return " / ".join("inf" if value is None else f"{value:.1f}" for value in values) + diverged


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--program", default="target/release/palpate")
    parser.add_argument("--plants", type=int, default=200)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--seeds", type=int, default=1)
    parser.add_argument("--sets", default="paper,desk,real,steps")
    arguments = parser.parse_args()
    for name in arguments.sets.split(","):
        found = report(arguments.program, name, arguments.plants, arguments.seed, arguments.seeds)
        columns = found["columns"]
        print(f"| `{name}` | " + " | ".join(column["name"] for column in columns) + " |")
        print("|---|" + "---:|" * len(columns))
        key = "delays" if name == "paper" else "conditions"
        for place, condition in enumerate(columns[0][key]):
            cells = [cell(column[key][place]) for column in columns]
            said = condition.get("condition")
            if said is None:
                said = f"delay {condition['delay_samples']}, model {condition['model_delay_samples']}"
            print(f"| {said} | " + " | ".join(cells) + " |")
        print()
        sys.stdout.flush()


if __name__ == "__main__":
    main()
