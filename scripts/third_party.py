#!/usr/bin/env python3
"""Writes THIRD-PARTY.md: whose work goes into the program, and under which licence. Writes the same for the
Python package, the C library and the playground.

    scripts/third_party.py           writes the files
    scripts/third_party.py --check   exit code 1 if a file is not up to date

It covers every crate that any build of the program contains, on any platform and with any feature
(`cargo metadata --locked`), and what is vendored on the page of `palpate live`. Crates that are only
needed by tests or that run only while compiling are left out: nothing of them is in the program.
"""

import json
import re
import subprocess
import sys
from pathlib import Path
from typing import NamedTuple

ROOT = Path(__file__).resolve().parent.parent
VENDORED = ROOT / "crates/palpate-live/page/vendor"

# Preference among the licences that a crate offers: the first match applies.
PREFERRED = ["Apache-2.0", "MIT", "BSD-3-Clause", "BSD-2-Clause", "ISC", "Zlib", "CC0-1.0", "Unicode-3.0", "MPL-2.0"]

# Licences whose text appears with the crate's copyright lines, and words that identify their texts.
TEXTS = {
    "MIT": "permission is hereby granted, free of charge",
    "BSD-3-Clause": "neither the name of",
    "BSD-2-Clause": "redistribution and use in source and binary forms",
    "ISC": "permission to use, copy, modify, and",
    "Zlib": "this software is provided 'as-is', without any express",
    "Unicode-3.0": "unicode license v3",
    "CC0-1.0": "cc0 1.0 universal",
}
# Apache-2.0 is in LICENSE-APACHE. MPL-2.0 is named with its crates.
ELSEWHERE = {"Apache-2.0", "MPL-2.0"}

HEAD = """# Third parties

<!-- Written by scripts/third_party.py; `scripts/third_party.py --check` says whether it is up to date. -->

{what} `palpate` contains the work of others. Whoever gives the {noun} away gives this file with it, and
[LICENSE-APACHE](LICENSE-APACHE), which is the text of the Apache licence that many of the crates below have. The Rust
standard library is part of the {noun} too (MIT OR Apache-2.0, <https://github.com/rust-lang/rust>).

The tables name every crate that a build may contain; a build for one platform, with the default features, contains fewer.
"""

MPL = """
## Under the Mozilla Public License 2.0

{crates}

These crates are used as they were published; no file of theirs was changed. Their
[licence](https://mozilla.org/MPL/2.0/) asks whoever gives away a {noun} that contains them to say where their source
is: it is at the addresses above, for exactly these versions. It covers the files of these crates and nothing else of
the {noun}. Whoever changes one of their files and gives the {noun} away has to publish the changed file under the
same licence.
"""


class Given(NamedTuple):
    """Something that is given away."""

    noun: str
    what: str
    """How the first sentence names it."""
    folder: Path
    """Where its manifest and its list stand."""
    package: str
    has_page: bool
    """Whether the page of `palpate live` is in it."""


GIVEN = [
    Given("program", "The program", ROOT, "palpate-cli", True),
    Given("package", "The Python package", ROOT / "bindings/python", "palpate-python", False),
    Given("library", "The C library", ROOT / "bindings/c", "palpate-c", False),
    Given("page", "The playground of", ROOT / "bindings/wasm", "palpate-wasm", True),
]


def metadata(folder):
    """The packages of a build, with all features and for all platforms."""
    command = ["cargo", "metadata", "--locked", "--all-features", "--format-version", "1"]
    done = subprocess.run(command, cwd=folder, stdout=subprocess.PIPE, check=True, text=True)
    return json.loads(done.stdout)


def linked(folder, root):
    """The crates of others that are linked into the package `root`, for any platform and with all of its features."""
    command = ["cargo", "tree", "--locked", "--all-features", "--package", root, "--target", "all"]
    command += ["--edges", "normal,no-proc-macro", "--prefix", "none", "--format", "{p}"]
    done = subprocess.run(command, cwd=folder, stdout=subprocess.PIPE, check=True, text=True)
    seen = {tuple(line.split()[:2]) for line in done.stdout.splitlines() if line}
    packages = [p for p in metadata(folder)["packages"] if p["source"] and (p["name"], f"v{p['version']}") in seen]
    return sorted(packages, key=lambda p: (p["name"].lower(), p["version"]))


def followed(expression):
    """The licences that this file follows, of an SPDX expression such as `(MIT OR Apache-2.0) AND ISC`."""
    # A licence exception only grants more rights, so the licence itself is used.
    expression = re.sub(r" WITH [\w.-]+", "", expression.replace("/", " OR "))
    words = re.findall(r"[()]|[^\s()]+", expression)

    def either():
        options = [both()]
        while words and words[0] == "OR":
            words.pop(0)
            options.append(both())
        known = [option for option in options if all(name in PREFERRED for name in option)]
        if not known:
            raise SystemExit(f"no licence that is known in `{expression}`: see PREFERRED in scripts/third_party.py")
        return min(known, key=lambda option: max(PREFERRED.index(name) for name in option))

    def both():
        names = one()
        while words and words[0] == "AND":
            words.pop(0)
            names = names + one()
        return names

    def one():
        word = words.pop(0)
        if word != "(":
            return [word]
        names = either()
        words.pop(0)
        return names

    return sorted(set(either()))


def files(package, pattern):
    folder = Path(package["manifest_path"]).parent
    named = [path for path in folder.iterdir() if path.is_file() and re.match(pattern, path.name, re.IGNORECASE)]
    return [path.read_text(encoding="utf-8", errors="replace") for path in sorted(named)]


