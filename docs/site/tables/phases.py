"""The broad phase, the narrow phase, and the main ratios of all benchmarks."""
import statistics

from . import scenes
from .common import distinct, listed, number, of, pivot, rows_of, span, table, three

OWN_TREES = ("kd", "octree", "dynamic")


def broad_rows():
    """(boxes, {contender: {scene: data}}) of each size."""
    rows = rows_of("broad", "broad_1m")
    return [(boxes, pivot([r for r in rows if r["boxes"] == boxes], "contender", "scene")) for boxes in distinct(rows, "boxes")]


def fastest_ratios(by):
    """For each scene, the time of the fastest other contender over the time of the fastest tree of oncollide."""
    return {scene: max(float(by[tree][scene]["ratio"]) for tree in OWN_TREES) for scene in by["kd"]}


def broad():
    return "\n".join(
        table([f"{number(boxes)} boxes, ms", *by["kd"]],
              [[f"`{c}`", *(three(ms[s]["ms"]) if s in ms else "-" for s in by["kd"])] for c, ms in by.items()] +
              [["*fastest other / fastest oncollide*", *(f"{ratio:.1f}" for ratio in fastest_ratios(by).values())]])
        for boxes, by in broad_rows())


def broad_ratios():
    rows = broad_rows()
    return table(["boxes", *rows[0][1]["kd"]],
                 [[number(boxes), *(f"{ratio:.1f}" for ratio in fastest_ratios(by).values())] for boxes, by in rows])


def delimitation():
    ruled_out = lambda r: ", ".join(" of ".join(map(number, level.split("/"))) for level in r["regions"].split())
    city, whole = (rows_of(f"delimitation/{name}")[3:] for name in ("city", "city_whole"))
    median = lambda rows, *columns: statistics.median(sum(float(r[c]) for c in columns) for r in rows)
    bodies = int(whole[-1]["left"])
    rows = [(f"`city`, {bodies:,} bodies", city[-1], bodies, median(city, "delimitation_ms"),
             *(median(rows, "delimitation_ms", "broad_ms") for rows in (city, whole)))]
    for (scene, boxes), by in pivot(rows_of("delimitation/boxes"), lambda r: (r["scene"], r["boxes"]), "contender").items():
        r = by["dynamic"]
        rows.append((f"`{scene}`, {number(boxes)} boxes", r, int(boxes),
                     *map(float, (r["delimitation_ms"], r["ms"], by["kd"]["ms"]))))
    return table(["scene", "regions ruled out, level by level", "bodies left", "delimitation", "whole broad phase",
                  "without delimitation"],
                 [[title, ruled_out(r), f"{100 * int(r['left']) / n:.2g} %", *(f"{t:.2g} ms" for t in ms)]
                  for title, r, n, *ms in rows])


QUERIES = {"boolean": "yes or no", "all": "all pairs of triangles", "distance": "distance"}


def medians(name):
    """Each contender's time at each distance, from `bench narrow --csv`."""
    rows = sorted(rows_of(name), key=lambda r: list(QUERIES).index(r["ask"]))

    def faults(by):
        sums = [(sum(int(r[k]) for r in by.values()), word) for k, word in (("missed", "missed"), ("extra", "too many"))]
        return ", ".join(f"{number(n)} {word}" for n, word in sums if n)
    cell = lambda r: f"{three(r['median_us'])} ({float(r['ratio_median']):.2g})"
    return table(["query", "contender", *distinct(rows, "distance"), "results"],
                 [[QUERIES[ask], f"`{contender}`", *map(cell, by.values()), faults(by)]
                  for (ask, contender), by in pivot(rows, lambda r: (r["ask"], r["contender"]), "distance").items()])


def narrow_pairs():
    """Means over all distances, and how many times as long the faster one of FCL's trees takes."""
    out = []
    for name in ("armadillo_86k_bunny_69k", "spot_beetle", "teapot_woody", "dragon_5104_cow_5144"):
        by = pivot(rows_of(f"narrow/{name}"), lambda r: (r["ask"], r["contender"]), "distance")

        def mean(query, contender, column):
            rows = by.get((query, contender), {}).values()
            poses = sum(int(r["poses"]) for r in rows)
            return sum(float(r[column]) * int(r["poses"]) for r in rows) / poses if poses else float("inf")
        meshes = next(iter(by["boolean", "exact"].values()))
        for query, title in QUERIES.items():
            cells = []
            for column in ("mean_us", "loop_us"):
                exact = mean(query, "exact", column)
                cells.append(f"{three(exact)} ({min(mean(query, c, column) for c in ('fcl-obb', 'fcl-obbrss')) / exact:.1f})")
            out.append([f"`{meshes['mesh_a']}`, `{meshes['mesh_b']}`", title, *cells])
    return table(["meshes", "query", "repeated at once, us", "in a loop, us"], out)


