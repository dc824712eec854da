"""Writers of the tables of docs/results from JSON reports, and the commands that make the reports. scripts/tables runs
them."""

import re
import tomllib
from pathlib import Path

from table_cells import by_method, error, force_error, number, spread, table

ROOT = Path(__file__).resolve().parent.parent
THREE = ["fig2", "experiment1", "experiment2"]


def simulate(*flags):
    return [["simulate", f"experiments/{name}.toml", *flags] for name in THREE]


def paper_scenes(*reports):
    methods = [by_method(report) for report in reports]
    rows = [["loop rate [Hz], κ, Kc"]]
    for report in reports:
        rows[0].append(f"{1 / report['period_s']:.0f}, {report['kappa']:.2f}, {report['object_kappa']:.2f}")
    for name, title in [
        ("basic", "basic"),
        ("seh", "sample-estimate-hold (AB2)"),
        ("popc-ref", "POPC-REF, best cap"),
        ("virtual-damper", "virtual damper, best B"),
        ("hfcr-mod-st", "HFCR, b = 0 (`hfcr-mod-st`)"),
        ("hfcr", "HFCR, best b"),
        ("coupled", "coupled, exact model mass"),
    ]:
        rows.append([title] + [force_error(of[name]) for of in methods])
    rows.append(["hold bound"] + [number(report["hold_bound_percent"]) for report in reports])
    return table(["FRE %", *(f"`{name}`" for name in THREE)], rows)


OTHERS = {
    "energy-corrected": "`energy-corrected` (nothing to tune)",
    "force-bounding": "`force-bounding`, best b",
    "pmi": "`pmi` (nothing to tune)",
    "energy-tank": "`energy-tank`, four numbers tuned",
    "virtual-coupling": "`virtual-coupling`, three numbers tuned",
}
VARIANTS = [
    ["--method", "pmi", "--midpoint-device", "extrapolated"],
    ["--method", "virtual-damper", "--damping", "stability-optimal"],
    ["--method", "hfcr", "--damping", "adaptive"],
]


def other_authors(*reports):
    def cells(methods):
        return [
            f"{number(of['force_rendering_error_percent'])} ({error(of)})" + (", diverged" if of["diverged"] else "")
            for of in methods
        ]

    of_all = [by_method(report) for report in reports[:3]]
    rows = [[title, *cells(of[name] for of in of_all)] for name, title in OTHERS.items()]
    for place, flags in enumerate(VARIANTS, 1):
        methods = [report["methods"][0] for report in reports[3 * place : 3 * place + 3]]
        rows.append([f"`{' '.join(flags[1:])}`", *cells(methods)])
    return table(["FRE (E) in percent", *(f"`{name}`" for name in THREE)], rows)


OF_THE_PAPER = ["basic", "seh", "virtual-damper", "popc", "popc-ref", "hfcr-mod", "hfcr-mod-st", "hfcr", "coupled"]


def users(names, bound):
    def write(report):
        stable = {
            scene["scene"]: min(of["mean_force_error_percent"] for of in scene["methods"] if not of["diverged"])
            for scene in report["scenes"]
        }

        def cell(scene, of):
            if of["diverged"]:
                return error(of) + " !"
            least = number(of["mean_force_error_percent"]) == number(stable[scene["scene"]])
            return f"**{error(of)}**" if least else error(of)

        rows = []
        for scene in report["scenes"]:
            methods = by_method(scene)
            rows.append([scene["title"]] + [cell(scene, methods[name]) for name in names])
            rows[-1] += [number(scene["hold_bound_percent"])] if bound else []
        return table(["E in percent", *names, *(["hold bound"] if bound else [])], rows)

    return write


def over_heights(found):
    return f"{number(found['own'])}; {number(found['median'])} / {number(found['worst'])}"


def robustness(report):
    rows = []
    for place, column in enumerate(report["scenes"][0]["columns"]):
        errors = [scene["columns"][place]["mean_force_error_percent"] for scene in report["scenes"]]
        rows.append([column["name"], *(over_heights(of) for of in errors)])
    return table(["E %, own; median / worst", *(f"`{name}`" for name in THREE)], rows)


