"""Cells and rows of Markdown tables, from the JSON reports of the program."""


def number(value, digits=1):
    """Two digits after the point below 0.1, none from 1000 on; JSON has null for an infinite number."""
    if value is None:
        return "inf"
    if abs(value) >= 1e4:
        return f"{value:.1e}".replace("e+0", "e").replace("e+", "e")
    if abs(value) >= 1e3:
        return f"{value:.0f}"
    return f"{value:.{digits}f}" if abs(value) >= 0.1 else f"{value:.2f}"


def table(header, rows):
    head, *titles = header
    lines = [f"| {head} |" + "".join(f" {title} |" for title in titles), "|---|" + "---:|" * len(titles)]
    lines += ["| " + " | ".join(row) + " |" for row in rows]
    return "\n".join(lines).replace("|  |", "| |").replace("|  |", "| |") + "\n"


def error(method):
    return number(method["mean_force_error_percent"])


def force_error(method):
    return number(method["force_rendering_error_percent"]) + (", diverged" if method["diverged"] else "")


def by_method(report):
    return {method["method"]: method for method in report["methods"]}


def spread(of, digits=1):
    def shown(value):
        return f"{value:.{digits}f}" if value is not None and value < 1e3 else number(value)

    return f"{shown(of['median'])} ({shown(of['least'])}-{shown(of['largest'])})"
