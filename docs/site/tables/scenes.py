"""Scenes of many bodies, worlds, environments, distances and shapes."""
import statistics

from .common import listed, number, of, pivot, rows_of, short, span, table, three

MANY = {
    "1k": "`--frames 30 --repeats 2 --exact off`",
    "1k-exact": "the same, `--exact on`",
    "3k-slow": "`--bodies 3000 --frames 30 --pace 0.1 --exact off` (slow motion)",
    "3k-slow-exact": "the same, `--exact on`",
    "10k": "`--bodies 10000 --frames 10 --exact off`",
    "10k-exact": "the same, `--exact on`",
}


def frames_of_many(name):
    """The frames that count: the first three warm up."""
    return rows_of(f"many/{name}")[3:]


def many_mean(name, *columns):
    frames = frames_of_many(name)
    return sum(float(r[c]) for r in frames for c in columns) / len(frames)


def many_ratio(name):
    return many_mean(name, "fcl_ms") / many_mean(name, "ms")


def many_ratios(*names):
    return span([many_ratio(name) for name in names])


def many():
    last = {name: frames_of_many(name)[-1] for name in MANY}
    return listed(MANY, {
        "`bench many`": MANY.get,
        "FCL, ms": lambda name: f"{many_mean(name, 'fcl_ms'):.1f}",
        "oncollide, ms": lambda name: f"{many_mean(name, 'ms'):.2f}",
        "median of the ratios":
            lambda name: f"{statistics.median(float(r['fcl_ms']) / float(r['ms']) for r in frames_of_many(name)):.1f}",
        "ratio of the totals": lambda name: f"{many_ratio(name):.1f}",
        "candidates of the last frame": lambda name: number(last[name]["candidates"]),
        "left over": lambda name: number(last[name]["left_over"]),
        "false positives": lambda name: number(last[name]["false_positives"]),
    })


def many_pairs():
    """The share of pairs that each method decides in `many`, and the time per frame: means over the counted frames."""
    methods = {"gap": "by_gap", "outer hulls": "by_hull", "inner spheres": "by_inner_spheres", "hint": "by_witness"}
    pairs = lambda name: many_mean(name, "narrowed")
    share = lambda column: lambda name: f"{100 * many_mean(name, column) / pairs(name):.0f} %"
    narrow_ms = lambda name: many_mean(name, "ocst_ms", "exact_ms")
    return listed(MANY, {
        "`bench many`": MANY.get,
        **{title: share(column) for title, column in methods.items()},
        "traversal": lambda name: f"{100 * (1 - many_mean(name, *methods.values()) / pairs(name)):.0f} %",
        "rows of boxes per pair": lambda name: f"{many_mean(name, 'cell_pairs') / pairs(name):.1f}",
        "bounds, ms": lambda name: f"{many_mean(name, 'bounds_ms'):.2f}",
        "broad, ms": lambda name: f"{many_mean(name, 'broad_ms'):.2f}",
        "narrow, ms": lambda name: f"{narrow_ms(name):.2f}",
        "ns per pair": lambda name: f"{1e6 * narrow_ms(name) / pairs(name):,.0f}",
        "FCL, ns per pair": lambda name: f"{1e6 * many_mean(name, 'fcl_narrow_ms') / pairs(name):,.0f}",
    })


def exact_cost():
    """Times of exact frames over times of frames with an error of 1 % of the smaller body."""
    titles = {"1k": "1,000 meshes that move", "3k-slow": "3,000 that move slowly", "10k": "10,000 that move"}
    rows = [(title, many_mean(name, "ms"), many_mean(f"{name}-exact", "ms")) for name, title in titles.items()]
    jumps = {r["exact"]: float(r["step_ms"]) for r in rows_of("world")
             if r["change"] == "move" and r["count"] == r["bodies"] and not r["skip"]}
    rows.append(("100,000 that jump", jumps["off"], jumps["predicates"]))
    return table(["scene `many`", "1 %, ms per frame", "exact, ms per frame", "exact over 1 %"],
                 [[title, f"{off:,.2f}", f"{on:,.2f}", f"{on / off:.2f}"] for title, off, on in rows])


WORLDS = {
    "campus": "`campus`: 500 shapes and meshes, 1.09 million cells",
    "st-helens": "`st-helens`: 1,000 cars, lorries and drones, {triangles}",
    "chunks": "`chunks`: 2,000 balls over 16,384 meshes, {triangles}",
    "tiles": "`tiles`: 2,000 vehicles over 10,000 cooked tiles, {triangles}",
    "swarm": "`swarm`: 10 million balls, 100,000 of them moving",
}


def worlds():
    """Times of both libraries in one process, memory of each in its own. Without FCL: an estimate of the memory of its models."""
    chunks = rows_of("worlds/chunks")[0]
    fcl_bytes = 1e6 * float(chunks["fcl_mb"]) / float(chunks["triangles"])
    rows = [dict(rows_of(f"worlds/{name}")[0], name=name) for name in WORLDS]

    def title(r):
        triangles = float(r["triangles"])
        count = f"{three(triangles / 1e6)} million" if triangles >= 1e6 else f"{triangles:,.0f}"
        return WORLDS[r["name"]].format(triangles=f"{count} triangles")

    def memory(r):
        if not r["fcl_ms"]:
            return f"over {round(fcl_bytes * float(r['triangles']) / 1e6, -3):,.0f}, {float(r['process_mb']):,.0f}"
        alone = [rows_of(f"worlds/{r['name']}-{who}")[0] for who in ("fcl", "oncollide")]
        return ", ".join(f"{float(one['process_mb']):,.0f}" for one in alone)

    both = lambda column: lambda r: f"{short(r['fcl_' + column]) if r['fcl_ms'] else '-'}, {short(r[column])}"
    return listed(rows, {
        "world": title,
        "first result, ms: FCL, oncollide": both("first_ms"),
        "frame, ms: FCL, oncollide": both("ms"),
        "ratio": lambda r: f"{float(r['fcl_ms']) / float(r['ms']):.1f}" if r["fcl_ms"] else "-",
        "slowest frame, ms: oncollide": of("slowest_ms", short),
        "process, MB: FCL, oncollide": memory,
    })