def window(short, long):
    """FRE of HFCR over the damping: at the own height, median and worst over the heights."""
    rows = []
    for values in zip(short["values"], long["values"]):
        rows.append([f"{values[0]['value']:g}"])
        for value in values:
            (of,) = value["columns"]
            names = ["force_rendering_error_percent", "median_force_rendering_error_percent"]
            own, median, worst = (of[name] for name in [*names, "worst_force_rendering_error_percent"])
            rows[-1].append(over_heights({"own": own, "median": median, "worst": worst}))
    return table(["b [N s/m]", "`fig2`, 3 collisions", "`fig2_long`, 10 collisions"], rows)


def balance(*reports):
    """FRE of two methods with both energy balances; the reports have three scenes for each balance."""
    rows = []
    for place, name in enumerate(["hfcr-mod", "hfcr-mod-st"]):
        for first, title in enumerate(BALANCES):
            of = [report["methods"][place] for report in reports[3 * first : 3 * first + 3]]
            rows.append([f"`{name}`, `{title}`", *(number(one["force_rendering_error_percent"]) for one in of)])
    return table(["FRE %", *(f"`{name}`" for name in THREE)], rows)


CAPS = {
    "cap of the scene": [],
    "cap of the scene, v_eps = 0.1 m/s": ["--speed-threshold", "0.1"],
    "no cap": ["--damping-cap", "1e9"],
    "no cap, v_eps = 0.1 m/s": ["--damping-cap", "1e9", "--speed-threshold", "0.1"],
}


def caps(*reports):
    rows = []
    for place, title in enumerate(CAPS):
        methods = [report["methods"][0] for report in reports[3 * place : 3 * place + 3]]
        rows.append([title, *(number(of["force_rendering_error_percent"]) for of in methods)])
    return table(["POPC-REF, FRE %", *(f"`{name}`" for name in THREE)], rows)


def carried(*reports):
    names = ["basic", "seh", "virtual-damper", "popc-ref", "hfcr", "coupled"]
    rows = []
    for report, title in zip(reports, ["f_u pushes", "f_u carries"]):
        methods = by_method(report)
        rows.append([title, *(number(methods[name]["force_rendering_error_percent"]) for name in names)])
        rows[-1].append(number(report["hold_bound_percent"]))
    return table(["FRE %", *names, "bound"], rows)


def user_heights(report):
    rows = []
    for scene in report["scenes"]:
        rows.append([scene["title"].split()[0]])
        for column in scene["columns"]:
            diverged = " !" if column["diverged"] else ""
            rows[-1].append(over_heights(column["mean_force_error_percent"]) + diverged)
    names = [column["name"] for column in report["scenes"][0]["columns"]]
    return table(["E in percent, own; median / worst", *names], rows)


HALF, BEST = "B = K T/2", "best B"
READING_A = [f"damper, {of}, {b}" for b in (HALF, BEST) for of in ("spring-and-damper", "spring", "held-force")]
READING_B = [f"hfcr, {hold}, {b}" for b in ("b = 0", "best b") for hold in ("crossing", "sample", "midpoint")]
READING_C = [f"damper, {of}, {HALF}" for of in ("spring-and-damper", "extrapolation", "observer")]
READING_C += [f"hfcr, {of}, b = 0" for of in ("crossing", "extrapolation", "observer")]


def readings(names):
    """Rows of the columns `names`: FRE at the own height, then median and worst over the heights."""

    def write(report):
        rows = []
        for name in names:
            rows.append([name])
            for scene in report["scenes"]:
                of = next(column for column in scene["columns"] if column["name"] == name)
                rows[-1].append(over_heights(of["force_rendering_error_over_heights_percent"]))
        return table(["FRE %, own; median / worst", *THREE], rows)

    return write


def linkage(figure, files):
    """E at the own height, median and worst over the heights, and FRE at the own height, of `files`."""

    def write(report):
        scenes = [report["scenes"][place] for place in files]
        rows = []
        for place, column in enumerate(scenes[0]["columns"]):
            rows.append([column["name"]])
            for scene in scenes:
                of = scene["columns"][place]
                rows[-1] += [over_heights(of["mean_force_error_percent"]), number(of["force_rendering_error_percent"])]
        return table(["", figure, "FRE", "`motors`", "FRE", "gap 0.04 m", "FRE"], rows)

    return write