def narrow_ratios(query, contender):
    """A contender's median over oncollide's exact one, at each distance of `bench narrow`."""
    by = pivot([r for r in rows_of("narrow") if r["ask"] == query], "contender", "distance")
    return span([float(r["median_us"]) / float(by["exact"][place]["median_us"]) for place, r in by[contender].items()])


def planner():
    titles = {"fcl": "FCL, exact", "bound": "oncollide, within its error", "exact": "oncollide, exact"}
    side = lambda r, which: f"{r[which]} of {number(r[which + '_triangles'])}"
    return listed(rows_of("planner", "planner_meshes"), {
        "meshes": lambda r: f"{side(r, 'fixed')}, {side(r, 'moving')} triangles",
        "poses that collide": lambda r: f"{100 * int(r['colliding']) / int(r['poses']):.0f} %",
        "query": lambda r: titles[r["who"]],
        "threads": of("threads"),
        "first call, s": of("first_s", ".2f"),
        "queries per second": lambda r: number(int(float(r["poses"]) / float(r["second_s"]) / 1000) * 1000),
        "ratio": of("ratio", ".1f"),
    })


def headline():
    """The main ratios: the time of another library over the time of oncollide."""
    ratios = lambda over, under, *names: [float(r[over]) / float(r[under]) for r in rows_of(*names) if r[over]]
    to_environments = [float(r["ratio"]) for r in rows_of("distances", "map_distances")]
    meshes = {"FCL": "fcl-obbrss", "ODE": "ode", "Bullet GImpact": "bullet-gimpact", "CGAL": "cgal",
              "Embree, refitted": "embree-refit"}
    rows = [
        ("1,000 and 10,000 moving meshes, exact", "FCL", scenes.many_ratios("1k-exact", "10k-exact"), "#many-moving-bodies"),
        ("the same, error 1 % of the smaller body", "FCL", scenes.many_ratios("1k", "10k"), "#many-moving-bodies"),
        ("500 bodies in large environments, exact", "FCL", scenes.environment_ratios(), "#large-environments"),
        ("worlds from files, exact", "FCL", span(ratios("fcl_ms", "ms", *(f"worlds/{name}" for name in scenes.WORLDS))),
         "#worlds-from-files"),
        *(("two meshes of 5,100 triangles: whether they meet, exact" if library == "FCL" else "the same", library,
           narrow_ratios("boolean", contender), "#narrow-phase") for library, contender in meshes.items()),
        ("two meshes: all pairs of triangles that meet", "FCL", narrow_ratios("all", "fcl-obbrss"), "#narrow-phase"),
        ("two meshes: distance", "FCL", narrow_ratios("distance", "fcl-obbrss"), "#narrow-phase"),
        ("100,000 sampled poses of two meshes in one call, exact", "FCL",
         span([float(r["ratio"]) for r in rows_of("planner", "planner_meshes") if (r["who"], r["threads"]) == ("exact", "1")]),
         "benchmarks-cases.md#planner-queries"),
        ("distance of a body to a large environment", "FCL", f"{min(to_environments):.1f} to {three(max(to_environments))}",
         "#distances-to-large-environments"),
        ("distance of two shapes", "FCL", span([float(r["ratio"]) for r in rows_of("shape_distances")]),
         "benchmarks-cases.md#distances-of-two-shapes"),
        ("close pairs of shapes: whether they meet", "FCL", span(ratios("fcl_ns", "oncollide_ns", "shapes")),
         "#close-pairs-of-shapes"),
        ("all pairs of 100,000 boxes", "the fastest of FCL, Embree, CGAL and Bullet",
         span(fastest_ratios(dict(broad_rows())["100000"]).values()), "#broad-phase"),
    ]
    return table(["task, one thread", "other library", "its time / oncollide's time"],
                 [[f"[{task}]({place})", library, ratio] for task, library, ratio, place in rows])