def world():
    titles = {"none": "nothing changes", "move": "{} move", "exchange": "{} removed, {} added"}
    rows = rows_of("world")
    columns = list(dict.fromkeys((r["change"], r["count"]) for r in rows))

    def name(r):
        if r["skip"]:
            return "`--skip refinement`: boxes alone"
        return "exact" if r["exact"] != "off" else "`--exact off`: 1 % of the smaller body"

    def cell(r):
        ms = float(r["changes_ms"]) + float(r["step_ms"])
        return "below 0.001" if ms < 0.001 else f"{ms:,.0f}"
    return table([""] + [titles[c].format(number(n), number(n)) for c, n in columns],
                 [[title] + [cell(by[c]) for c in columns]
                  for title, by in pivot(rows, name, lambda r: (r["change"], r["count"])).items()])


# Environments, distances and shapes.

ENVIRONMENTS = {
    "building": "building, 30 x 30 rooms at 6 cm (map)",
    "campus": "campus, 1.09 million cells of 0.2 m (map)",
    "hills": "hills, 500,000 triangles (height grid)",
    "hills-mesh": "the same hills as a mesh",
    "st-helens": "Mount St. Helens, 305,000 triangles (height grid)",
}
PERCENTS = ["0.1", "1", "5", "10", "25", "50", "100", "200"]
DISTANCES = {**{f"{p} %": lambda by, p=p: short(by[p]["ratio"]) for p in PERCENTS},
             "microseconds at 10 %: oncollide, FCL": lambda by: f"{short(by['10']['us'])}, {short(by['10']['fcl_us'])}"}


def by_environment(rows, column):
    """One row per environment and kind of bodies; the columns of the table come from `column` of the data."""
    made = pivot(rows, lambda r: (r["environment"], r["bodies"]), column)
    return [dict(made[e, bodies], environment=title, bodies=bodies) for e, title in ENVIRONMENTS.items()
            for bodies in ("meshes", "shapes")]


def environments():
    errors = {"1 m": "1", "0.1 m": "0.1", "0.01 m": "0.01", "exact": "exact"}
    exact = lambda *cells: lambda by: ", ".join(cell(by["exact"]) for cell in cells)
    return listed(by_environment(rows_of("environments"), "error"), {
        "environment": of("environment", str), "bodies": of("bodies", str),
        **{title: lambda by, e=e: f"{float(by[e]['ratio']):.1f}" for title, e in errors.items()},
        "FCL, exact, ms per frame": exact(of("fcl_ms", ".1f")),
        "first result, ms: oncollide, FCL": exact(of("first_ms", ".1f"), of("fcl_first_ms", ",.0f")),
        "trees, MB: oncollide, FCL": exact(of("trees_mb", ".1f"), of("fcl_mb", ".1f")),
    })


def environment_ratios():
    return span([float(r["ratio"]) for r in rows_of("environments") if r["error"] == "exact"])


def distances():
    return listed(by_environment(rows_of("distances", "map_distances"), "percent"),
                  {"environment": of("environment", str), "bodies": of("bodies", str), **DISTANCES})


def shape_distances():
    made = pivot(rows_of("shape_distances"), "environment", "percent")
    return listed([dict(by, name=name) for name, by in made.items()], {"from": of("name", str), **DISTANCES})


def self_contacts():
    return listed([by for by in pivot(rows_of("self", "self_files"), "mesh", "contender").values() if "cgal" in by], {
        "mesh": lambda by: by["oncollide"]["mesh"],
        "triangles": lambda by: number(by["oncollide"]["triangles"]),
        "pairs": lambda by: number(by["oncollide"]["pairs"]),
        "oncollide, ms": lambda by: three(by["oncollide"]["ms"]),
        "CGAL, ms": lambda by: three(by["cgal"]["ms"]),
        "ratio": lambda by: f"{float(by['cgal']['ratio']):.1f}",
    })


def deform():
    return listed(rows_of("deform"), {
        "scene": of("scene", str),
        "library": of("contender", str),
        "update, ms": of("update_ms", three),
        "query, ms": of("query_ms", three),
        "ratio": of("ratio", ".1f"),
        "update, as copies of the vertices": of("copies", ".1f"),
        "boxes fitted anew, %": lambda r: f"{float(r['refitted_percent']):.1f}" if float(r["refitted_percent"]) else "",
        "pairs": of("pairs"),
    })


def dig():
    return listed(rows_of("dig"), {
        "library": of("contender", str),
        "update, ms": of("update_ms", three),
        "contacts, ms": of("contacts_ms", three),
        "ratio": of("ratio", ".1f"),
        "update, as copies of the heights": of("copies", ".1f"),
    })


def shapes():
    rows = {(r["a"], r["b"]): float(r["fcl_ns"]) / float(r["oncollide_ns"]) for r in rows_of("shapes")}
    names = list(dict.fromkeys([a for a, _ in rows] + [b for _, b in rows]))
    return table([""] + [name.replace("_", "-") for name in names],
                 [[a.replace("_", "-")] + [f"{rows[a, b]:.1f}" if (a, b) in rows else "" for b in names] for a in names])