def pantograph(methods, figure):
    """FRE and E by `simulate`, FRE against the basic model at 1 kHz and the paper's number by the text of the figure."""

    def write(report, *texts):
        lines = re.findall(r"^ *([a-z-]+(?: +[-.\w]+){3})$", texts[-1], re.MULTILINE)
        printed = {line.split()[0]: line.split()[2:] for line in lines}
        rows = []
        for name in methods:
            of = by_method(report)[name]
            left = of.get("left_box_at_s")
            other = [cell if cell != "-" else "" for cell in printed.get(name, ["", ""])]
            rows.append([name, force_error(of) + (f", left at {left:.2f} s" if left else ""), error(of), *other])
        rows.append(["hold bound", number(report["hold_bound_percent"]), "", "", ""])
        return table([f"{figure}, percent", "FRE", "E", "1 kHz", "paper"], rows)

    return write


def friction(report):
    """Largest rebound energy and peak force over the friction; bold is almost stable."""
    rows = []
    for value in report["values"]:
        rows.append([f"{value['value']:g}"])
        for of in value["columns"]:
            cell = f"{number(of['largest_rebound_energy'])}, {number(of['peak_force_n'])}"
            if of["bounce"] == "diverged":
                cell += ", diverged"
            rows[-1].append(f"**{cell}**" if of["bounce"] in ("stable", "almost stable") else cell)
        rows[-1].append(f"{value['ideal_peak_force_n']:.2f}")
    return table(["friction of Fig. 4 ×", "AB2", "differences", "AB3", "ideal's peak"], rows)


def of_values(head, cell):
    """One row for each value of a sweep, one column for each of its methods."""

    def write(report):
        rows = [[f"{value['value']:g}", *(cell(of) for of in value["columns"])] for value in report["values"]]
        return table([head, *(of["name"] for of in report["values"][0]["columns"])], rows)

    return write


def left_at(of):
    return "-" if of["left_box_at_s"] is None else f"{of['left_box_at_s']:.2f}"


def scene_heights(titles, fre):
    """E of each scene (rows) by each column, own; median / worst."""

    def write(report):
        rows = []
        for place, scene in enumerate(report["scenes"]):
            title = titles[place] if titles else scene["title"].split()[0]
            rows.append([title, *(over_heights(of["mean_force_error_percent"]) for of in scene["columns"])])
            if fre:
                rows[-1] += [number(of["error_over_bound"], 2) for of in scene["columns"] if of["name"] in fre]
        header = [column["name"] for column in report["scenes"][0]["columns"]]
        return table(["E in percent, own; median / worst", *header, *(f"FRE/bound, {name}" for name in fre)], rows)

    return write


def map_shares(part, shares, limits, header):
    """Shares in percent and limits in κ of each method, from its entry or from the `part` of it."""

    def write(report):
        rows = []
        for of in report["methods"]:
            values = of[part] if part else of
            rows.append([of["plant"], f"`{of['method']}`", *(f"{values[key]:.1f}" for key in shares)])
            rows[-1] += ["-" if values[key] is None else f"{values[key]:.3g}" for key in limits]
        return table(["device", "method", *header], rows)

    return write


def advice(report):
    rows = []
    for of in report["methods"]:
        own = of["by_itself"]
        rows.append([f"`{of['method']}`", own["class"], number(own["error_percent"][1])])
        rows[-1] += ["" if own[key] is None else number(100 * own[key]) for key in ("resting_swing", "pressed_swing")]
    return table(["method", "bounce", "worst E %", "swing at rest %", "pressed %"], rows)


def quantiles(delay):
    of = delay["mean_force_error_percent"]
    return "/".join(number(of[key]) for key in ("median", "quantile_75", "quantile_90", "largest"))


