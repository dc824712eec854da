#!/usr/bin/env python3
"""Finds circles of files in a crate, by their `use` lines.

    scripts/circles.py [FOLDER...]    exit code 1 if there is one; without a FOLDER, crates/palpate-cli/src

A file depends on the file that defines what it uses: a name that another module only hands on (`pub use`) counts for
the file that it comes from, and the `pub use` lines of a `mod.rs` count for nothing. Tests inside a file are left out.
"""

import re
import sys
from pathlib import Path

USE = re.compile(r"\b(pub(?:\([a-z]+\))? )?use ([^;]+);")


def modules(folder):
    """The text of each file, by the path of its module."""
    found = {}
    for path in folder.rglob("*.rs"):
        parts = path.relative_to(folder).with_suffix("").parts
        if parts[-1] in ("mod", "lib"):
            parts = parts[:-1]
        text = re.sub(r"//.*", "", path.read_text())
        found[parts] = (path.name, re.split(r"#\[cfg\(test\)\]\s*mod tests\b", text)[0])
    found.pop(("main",), None)
    return found


def expand(tree):
    """The paths of a `use` tree, without their new names."""
    tree = tree.strip()
    if "{" not in tree:
        return [tree.split(" as ")[0].strip()]
    before, inside = tree[: tree.index("{")], tree[tree.index("{") + 1 : tree.rindex("}")]
    parts, depth = [""], 0
    for character in inside:
        depth += (character == "{") - (character == "}")
        if character == "," and depth == 0:
            parts.append("")
        else:
            parts[-1] += character
    return [path for part in parts if part.strip() for path in expand(before + part.strip())]


def absolute(known, module, path):
    """A path from the root of the crate; none of another crate."""
    names = path.split("::")
    if names[0] == "crate":
        return tuple(names[1:])
    if names[0] == "self":
        return module + tuple(names[1:])
    if names[0] == "super":
        while names and names[0] == "super":
            module, names = module[:-1], names[1:]
        return module + tuple(names)
    return module + tuple(names) if module + (names[0],) in known else None


def arrows(known):
    """Which modules each module depends on."""
    used, handed_on = {}, {}
    for module, (name, text) in known.items():
        used[module] = set()
        for public, tree in USE.findall(text):
            for path in filter(None, (absolute(known, module, path) for path in expand(tree))):
                if public:
                    handed_on[module, path[-1]] = path
                if not (public and name == "mod.rs"):
                    used[module].add(path)

    def origin(path, seen=()):
        for length in range(len(path), -1, -1):
            module = path[:length]
            if module in known:
                further = handed_on.get((module, path[length])) if length < len(path) else None
                return origin(further, (*seen, further)) if further and further not in seen else module
        return None

    return {module: {origin(path) for path in paths} - {module, (), None} for module, paths in used.items()}


def circles(depends):
    """The sets of modules that depend on each other, directly or not."""
    reached = {}
    for module in depends:
        reached[module], waiting = set(), [module]
        while waiting:
            for other in depends[waiting.pop()] - reached[module]:
                reached[module].add(other)
                waiting.append(other)
    return {frozenset(b for b in reached[a] if a in reached[b]) for a in depends if a in reached[a]}


def main():
    folders = sys.argv[1:] or [Path(__file__).parent.parent / "crates/palpate-cli/src"]
    are_there = False
    for folder in map(Path, folders):
        for circle in sorted(circles(arrows(modules(folder))), key=sorted):
            are_there = True
            print(f"{folder}: " + ", ".join(sorted("::".join(module) for module in circle)))
    return int(are_there)


if __name__ == "__main__":
    sys.exit(main())