def plain(text):
    """A text without its line breaks, quotes and capitals."""
    text = re.sub(r"[\"“”`‘’]|''", "'", text.lower())
    return re.sub(r"\s+", " ", text).strip()


def is_copyright(line):
    line = line.strip(" \t*#/")
    return re.match(r"(copyright\b|©|\(c\) )", line, re.IGNORECASE) and "notice" not in line.lower()


def split_text(licence, text):
    """The copyright lines that stand before a licence's text, and the text from its first line."""
    lines = [line.rstrip() for line in text.replace("\r\n", "\n").strip("\n").split("\n")]
    rights = []
    for at, line in enumerate(lines):
        if plain(" ".join(lines[at : at + 3])).startswith(TEXTS[licence]) and line:
            return rights, "\n".join(lines[at:])
        if is_copyright(line):
            rights.append(line.strip(" \t*#/"))
    return [], "\n".join(lines)


def said(package):
    return f"{package['name']} {package['version']}"


def copyright_by_authors(package):
    authors = [re.sub(r"\s*<[^>]*>", "", author) for author in package["authors"]]
    return "Copyright " + (", ".join(authors) or f"the {package['name']} authors")


def table(packages):
    rows = ["| crate | version | licence | source |", "|---|---|---|---|"]
    for package in packages:
        address = package["repository"] or package["homepage"] or f"https://crates.io/crates/{package['name']}"
        rows.append(f"| {package['name']} | {package['version']} | {package['license']} | <{address}> |")
    return "\n".join(rows)


def mpl_part(noun, packages):
    crates = [
        f"- {said(p)}: <https://static.crates.io/crates/{p['name']}/{p['name']}-{p['version']}.crate>"
        for p in packages
    ]
    return MPL.format(noun=noun, crates="\n".join(crates))


def texts_part(licence, packages):
    """Every text of a licence once, with the crates and copyright lines that it belongs to."""
    groups = {}
    for package in packages:
        found = [text for text in files(package, r"(licen[sc]e|copying|unlicense)") if TEXTS[licence] in plain(text)]
        if found:
            rights, body = split_text(licence, found[0])
        else:
            rights, body = [copyright_by_authors(package)], None
        groups.setdefault(plain(body) if body else None, []).append((package, rights, body))
    # A crate without a licence text uses the most common text of that licence.
    largest = max((key for key in groups if key), key=lambda key: len(groups[key]), default=None)
    if None in groups:
        if largest is None:
            raise SystemExit(f"no text of {licence} in {said(groups[None][0][0])}")
        groups[largest] += groups.pop(None)
    parts = []
    for key in sorted(groups, key=lambda key: (-len(groups[key]), key)):
        members = sorted(groups[key], key=lambda member: (member[0]["name"].lower(), member[0]["version"]))
        lines = [f"- {said(package)}" + "".join(f"; {right}" for right in rights) for package, rights, _ in members]
        body = next(body for _, _, body in members if body)
        parts.append("\n".join(lines) + "\n\n```text\n" + body + "\n```\n")
    return f"\n## {licence}\n\n" + "\n".join(parts)


def vendored_part():
    parts = ["\n## On the page of `palpate live`\n"]
    for folder in sorted(path for path in VENDORED.iterdir() if path.is_dir()):
        texts = sorted(path for path in folder.iterdir() if path.name.upper().startswith("LICENSE"))
        if len(texts) != 1:
            raise SystemExit(f"{folder}: one file LICENSE is needed, and there are {len(texts)}")
        where = folder.relative_to(ROOT)
        parts.append(f"{folder.name}, in [{where}]({where}):\n")
        parts.append("```text\n" + texts[0].read_text(encoding="utf-8").strip() + "\n```\n")
    return "\n".join(parts)


def notices_part(packages):
    """What Apache-2.0 asks to be passed on of crates that come with a NOTICE."""
    parts = []
    for package in packages:
        parts += [f"{said(package)}:\n\n```text\n{text.strip()}\n```\n" for text in files(package, r"notice")]
    return "\n## Notices\n\n" + "\n".join(parts) if parts else ""


def document(given):
    packages = linked(given.folder, given.package)
    by_licence = {}
    for package in packages:
        if not package["license"]:
            raise SystemExit(f"{said(package)} names no licence")
        for licence in followed(package["license"]):
            by_licence.setdefault(licence, []).append(package)
    text = HEAD.format(what=given.what, noun=given.noun) + "\n## Crates\n\n" + table(packages) + "\n\nWhere a crate leaves the choice, this file follows Apache-2.0.\n"
    text += mpl_part(given.noun, by_licence.get("MPL-2.0", [])) if "MPL-2.0" in by_licence else ""
    text += vendored_part() if given.has_page else ""
    text += notices_part(by_licence.get("Apache-2.0", []))
    for licence in sorted(set(by_licence) - ELSEWHERE):
        text += texts_part(licence, by_licence[licence])
    return text


def main():
    if sys.argv[1:] not in ([], ["--check"]):
        raise SystemExit(__doc__)
    for given in GIVEN:
        out, text = given.folder / "THIRD-PARTY.md", document(given)
        if not sys.argv[1:]:
            out.write_text(text, encoding="utf-8")
        elif not out.exists() or out.read_text(encoding="utf-8") != text:
            where = out.relative_to(ROOT)
            raise SystemExit(f"{where} is not up to date: run scripts/third_party.py and commit what it writes")


if __name__ == "__main__":
    main()