def one_seed(place):
    def write(*reports):
        rows = []
        columns = {column["name"]: column for report in reports for column in report["columns"]}
        for name, column in columns.items():
            of = column["delays"][place]
            bound, peak = of["error_over_bound"], of["peak_over_ideal_peak"]
            rows.append([name, quantiles(of)])
            rows[-1].append("/".join(number(bound[key], 2) for key in ("median", "quantile_90")))
            rows[-1].append("/".join(number(peak[key], 2) for key in ("median", "largest")))
            rows[-1].append(str(of["diverged"]))
        return table(["", "E median/75 %/90 %/max", "FRE/bound median/90 %", "peak", "diverged"], rows)

    return write


def damping_rules(report):
    rows = [[of["name"], *(quantiles(delay) for delay in of["delays"][:2])] for of in report["columns"]]
    return table(["", "E, no delay", "E, one sample, modelled"], rows)


def line_columns(report):
    """FRE and E of coupled rendering with each hold, median and 90 %, and FRE over the bound of the hold."""
    def cell(of, digits):
        return "/".join(number(of[key], digits) for key in ("median", "quantile_90"))

    rows = []
    titles = ["no delay", "one sample, modelled", "one sample, unmodelled"]
    for place, title in enumerate(titles):
        for column in report["columns"]:
            of = column["delays"][place]
            rows.append([f"{title}, {column['name']}", cell(of["force_rendering_error_percent"], 1)])
            rows[-1] += [cell(of["mean_force_error_percent"], 1), cell(of["error_over_bound"], 2)]
            rows[-1].append(str(of["diverged"]))
    return table(["", "FRE %, median/90 %", "E %", "FRE/bound of its hold", "diverged"], rows)


def over_seeds(report):
    rows = []
    for column in report["columns"]:
        # A method without a model of the delay has the same errors in the last two conditions.
        conditions = column["delays"] if column["models_delay"] else column["delays"][:2]
        rows.append([column["name"]])
        for delay in conditions:
            of = delay["over_seeds"]
            rows[-1] += [spread(of["median_percent"]), spread(of["quantile_90_percent"])]
        rows[-1] += [""] * (7 - len(rows[-1]))
    header = ["no delay: median", "90 %", "one sample, modelled: median", "90 %", "unmodelled: median", "90 %"]
    return table(["", *header], rows)


def actuators(name):
    def write(report):
        columns = report["columns"]
        rows = []
        for place, condition in enumerate(columns[0]["conditions"]):
            rows.append([condition["condition"]])
            for column in columns:
                of = column["conditions"][place]["over_seeds"]
                rows[-1].append(f"{spread(of['median_percent'])}/{spread(of['quantile_90_percent'])}")
        return table([f"`{name}`", *(column["name"] for column in columns)], rows)

    return write


def worlds(report):
    names = ["basic", "seh", "popc", "popc-ref", "virtual-damper", "virtual-coupling", "god-object"]
    names += ["hfcr-mod", "hfcr", "coupled"]
    rows = []
    for scene in report["scenes"]:
        methods = by_method(scene)
        rows.append([f"`{Path(scene['scene']).stem}`", number(scene["hold_bound_percent"])])
        for name in names:
            of = methods.get(name, {}).get("mean_force_error_percent")
            digits = 0 if of is None or of >= 9.95 else 1 if of >= 0.95 else 2
            rows[-1].append("" if of is None else f"{of:.{digits}f}")
    return table(["scene", "hold bound", *names], rows)


def random_worlds(report):
    def cells(method):
        parts = [method["over_seeds"][key] for key in ("median_percent", "quantile_90_percent")]
        return " / ".join(spread(part, 1 if part["median"] < 10 else 0) for part in parts)

    def row(one):
        loop = f"{1e3 * one['period_s']:g} ms, {one['delay_samples']}, {1e6 * one['quantum_m']:g} um"
        return [loop, *map(cells, one["methods"])]

    names = [method["name"] for method in report["loops"][0]["methods"]]
    return table(["period, delay in samples, quantum", *names], map(row, report["loops"]))


def readme(report):
    rows = []
    for column in report["columns"]:
        def cells(delay):
            found = [delay["over_seeds"][key] for key in ("median_percent", "quantile_90_percent")]
            return [spread(of, 1 if of["median"] < 10 else 0) for of in found]

        modelled = ", delay modelled" if column["models_delay"] else ""
        rows.append([column["name"] + modelled, *cells(column["delays"][0]), *cells(column["delays"][1])])
        if modelled:
            rows.append([column["name"] + ", delay unmodelled", "", "", *cells(column["delays"][2])])
    return table(["", "no delay: median", "90 %", "one sample of delay: median", "90 %"], rows)


USERS = ["compare", "experiments/users/*.toml"]
WORLDS = [[["suite", "--set", name, "--plants", "30", "--seeds", "7"]] for name in ("worlds", "worlds-free")]
BOUNCES = map_shares(
    None,
    ["stable_percent", "faithful_percent"],
    ["stable_wall_kappa", "faithful_wall_kappa", "stable_light_object_kappa"],
    ["stable %", "E < 20 %", "walls to κ", "E < 20 %", "Kc = 1 to κ"],
)
STAYS = map_shares(
    "stay",
    ["rests_percent", "pressed_percent", "stays_faithful_percent"],
    ["pressed_wall_kappa", "resting_light_object_kappa"],
    ["rests %", "pressed %", "all %", "pressed walls to κ", "Kc = 1 rests to κ"],
)
HEIGHTS = ["paper", "heights", *(f"experiments/{name}.toml" for name in THREE)]
HEIGHTS += ["--columns", "experiments/columns/readings.toml"]
ALL = ["--method", "all"]
FIG4 = ["basic", "seh", "virtual-damper", "popc-ref", "hfcr-mod-st", "hfcr", "coupled"]
FIG5 = ["basic", "seh", "virtual-damper", "popc-ref", "hfcr", "coupled"]
FIGURE4, FIGURE5 = (["paper", "figure", name] for name in ("fig4", "fig5"))
WRONG_MASS = [*HEIGHTS[:5], "--model-mass-factor", "1.5"]
DAMPERS = ["--columns", "experiments/columns/damper.toml"]
TUNED = ["paper", "heights", "experiments/users/*.toml", "--method", "virtual-damper,popc-ref,hfcr"]
COUPLED_SCENES = ["clamped-100", "clamped-400", "stiff-40", "stiff-160", "stiff-40-hand", "stiff-160-hand"]
COUPLED = ["paper", "heights", "experiments/fig4.toml", "experiments/fig5.toml"]
COUPLED += [f"experiments/coupled/{name}.toml" for name in COUPLED_SCENES]
FRICTION = ["sweep", "experiments/fig4.toml", "--over", "friction", "--collisions", "8"]
FRICTION += ["--columns", "experiments/columns/seh.toml"]
BOX = ["sweep", "experiments/fig5.toml", "--over", "box"]
BOXES = [*BOX, "--values", "0.08,0.09,0.1,0.11,0.12,0.15,0.2,0.3,0.4,0.5"]
BOX_METHODS = ["--method", "basic,seh,virtual-damper,popc-ref,hfcr,hfcr-mod-st,coupled"]
ADVICE = ["advise", "--device-mass", "0.3", "--period", "0.002", "--encoder-quantum", "1e-5", "--stiffness", "2000"]
PANTOGRAPH = ["paper", "heights", "experiments/fig4.toml", "experiments/fig5.toml", "experiments/readings/*.toml"]
ONE_SEED = [["suite"], ["suite", "--columns", "experiments/columns/damper.toml"]]
REAL = ["suite", "--seeds", "7", "--plants", "30", "--set"]

def unmodelled_delay(*reports):
    return delays("unmodelled delay", [*UNMODELLED, "jitter 0.1 T"], ["coupled", "hfcr"], reports)


def modelled_delay(*reports):
    header = [*MODELLED, "0.5 T, lag, gain", "model 1 T"]
    return delays("coupled, modelled delay", header, ["coupled"], reports)


def delays(head, header, names, reports):
    """E of the methods `names`; `reports` has the conditions of each scene one after the other."""
    rows = []
    for place, scene in enumerate(DELAYED):
        of_scene = reports[len(header) * place : len(header) * (place + 1)]
        for name in names:
            rows.append([f"`{scene}`, {name}", *(error(by_method(report)[name]) for report in of_scene)])
    return table([head, *header], rows)


def in_each(conditions):
    """The commands that simulate the scenes `DELAYED` under each condition; {0.1} is a tenth of the scene's period."""
    commands = []
    for scene in DELAYED:
        file = f"experiments/{scene}.toml"
        period = tomllib.loads((ROOT / file).read_text())["loop"]["period_s"]
        for condition in conditions:
            flags = re.sub(r"\{(.*?)\}", lambda part: f"{float(part[1]) * period:.8g}", condition)
            commands.append(["simulate", file, "--method", "hfcr,coupled", *flags.split()])
    return commands


def line_hold(*reports):
    """Bounds of both holds, and FRE of coupled rendering with a line hold; four reports for each scene."""
    rows = []
    for place, (scene, _) in enumerate(LINES):
        of_scene = reports[4 * place : 4 * place + 4]
        bounds = [number(report["hold_bound_percent"], 2) for report in of_scene[:2]]
        errors = [number(by_method(report)["coupled"]["force_rendering_error_percent"], 2) for report in of_scene]
        rows.append([f"`{scene}`", *bounds, *errors])
    header = ["bound, constant", "bound, line", "FRE, constant", "FRE, line", "mass 1.5 times", "quantum 10 um"]
    return table(["FRE %", *header], rows)


def lines():
    commands = []
    for scene, mass in LINES:
        line = ["--set", "loop.hold=line"]
        for flags in ([], line, [*line, "--model-device-mass", mass], [*line, "--set", "device.quantum_m=1e-5"]):
            commands.append(["simulate", f"experiments/{scene}.toml", "--method", "coupled", *flags])
    return commands


LINES = [("fig2", "0.15"), ("experiment1", "0.375"), ("experiment2", "0.375")]
DELAYED = ["fig2", "experiment2", "coupled/wall-1000", "users/s07-endstop"]
UNMODELLED = ["0", "0.03 T", "0.1 T", "0.3 T"]
MODELLED = ["0.03 T", "0.1 T", "0.3 T", "0.5 T"]
REAL_ACTUATOR = "--delay-periods 0.5 --lag {0.3} --gain 0.98"
BALANCES = ["with-virtual-force", "as-printed"]
DAMPINGS = ["--over", "damping", "--values", "0,0.00625,0.0125,0.02,0.025,0.03,0.04,0.05,0.1"]
DAMPINGS += ["--method", "hfcr", "--heights"]

# Name: page, writer, commands whose reports the writer takes.
TABLES = {
    "paper-scenes": ("closed-loop.md", paper_scenes, simulate("--method", "all")),
    "robustness": ("closed-loop.md", robustness, [HEIGHTS[:5]]),
    "fig4": (
        "closed-loop.md",
        pantograph(FIG4, "Fig. 4, 3 collisions"),
        [["simulate", "experiments/fig4.toml", *ALL], FIGURE4],
    ),
    "fig5": (
        "closed-loop.md",
        pantograph(FIG5, "Fig. 5, 6 collisions"),
        [["simulate", "experiments/fig5.toml", *ALL], FIGURE5],
    ),
    "other-authors": (
        "closed-loop.md",
        other_authors,
        sum((simulate(*flags) for flags in VARIANTS), simulate("--method", "all")),
    ),
    "users": ("scenarios.md", users(OF_THE_PAPER, True), [USERS]),
    "users-other-authors": ("scenarios.md", users(list(OTHERS), False), [USERS]),
    "users-heights": (
        "scenarios.md",
        user_heights,
        [["paper", "heights", "experiments/users/*.toml", "--columns", "experiments/columns/damper.toml"]],
    ),
    "users-tuned": ("scenarios.md", scene_heights(None, ()), [TUNED]),
    "reading-a": ("readings.md", readings(READING_A), [HEIGHTS]),
    "reading-b": ("readings.md", readings(READING_B), [HEIGHTS]),
    "reading-c": ("readings.md", readings(READING_C), [HEIGHTS]),
    "reading-d-fig4": ("readings.md", linkage("Fig. 4", (0, 4, 3)), [PANTOGRAPH]),
    "reading-d-fig5": ("readings.md", linkage("Fig. 5", (1, 6, 5)), [PANTOGRAPH]),
    "reading-f": ("readings.md", friction, [[*FRICTION, "--values", "0,0.5,1,2,3,5,7,10"]]),
    "reading-f-heights": (
        "readings.md",
        of_values("friction of Fig. 4 ×", lambda of: str(of["almost_stable_heights"])),
        [[*FRICTION, "--values", "1,5,7,10", "--heights"]],
    ),
    "reading-g": ("readings.md", of_values("y within ± [m]", left_at), [[*BOXES, *BOX_METHODS]]),
    "reading-g-heights": (
        "readings.md",
        of_values("y within ± [m]", lambda of: str(of["left_box_heights"])),
        [[*BOX, "--values", "0.1,0.11,0.2,0.5", *BOX_METHODS, "--heights"]],
    ),
    "reading-h": (
        "readings.md",
        window,
        [["sweep", f"experiments/{name}.toml", *DAMPINGS] for name in ("fig2", "fig2_long")],
    ),
    "reading-i": (
        "readings.md",
        balance,
        sum((simulate("--method", "hfcr-mod,hfcr-mod-st", "--balance", name) for name in BALANCES), []),
    ),
    "reading-j": (
        "readings.md",
        carried,
        [["simulate", f"experiments/{name}.toml", "--method", "all"] for name in ("fig2", "readings/fig2_carried")],
    ),
    "reading-k": (
        "readings.md",
        caps,
        sum((simulate("--method", "popc-ref", *flags) for flags in CAPS.values()), []),
    ),
    "one-seed": ("suite.md", one_seed(0), ONE_SEED),
    "one-seed-modelled-delay": ("suite.md", one_seed(1), ONE_SEED),
    "damping-rules": ("suite.md", damping_rules, [["suite", "--columns", "experiments/columns/damping-rules.toml"]]),
    "line-columns": ("suite.md", line_columns, [["suite", "--columns", "experiments/columns/line-hold.toml"]]),
    "seven-seeds": ("suite.md", over_seeds, [["suite", "--seeds", "7"]]),
    "unmodelled-delay": (
        "coupled-limits.md",
        unmodelled_delay,
        in_each([*(f"--delay-fraction {delay.removesuffix(' T')}" for delay in UNMODELLED), "--jitter {0.1} --seed 1"]),
    ),
    "modelled-delay": (
        "coupled-limits.md",
        modelled_delay,
        in_each(
            [
                *(f"--delay-periods {delay.removesuffix(' T')}" for delay in MODELLED),
                REAL_ACTUATOR,
                REAL_ACTUATOR + " --model-delay {1} --model-lag 0 --model-gain 1",
            ]
        ),
    ),
    "steps-to-coupled": ("coupled.md", damping_rules, [["suite", "--columns", "experiments/columns/ablation.toml"]]),
    "coupled-scenes": (
        "coupled.md",
        scene_heights(["fig4", "fig5", *COUPLED_SCENES], ("hfcr", "coupled")),
        [[*COUPLED, *DAMPERS]],
    ),
    "map-bounces": ("map.md", BOUNCES, [["map"]]),
    "map-stays": ("map.md", STAYS, [["map"]]),
    "advice": ("map.md", advice, [[*ADVICE, "--mass", "0.05"]]),
    "wrong-mass-dampers": ("suite.md", robustness, [[*WRONG_MASS, *DAMPERS]]),
    "line-hold": ("coupled.md", line_hold, lines()),
    "desk": ("suite.md", actuators("desk"), [[*REAL, "desk"]]),
    "real": ("suite.md", actuators("real"), [[*REAL, "real"]]),
    "steps": ("suite.md", actuators("steps"), [[*REAL, "steps"]]),
    "worlds": ("world-methods.md", worlds, [["compare", "experiments/worlds/*.toml"]]),
    "random-worlds": ("worlds.md", random_worlds, WORLDS[0]),
    "random-worlds-free": ("worlds.md", random_worlds, WORLDS[1]),
    "readme": ("../../README.md", readme, [["suite", "--seeds", "7", "--columns", "experiments/columns/readme.toml"]]),
}
