#!/usr/bin/env python3
"""Tables, headline figures and plots of the pages and README.md, from docs/data, which the benchmarks wrote.

    figures.py --write          writes tables between <!-- figures: NAME --> and <!-- end -->, and figures within a
                                sentence between <!-- figure: NAME --> and <!-- end -->
    figures.py --check          fails if a page differs from its data
    figures.py --plots FOLDER   draws the plots of the site (needs matplotlib)
"""
import argparse
import csv
import json
import pathlib
import re
import statistics
import sys

DOCS = pathlib.Path(__file__).resolve().parent.parent

ENVIRONMENTS = {
    "building": "building, 30 x 30 rooms at 6 cm (map)",
    "campus": "campus, 1.09 million cells of 0.2 m (map)",
    "hills": "hills, 500,000 triangles (height grid)",
    "hills-mesh": "the same hills as a mesh",
    "st-helens": "Mount St. Helens, 305,000 triangles (height grid)",
}
PERCENTS = ["0.1", "1", "5", "10", "25", "50", "100", "200"]


def rows_of(*names):
    rows = []
    for name in names:
        with open(DOCS / "data" / f"{name}.csv", newline="", encoding="utf-8") as file:
            rows += list(csv.DictReader(file))
    return rows


def table(header, rows):
    lines = ["| " + " | ".join(header) + " |", "|" + "---|" * len(header)]
    return "\n".join(lines + ["| " + " | ".join(row) + " |" for row in rows]) + "\n"


def short(value):
    """Three digits or fewer behind the point than anyone reads: 9.7, 17.6, 35, 1,801."""
    value = float(value)
    return f"{value:.1f}" if value < 20 else f"{value:,.0f}"


def number(text):
    return f"{int(text):,}"


def three(value):
    """Three digits: 0.0511, 7.69, 1,090."""
    value = float(value)
    return f"{value:,.0f}" if value >= 100 else f"{value:.3g}"


def environments():
    out = []
    for environment, title in ENVIRONMENTS.items():
        for bodies in ("meshes", "shapes"):
            of = {r["error"]: r for r in rows_of("environments")
                  if (r["environment"], r["bodies"]) == (environment, bodies)}
            exact = of["exact"]
            out.append([title, bodies] + [f"{float(of[e]['ratio']):.1f}" for e in ("1", "0.1", "0.01", "exact")] +
                       [f"{float(exact['fcl_ms']):.1f}",
                        f"{float(exact['first_ms']):.1f}, {float(exact['fcl_first_ms']):,.0f}",
                        f"{float(exact['trees_mb']):.1f}, {float(exact['fcl_mb']):.1f}"])
    return table(["environment", "bodies", "1 m", "0.1 m", "0.01 m", "exact", "FCL, exact, ms per frame",
                  "first result, ms: oncollide, FCL", "trees, MB: oncollide, FCL"], out)


def ratios_by_distance(rows):
    of = {r["percent"]: r for r in rows}
    return [short(of[p]["ratio"]) for p in PERCENTS] + [f"{short(of['10']['us'])}, {short(of['10']['fcl_us'])}"]


DISTANCES = [f"{p} %" for p in PERCENTS] + ["microseconds at 10 %: oncollide, FCL"]


def distances():
    rows = rows_of("distances", "map_distances")
    return table(["environment", "bodies"] + DISTANCES,
                 [[title, bodies] + ratios_by_distance([r for r in rows if (r["environment"], r["bodies"]) ==
                                                        (environment, bodies)])
                  for environment, title in ENVIRONMENTS.items() for bodies in ("meshes", "shapes")])


def shape_distances():
    rows = rows_of("shape_distances")
    names = list(dict.fromkeys(r["environment"] for r in rows))
    return table(["from"] + DISTANCES,
                 [[name] + ratios_by_distance([r for r in rows if r["environment"] == name]) for name in names])


def shapes():
    rows = {(r["a"], r["b"]): float(r["fcl_ns"]) / float(r["oncollide_ns"]) for r in rows_of("shapes")}
    names = list(dict.fromkeys([a for a, _ in rows] + [b for _, b in rows]))
    shown = [name.replace("_", "-") for name in names]
    return table([""] + shown, [[title] + [f"{rows[a, b]:.1f}" if (a, b) in rows else "" for b in names]
                                for a, title in zip(names, shown)])


STYLES = {
    "obj": "OBJ, six decimals, `f a b c`",
    "obj-full": "OBJ, `vt`, `vn`, `f a/b/c`, comments, CR LF",
    "obj-back": "OBJ, negative numbers of vertices",
    "obj-exact": "OBJ, every digit of a double",
    "stl": "STL, binary, welded",
    "stl-mixed": "STL, binary, welded, triangles in no order",
    "ply": "PLY, binary, floats",
}


def reading():
    return table(["", "MB", "triangles per second", "peak MB"],
                 [[STYLES[r["style"]], f"{float(r['bytes']) / 1e6:,.0f}",
                   f"{float(r['triangles_per_s']) / 1e6:.1f} million", f"{float(r['peak_bytes']) / 1e6:,.0f}"]
                  for r in rows_of("reading")])


MANY = {
    "1k": "`--frames 30 --repeats 2 --exact off`",
    "1k-exact": "the same, `--exact on`",
    "3k-slow": "`--bodies 3000 --frames 30 --pace 0.1 --exact off` (slow motion)",
    "3k-slow-exact": "the same, `--exact on`",
    "10k": "`--bodies 10000 --frames 10 --exact off`",
    "10k-exact": "the same, `--exact on`",
}


def many_frames(name):
    """(FCL, oncollide) in milliseconds of each frame that counts: the first three warm up."""
    return [(float(r["fcl_ms"]), float(r["ms"])) for r in rows_of(f"many/{name}")[3:]]


def many():
    out = []
    for name, title in MANY.items():
        frames, last = many_frames(name), rows_of(f"many/{name}")[-1]
        fcl, ours = (sum(f[k] for f in frames) for k in (0, 1))
        out.append([title, f"{fcl / len(frames):.1f}", f"{ours / len(frames):.2f}",
                    f"{statistics.median(a / b for a, b in frames):.1f}", f"{fcl / ours:.1f}",
                    number(last["candidates"]), number(last["left_over"]), number(last["false_positives"])])
    return table(["`bench many`", "FCL, ms", "oncollide, ms", "median of the ratios", "ratio of the totals",
                  "candidates of the last frame", "left over", "false positives"], out)


def exact_cost():
    """Times of exact frames over times of frames with an error of 1 % of the smaller body."""
    def mean(name):
        frames = many_frames(name)
        return sum(f[1] for f in frames) / len(frames)
    titles = {"1k": "1,000 meshes that move", "3k-slow": "3,000 that move slowly", "10k": "10,000 that move"}
    out = [[title, mean(name), mean(f"{name}-exact")] for name, title in titles.items()]
    jumps = {r["exact"]: float(r["step_ms"]) for r in rows_of("world")
             if r["change"] == "move" and r["count"] == r["bodies"] and not r["skip"]}
    out.append(["100,000 that jump", jumps["off"], jumps["predicates"]])
    return table(["scene `many`", "1 %, ms per frame", "exact, ms per frame", "exact over 1 %"],
                 [[title, f"{off:,.2f}", f"{on:,.2f}", f"{on / off:.2f}"] for title, off, on in out])


def span(ratios):
    """The range of ratios in a sentence: 8.7 to 10.5."""
    return f"{min(ratios):.1f} to {max(ratios):.1f}"


def many_totals(*names):
    return span([sum(f[0] for f in many_frames(name)) / sum(f[1] for f in many_frames(name)) for name in names])


def environment_ratios():
    return span([float(r["ratio"]) for r in rows_of("environments") if r["error"] == "exact"])


def halved_error():
    """Returns the middle half of the ratios of times when the error of spheres is halved, from 50 % to 0.8 % of a body."""
    ms = {name: {r["variant"]: float(r["ms_median"]) for r in rows_of(name)} for name in STUDIES}
    lower, _, upper = statistics.quantiles(ms[name][f"spheres, depth {d + 1}"] / ms[name][f"spheres, depth {d}"]
                                           for name in STUDIES for d in range(2, 8))
    return span([lower, upper])


def narrow_ratios(query, contender):
    """A contender's median over oncollide's exact one, at each distance of `bench narrow`."""
    median = {(r["contender"], r["distance"]): float(r["median_us"]) for r in rows_of("narrow") if r["ask"] == query}
    return span([us / median["exact", place] for (who, place), us in median.items() if who == contender])


def headline():
    """The main ratios: the time of another library over the time of oncollide."""
    worlds = [float(r["fcl_ms"]) / float(r["ms"]) for name in WORLDS for r in rows_of(f"worlds/{name}") if r["fcl_ms"]]
    to_environments = [float(r["ratio"]) for r in rows_of("distances", "map_distances")]
    of_shapes = [float(r["ratio"]) for r in rows_of("shape_distances")]
    close = [float(r["fcl_ns"]) / float(r["oncollide_ns"]) for r in rows_of("shapes")]
    boxes = [r for r in rows_of("broad") if r["boxes"] == "100000"]
    fastest = [max(float(r["ratio"]) for r in boxes if (r["scene"], r["contender"]) in
                   [(scene, c) for c in ("kd", "octree", "dynamic")]) for scene in dict.fromkeys(r["scene"] for r in boxes)]
    rows = [["1,000 and 10,000 moving meshes, exact", "FCL", many_totals("1k-exact", "10k-exact"), "many-moving-bodies"],
            ["the same, error 1 % of the smaller body", "FCL", many_totals("1k", "10k"), "many-moving-bodies"],
            ["500 bodies in large environments, exact", "FCL", environment_ratios(), "large-environments"],
            ["worlds from files, exact", "FCL", span(worlds), "worlds-from-files"]]
    for library, contender in (("FCL", "fcl-obbrss"), ("ODE", "ode"), ("Bullet GImpact", "bullet-gimpact"), ("CGAL", "cgal"),
                               ("Embree, refitted", "embree-refit")):
        rows.append(["two meshes of 5,100 triangles: whether they meet, exact" if library == "FCL" else "the same", library,
                     narrow_ratios("boolean", contender), "narrow-phase"])
    rows += [["two meshes: all pairs of triangles that meet", "FCL", narrow_ratios("all", "fcl-obbrss"), "narrow-phase"],
             ["two meshes: distance", "FCL", narrow_ratios("distance", "fcl-obbrss"), "narrow-phase"],
             ["distance of a body to a large environment", "FCL", f"{min(to_environments):.1f} to {three(max(to_environments))}",
              "distances-to-large-environments"],
             ["distance of two shapes", "FCL", span(of_shapes), "distances-to-large-environments"],
             ["close pairs of shapes: whether they meet", "FCL", span(close), "close-pairs-of-shapes"],
             ["all pairs of 100,000 boxes", "the fastest of FCL, Embree, CGAL and Bullet", span(fastest), "broad-phase"]]
    return table(["task, one thread", "other library", "its time / oncollide's time"],
                 [[f"[{task}](#{place})", library, ratio] for task, library, ratio, place in rows])


def many_pairs():
    """The share of pairs that each method decides in `many`, and the time per frame: means over the counted frames."""
    out = []
    for name, title in MANY.items():
        frames = rows_of(f"many/{name}")[3:]
        mean = lambda *columns: sum(float(r[c]) for r in frames for c in columns) / len(frames)
        pairs = mean("narrowed")
        decided = [mean(f"by_{what}") for what in ("gap", "hull", "inner_spheres", "witness")]
        shares = [f"{100 * n / pairs:.0f} %" for n in decided + [pairs - sum(decided)]]
        out.append([title, *shares, f"{mean('cell_pairs') / pairs:.1f}", f"{mean('bounds_ms'):.2f}", f"{mean('broad_ms'):.2f}",
                    f"{mean('ocst_ms', 'exact_ms'):.2f}", f"{1e6 * mean('ocst_ms', 'exact_ms') / pairs:,.0f}",
                    f"{1e6 * mean('fcl_narrow_ms') / pairs:,.0f}"])
    return table(["`bench many`", "gap", "outer hulls", "inner spheres", "hint", "traversal", "rows of boxes per pair", "bounds, ms", "broad, ms",
                  "narrow, ms", "ns per pair", "FCL, ns per pair"], out)


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
    out = []
    for name, title in WORLDS.items():
        row, triangles = rows_of(f"worlds/{name}")[0], float(rows_of(f"worlds/{name}")[0]["triangles"])
        ours = [short(row["first_ms"]), short(row["ms"]), short(row["slowest_ms"])]
        if row["fcl_ms"]:
            fcl = [short(row["fcl_first_ms"]), short(row["fcl_ms"]), f"{float(row['fcl_ms']) / float(row['ms']):.1f}"]
            memory = [f"{float(rows_of(f'worlds/{name}-{who}')[0]['process_mb']):,.0f}" for who in ("fcl", "oncollide")]
        else:
            fcl = ["-", "-", "-"]
            memory = [f"over {round(fcl_bytes * triangles / 1e6, -3):,.0f}", f"{float(row['process_mb']):,.0f}"]
        count = f"{three(triangles / 1e6)} million" if triangles >= 1e6 else f"{triangles:,.0f}"
        out.append([title.format(triangles=f"{count} triangles"),
                    f"{fcl[0]}, {ours[0]}", f"{fcl[1]}, {ours[1]}", fcl[2], ours[2], f"{memory[0]}, {memory[1]}"])
    return table(["world", "first result, ms: FCL, oncollide", "frame, ms: FCL, oncollide", "ratio",
                  "slowest frame, ms: oncollide", "process, MB: FCL, oncollide"], out)


QUERIES = {"boolean": "yes or no", "all": "all pairs of triangles", "distance": "distance"}


def medians(name):
    """Each contender's time at each distance, from `bench narrow --csv`."""
    rows = rows_of(name)
    places = list(dict.fromkeys(r["distance"] for r in rows))
    out = []
    for query, title in QUERIES.items():
        for contender in dict.fromkeys(r["contender"] for r in rows if r["ask"] == query):
            of = [r for r in rows if (r["ask"], r["contender"]) == (query, contender)]
            extra, missed = (sum(int(r[k]) for r in of) for k in ("extra", "missed"))
            faults = ", ".join(f"{number(n)} {word}" for n, word in ((missed, "missed"), (extra, "too many")) if n)
            out.append([title, f"`{contender}`"] + [f"{three(r['median_us'])} ({float(r['ratio_median']):.2g})" for r in of] +
                       [faults])
    return table(["query", "contender"] + places + ["results"], out)


def narrow():
    return medians("narrow")


def narrow_large():
    return medians("narrow_large")


def narrow_pairs():
    """Means over all distances, and how many times as long the faster one of FCL's trees takes."""
    out = []
    for name in ("armadillo_86k_bunny_69k", "spot_beetle", "teapot_woody", "dragon_5104_cow_5144"):
        rows = rows_of(f"narrow/{name}")
        for query, title in QUERIES.items():
            def mean(contender, column):
                of = [r for r in rows if (r["ask"], r["contender"]) == (query, contender)]
                return sum(float(r[column]) * int(r["poses"]) for r in of) / sum(int(r["poses"]) for r in of)
            peers = [c for c in ("fcl-obb", "fcl-obbrss") if any((r["ask"], r["contender"]) == (query, c) for r in rows)]
            cells = [f"{three(mean('exact', k))} ({min(mean(c, k) for c in peers) / mean('exact', k):.1f})" for k in ("mean_us", "loop_us")]
            out.append([f"`{rows[0]['mesh_a']}`, `{rows[0]['mesh_b']}`", title] + cells)
    return table(["meshes", "query", "repeated at once, us", "in a loop, us"], out)


STUDIES = {"study/paper": "`paper --every 8`, four bodies of 1,500 triangles", "study/many": "`many --frames 6`, 1,000 bodies",
           "study/poses": "`--poses --every 3 --age 1000000`, bunny and cow"}


def study():
    out = []
    for name, title in STUDIES.items():
        rows = {r["variant"]: r for r in rows_of(name)}
        for volume in ("spheres", "OBBs"):
            of = [rows[f"{volume}, depth {d}"] for d in range(2, 9)] + [rows[f"{volume}, predicates"]]
            out.append([f"{title}; {volume}"] + [f"{float(rows['FCL']['ms_median']) / float(r['ms_median']):.2g}" for r in of])
    return table(["", "50 %", "25 %", "12.5 %", "6.3 %", "3.1 %", "1.6 %", "0.8 %", "exact"], out)


def study_peers():
    names = {"OBBs, predicates": "oncollide, exact", "FCL": "FCL", "ODE": "ODE", "Bullet": "Bullet"}
    out = []
    for name, title in STUDIES.items():
        rows = {r["variant"]: r for r in rows_of(name)}
        out.append([title] + [three(1000 * float(rows[v]["ms_median"])) for v in names] +
                   [f"{number(rows['Bullet']['missed'])}, {number(rows['Bullet']['invented'])}"])
    return table(["microseconds, median"] + list(names.values()) + ["Bullet: missed, invented"], out)


def broad():
    rows, out = rows_of("broad", "broad_1m"), []
    scenes = list(dict.fromkeys(r["scene"] for r in rows))
    for boxes in dict.fromkeys(r["boxes"] for r in rows):
        of = {(r["contender"], r["scene"]): r for r in rows if r["boxes"] == boxes}
        contenders = list(dict.fromkeys(c for c, _ in of))
        lines = [[f"`{c}`"] + [three(of[c, s]["ms"]) if (c, s) in of else "-" for s in scenes] for c in contenders]
        ratios = [max((float(of[c, s]["ratio"]) for c in ("kd", "octree", "dynamic") if (c, s) in of), default=0) for s in scenes]
        out.append(table([f"{number(boxes)} boxes, ms"] + scenes,
                         lines + [["*fastest other / fastest oncollide*"] + [f"{r:.1f}" if r else "-" for r in ratios]]))
    return "\n".join(out)


def levels_of(mesh):
    """Rows of `spheres --levels` by kind and level, and a function that gives lengths in thousandths of the longest side."""
    rows = rows_of(f"spheres/{mesh}")
    return {(r["kind"], int(r["level"])): r for r in rows}, lambda r, k: f"{1000 * float(r[k]) / float(r['longest_side']):.1f}"


def spheres():
    out = []
    for mesh in ("paper/bunny", "paper/cow", "paper/dragon", "paper/lamp", "paper/cow_5144", "spot", "armadillo_86k"):
        title = f"{mesh}.obj"
        of, side = levels_of(mesh.removeprefix("paper/"))
        both = lambda kind, level: ", ".join(side(of[kind, level], f"{what}_outside") for what in ("worst", "mean"))
        fine = of["sphere", 5]
        out.append([f"`{title}`", number(fine["triangles"]), number(fine["count"]), both("sphere", 5), f"{float(fine['volume']):.3f}",
                    f"{number(of['box', 3]['count'])}: {both('box', 3)}", f"{number(of['box', 4]['count'])}: {both('box', 4)}", f"{float(of['box', 4]['volume']):.3f}",
                    f"{int(of['box', 4]['tree_bytes']) / int(fine['triangles']):.0f}"])
    out.append(["published: octree, depth 5", "", "about 4,100", "mean 19 to 26", "", "", "", "", ""])
    out.append(["published: adaptive medial axis", "", "484", "mean 5 to 7, with 2.0 to 2.6 % of the surface uncovered"] + 5 * [""])
    return table(["mesh", "triangles", "spheres of level 5", "worst, mean", "volume", "boxes of level 3: number, worst, mean",
                  "boxes of level 4: number, worst, mean", "volume", "bytes per triangle, all boxes"], out)


def sphere_levels():
    of, side = levels_of("cow_5144")
    return table(["level", "spheres", "worst, mean", "boxes", "worst, mean"],
                 [[str(level)] + [cell for kind in ("sphere", "box") for cell in
                                  (number(of[kind, level]["count"]),
                                   ", ".join(side(of[kind, level], f"{what}_outside") for what in ("worst", "mean")))]
                  for level in range(6)])


def occlusion_losses():
    titles = {"paper": "`paper --every 4`", "poses": "`--poses --every 4`, bunny and cow", "hard": "`hard --frames 3`",
              "needles": "[`needles.json`](data/gl_query/needles.json): a knot that passes needles of 1 : 100,000 and tiny triangles"}
    out = []
    for name, title in titles.items():
        rows = {r["variant"].removesuffix(", spheres, depth 6"): r for r in rows_of(f"gl_query/{name}")}
        first = rows["spheres, depth 6"]
        out.append([title, number(first["truly_colliding"]), number(int(first["missed"]) + int(rows["gl-compute"]["missed"]))] +
                   [number(rows[f"gl-query {pixels} px"]["missed"]) for pixels in (8, 16, 64)])
    return table(["", "collisions", "`cpu`, `gl-compute`", "8 px", "16 px", "64 px"], out)


def delimitation():
    ruled_out = lambda r: ", ".join(f"{number(a)} of {number(b)}" for a, b in (level.split("/") for level in r["regions"].split()))
    city = [rows_of(f"delimitation/{name}")[3:] for name in ("city", "city_whole")]
    ms = [statistics.median(float(r["delimitation_ms"]) + float(r["broad_ms"]) for r in rows) for rows in city]
    last, bodies = city[0][-1], int(city[1][-1]["left"])
    out = [[f"`city`, {bodies:,} bodies", ruled_out(last), f"{100 * int(last['left']) / bodies:.2g} %",
            f"{statistics.median(float(r['delimitation_ms']) for r in city[0]):.2g} ms", f"{ms[0]:.2g} ms", f"{ms[1]:.2g} ms"]]
    rows = {(r["scene"], r["boxes"], r["contender"]): r for r in rows_of("delimitation/boxes")}
    for (scene, boxes, contender), r in rows.items():
        if contender == "dynamic":
            out.append([f"`{scene}`, {number(boxes)} boxes", ruled_out(r), f"{100 * int(r['left']) / int(boxes):.2g} %",
                        f"{float(r['delimitation_ms']):.2g} ms", f"{float(r['ms']):.2g} ms",
                        f"{float(rows[scene, boxes, 'kd']['ms']):.2g} ms"])
    return table(["scene", "regions ruled out, level by level", "bodies left", "delimitation", "whole broad phase", "without delimitation"], out)


def hard():
    rows = {r["family"]: r for r in rows_of("hard")}
    out = []
    for family, row in rows.items():
        turned = rows.get(f"{family}, turned")
        counts = [r[k] for r in (row, turned or row) for k in ("fcl_missed", "fcl_false")]
        if turned and any(map(int, counts)):
            out.append([family] + [number(c) for c in counts])
    return table(["family", "missed", "invented", "rotated: missed", "invented"], out)


def octants():
    rows = [r for r in rows_of("octants") if r["part"] == "speed"]
    of = {(r["backend"], r["mesh"], r["n"]): float(r["value"]) / 1e6 for r in rows}
    meshes = list(dict.fromkeys((r["mesh"], r["triangles"]) for r in rows))
    batches = ["24", "240", "2400", "24000"]
    backends = ["cpu", "gl-compute"] + [f"gl-query 16 px, {way}" for way in ("soup", "indexed", "strips", "inherited")]
    cell = lambda value: "-" if value is None else f"{value:.2g}" if value < 10 else f"{value:.0f}"
    return table(["million octants per second, by octants in a batch: 24 / 240 / 2,400 / 24,000"] +
                 [f"{mesh}, {number(n)}" for mesh, n in meshes],
                 [[f"`{b}`"] + [" / ".join(cell(of.get((b, mesh, n))) for n in batches) for mesh, _ in meshes] for b in backends])


def octants_missed():
    rows = {(r["backend"], r["mesh"]): r for r in rows_of("octants") if r["part"] == "misses"}
    meshes = list(dict.fromkeys(mesh for _, mesh in rows))
    ways = ["cpu", "gl-compute"] + [f"gl-query {px} px, soup" for px in (8, 16, 32, 64)] + ["gl-query 16 px, inherited, inflated"]

    def cell(row):
        missed, extra = (f"{three(round(100 * int(row[k]) / int(row['n']), 2))} %" for k in ("value", "other"))
        return missed + ("" if extra == "0 %" else f", {extra} too many")
    return table([""] + meshes, [[f"`{way}`"] + [cell(rows[way, mesh]) for mesh in meshes] for way in ways])


def paper():
    rows = [r for r in rows_of("paper") if r["table"] == "2"]
    out = []
    for backend in dict.fromkeys(r["backend"] for r in rows):
        of = [r for r in rows if r["backend"] == backend]
        rates = [1000 * int(r["frames"]) / float(r["ms"]) for r in of]
        out.append([f"`{backend}`", three(sum(float(r["ms"]) for r in of) / 1000), f"{min(rates):,.0f} to {max(rates):,.0f}",
                    number(sum(int(r["queries"]) for r in of))])
    return table(["", "seconds", "frames per second, in twelfths of the animation", "queries"], out)


METHODS = ["CULLIDE", "CULLIDE, fattened", "viewing volumes", "gl-query, inherited", "gl-compute", "cpu"]


def comparators():
    scenes = {"paper": "`paper`", "many": "`many`", "hard": "`hard`",
              "needles": "[`needles.json`](data/gl_query/needles.json)"}
    rows = {(name, r["backend"]): r for name in scenes
            for r in rows_of("paper" if name == "paper" else f"comparators/{name}") if r["table"] == "3"}

    def cell(r):
        each = int(r["frames"])
        return f"{number(r['left_over'])}, {number(r['missed'])}; {number(round(int(r['queries']) / each))}; {three(float(r['ms']) / each)}"
    heads = [f"{title}, {number(rows[name, 'cpu']['frames'])} frames: {number(rows[name, 'cpu']['collisions'])} collisions of "
             f"{number(rows[name, 'cpu']['candidates'])} pairs" for name, title in scenes.items()]
    return table(["left over, missed; queries per frame; ms per frame"] + heads,
                 [[f"`{m}`"] + [cell(rows[name, m]) for name in scenes] for m in METHODS])


def gpu_runs():
    """The runs of `bench gpu`: parts by name, each with its rows."""
    for path in sorted((DOCS / "data/gpu").glob("*.json")):
        run = json.loads(path.read_text(encoding="utf-8"))
        yield path, run, {part["name"]: part["rows"] for part in run["parts"]}


def gpu():
    out = []
    for path, run, parts in gpu_runs():
        name = f"[{run['gpu']['renderer']}](data/gpu/{path.name})"
        equal = [r["equal"] for r in parts["correctness"]]
        out.append([name, "result hashes equal to the cpu's", f"{sum(equal)} of {len(equal)}", ""])
        most = max(r["rows"] for r in parts["octants"])
        for mesh in dict.fromkeys(r["what"] for r in parts["octants"]):
            of = {r["backend"]: r for r in parts["octants"] if r["what"] == mesh and r["rows"] == most}
            out.append([name, f"{mesh}, {number(most)} rows: million octants per second"] +
                       [three(of[b]["octants_per_s"] / 1e6) for b in ("gl-compute", "cpu")])
        for what in dict.fromkeys(r["what"] for r in parts["trees"]):
            of = {r["backend"]: r for r in parts["trees"] if r["what"] == what}
            out.append([name, f"whole tree, {what}: ms (by the GPU's clock)",
                        f"{three(of['gl-compute']['ms'])} ({three(of['gl-compute']['gpu_ms'])})", three(of["cpu"]["ms"])])
        for what in dict.fromkeys(r["what"] for r in parts["many"]):
            of = {r["backend"]: r for r in parts["many"] if r["what"] == what}
            for way, title in (("", ""), (", ahead", ", cells grow ahead")):
                out.append([name, f"`{what}`{title}: first frame, others, ms (rounds)"] +
                           [", ".join(f"{three(of[b + way][f'{k}_ms'])} ({three(of[b + way][f'{k}_rounds'])})" for k in ("first", "warm"))
                            for b in ("gl-compute", "cpu")])
    return table(["renderer", "", "gl-compute", "cpu"], out)


def planner():
    titles = {"fcl": "FCL, exact", "bound": "oncollide, within its error", "exact": "oncollide, exact"}
    out = []
    for r in rows_of("planner", "planner_meshes"):
        share = 100 * int(r["colliding"]) / int(r["poses"])
        out.append([f"{r['fixed']} of {number(r['fixed_triangles'])}, {r['moving']} of {number(r['moving_triangles'])} triangles",
                    f"{share:.0f} %", titles[r["who"]], r["threads"], f"{float(r['first_s']):.2f}",
                    number(int(float(r["poses"]) / float(r["second_s"]) / 1000) * 1000), f"{float(r['ratio']):.1f}"])
    return table(["meshes", "poses that collide", "query", "threads", "first call, s", "queries per second", "ratio"], out)


def continuous():
    titles = {"oncollide": "oncollide, `Pairs::sweep`", "fcl-advancement": "FCL, conservative advancement, linear motion",
              "fcl-sampled": "FCL, its default: ten poses of a translation"}
    rows = rows_of("continuous/continuous")
    ours = float(rows[0]["median_us"])
    return table(["", "median, microseconds", "ratio", "contacts found", "missed", "invented", "too early", "too late"],
                 [[titles[r["contender"]], three(r["median_us"]), f"{float(r['median_us']) / ours:,.1f}",
                   *(number(r[what]) for what in ("contacts", "missed", "invented", "early", "late"))] for r in rows])


def sweeps():
    r = next(r for r in rows_of("continuous/sweeps") if r["a"] == "all")
    return (f"{number(r['sweeps'])} sweeps: {number(r['contacts'])} with a contact on the way, {number(r['at_start'])} in contact at the start, "
            f"{number(r['clear'])} free, {number(r['open'])} not decided because of rounding or the limit of steps; {number(r['poses'])} poses, {number(r['truths'])} by the reference: {number(r['missed'])} "
            f"missed, {number(r['early'])} early, {number(r['wide'])} out of tolerance, {number(r['changed'])} changed by the order of the bodies")


def articulated():
    r = next(r for r in rows_of("continuous/articulated") if r["a"] == "articulated")
    return (f"{number(r['a_triangles'])} triangles past {number(r['b_triangles'])} of posts, {number(r['motions'])} steps: "
            f"{float(r['mean_us']) / 1000:.2f} ms per step on average, {number(r['contacts'])} contacts, {number(r['missed'])} contradicted")


def rays():
    titles = {"oncollide": "oncollide, one call each", "oncollide-batch": "oncollide, one call for all",
              "oncollide-cast": "oncollide, first point, one call each",
              "oncollide-cast-batch": "oncollide, first point, one call for all",
              "embree-closest": "Embree `rtcIntersect1`, robust, float, closest point",
              "embree-robust": "Embree `rtcOccluded1`, robust, float", "embree": "Embree, not robust, float",
              "bullet": "Bullet `rayTest`, float", "octomap": "OctoMap `castRay`"}
    rows = rows_of("rays")
    kinds = list(dict.fromkeys(r["rays"] for r in rows))
    of = {}
    for r in rows:
        of.setdefault((r["geometry"], r["parts"], r["contender"]), {})[r["rays"]] = r
    out = []
    for (geometry, parts, contender), by_kind in of.items():
        wrong = [sum(int(r[what]) for r in by_kind.values()) for what in ("missed", "invented")]
        out.append([f"{geometry}, {number(parts)}", titles[contender], *(three(by_kind[k]["us_per_ray"]) for k in kinds),
                    *map(number, wrong)])
    return table(["geometry, triangles or cells", "", *(f"{k}, microseconds" for k in kinds), "missed", "invented"], out)


def contacts():
    who = {"oncollide": "oncollide", "fcl": "FCL", "bullet": "Bullet", "ode": "ODE"}
    of = {}
    for r in rows_of("contacts/contacts"):
        of.setdefault(r["scene"], {})[r["who"]] = r
    cell = lambda r: f"{three(r['ms'])} ({float(r['contacts']):,.0f})" if r else "-"
    return table(["scene", *(f"{title}, ms (contacts)" for title in who.values())],
                 [[f"`{scene}`", *(cell(rows.get(name)) for name in who)] for scene, rows in of.items()])


def contacts_played():
    millimetres = lambda x: f"{1e3 * float(x):.2g}"
    out = []
    for r in rows_of("contacts/contacts"):
        if r["who"] != "oncollide" or float(r["step_ms"]) == 0:
            continue
        aside = millimetres(r["aside"]) if float(r["speed"]) else ""
        lead = f"{abs(1e3 * float(r['lead'])):.3f}" if float(r["lead"]) else ""
        out.append([f"`{r['scene']}`", three(r["step_ms"]), r["most_points"], "" if aside or lead else millimetres(r["creep"]),
                    millimetres(r["depth"]), aside, lead])
    return table(["scene", "step with the solver, ms", "points of a pair, at most", "creep, mm/s", "depth, mm", "speed aside, mm/s",
                  "mm a turn"], out)


def world():
    titles = {"none": "nothing changes", "move": "{} move", "exchange": "{} removed, {} added"}
    rows = rows_of("world")
    columns = list(dict.fromkeys((r["change"], r["count"]) for r in rows))
    settings = list(dict.fromkeys((r["refined_by"], r["exact"], r["skip"]) for r in rows))
    out = []
    for refined, exact, skip in settings:
        name = "`--skip refinement`: boxes alone" if skip else "exact" if exact != "off" else "`--exact off`: 1 % of the smaller body"
        of = {(r["change"], r["count"]): float(r["changes_ms"]) + float(r["step_ms"]) for r in rows
              if (r["refined_by"], r["exact"], r["skip"]) == (refined, exact, skip)}
        out.append([name] + ["below 0.001" if of[c] < 0.001 else f"{of[c]:,.0f}" for c in columns])
    return table([""] + [titles[c].format(number(n), number(n)) for c, n in columns], out)


def clash():
    out, before = [], None
    for r in rows_of("clash"):
        what = f"{number(r['parts'])} parts" + (" of scanned and drawn meshes" if r["meshes"] == "real" else "")
        what += f", {float(r['triangles']) / 1e6:.1f} million triangles, {r['planted']} planted pairs"
        files = f"{number(r['parts'])} STL files" if r["files"] == "STL files" else r["files"]
        out.append(["the same" if what == before else what, files, f"{float(r['read_s']):.1f}",
                    f"{float(r['find_s']):.1f}", f"{float(r['json_s']):.2f}", f"{float(r['all_s']):.1f}",
                    f"{float(r['page_s']):.1f}"])
        before = what
    return table(["assembly", "files", "reading", "finding", "JSON", "all", "the page, 40 pictures"], out)


def view():
    out = []
    for r in rows_of("view"):
        shown, frames = int(r["frames_on_page"]), int(r["frames"])
        out.append([f"`{r['scene']}`", number(r["bodies"]), f"{float(r['bytes']) / 1e6:.1f} MB",
                    f"{shown}" if shown == frames else f"{shown} (one in {frames // shown})",
                    f"{float(r['cpu_seconds_without_page']):.2f} s", f"{float(r['cpu_seconds']):.1f} s"])
    return table(["scene", "bodies", "page", "frames on it", "run without the page", "with it"], out)


def python():
    return table(["call", "items", "Python", "C++", "overhead"],
                 [[f"`{r['call']}`", number(r["items"]), r["python_ns"], r["cpp_ns"], r["overhead_ns"]]
                  for r in rows_of("python")])


ROBOT_MODELS = {"panda_vamp": "Panda, of VAMP", "panda_curobo": "Panda, of cuRobo", "ur5_vamp": "UR5, of VAMP",
                "panda_59": "Panda, `--count 59`", "ur5_40": "UR5, `--count 40`",
                "panda_20mm": "Panda, `--max-error 20mm`", "panda_5mm": "Panda, `--max-error 5mm`"}


def robot_models():
    out = []
    for name, title in ROBOT_MODELS.items():
        rows = rows_of(f"robots/{name}")
        area, least, most = (sum(float(r[c]) for r in rows) for c in ("area", "uncovered", "uncovered_most"))
        gaps = [float(r["gap"]) for r in rows if r["spheres"] != "0"]
        out.append([title, str(sum(int(r["spheres"]) for r in rows)),
                    "0" if most == 0 else f"{100 * least / area:.1f} to {100 * most / area:.1f}", f"{1000 * max(gaps):.1f}",
                    f"{1000 * max(float(r['over_reach']) for r in rows if r['spheres'] != '0'):.1f}"])
    return table(["model", "spheres", "surface in no sphere, %", "worst gap, mm", "over-reach, mm"], out)


def robot_checks():
    out = []
    for robot in ("panda", "ur5"):
        for r in rows_of(f"robots/bench_{robot}"):
            out.append([{"panda": "Panda", "ur5": "UR5"}[robot], r["who"], number(float(r["per_second"])),
                        number(float(r["self_per_second"])), number(r["missed"]), number(r["refused"]), r["self_missed"],
                        number(r["self_refused"])])
    return table(["robot", "checks by", "configurations per second", "self alone", "missed", "refused", "missed, self",
                  "refused, self"], out)


def robot_edges():
    out = []
    for robot, name in (("panda", "Panda"), ("ur5", "UR5")):
        for r in rows_of(f"robots/edges_{robot}"):
            out.append([name, number(r["edges"]), r["first_us"], r["any_us"], r["sampled_us"], r["free"], r["contacts"], r["undecided"],
                        r["missed"], r["refuted"]])
    return table(["robot", "motions", "first contact, us", "free or not, us", "sampled, us", "free", "contacts", "undecided",
                  "missed by samples", "certified, but in contact"], out)


def robot_plans():
    out = []
    for robot, name in (("panda", "Panda"), ("ur5", "UR5")):
        for r in rows_of(f"robots/plan_{robot}"):
            out.append([name, r["who"], f"{r['solved']} of {r['problems']}", r["refused"], r["mean_ms"], r["median_ms"], number(float(r["state_checks"])),
                        number(float(r["edge_checks"])), r["collide"], r["undecided"], r["refuted"]])
    return table(["robot", "checks by", "solved", "refused", "mean, ms", "median, ms", "states", "motions", "in contact", "undecided", "refuted"], out)


def mutants():
    code = lambda text: f"`{text}`" if text else "nothing"
    return table(["fault", "file", "code", "becomes", "tests that fail"],
                 [[r["fault"], f"`{r['file']}`", code(r["from"]).replace("|", "\\|"), code(r["to"]).replace("|", "\\|"),
                   f"{r['failed']}: " + ", ".join(f"`{name}`" for name in r["found_by"].split()) + (", ..." if int(r["failed"]) > 4 else "")]
                  for r in rows_of("mutants")])


DART_DETECTORS = {"fcl": "FCL", "bullet": "Bullet", "ode": "ODE", "oncollide": "oncollide"}


def dart(scene, first, *columns):
    """One row per variant and detector; `columns` are measures of docs/data/contacts/dart.csv."""
    of = {}
    for r in rows_of("contacts/dart"):
        if r["scene"] == scene:
            of.setdefault((r["variant"], r["detector"]), {})[r["measure"]] = float(r["value"])

    def shown(value):
        if value is None or value != value:
            return "-"
        return f"{value:,.0f}" if abs(value) >= 100 or value == int(value) else f"{value:.3g}"

    return table([first, "detector", *(c.replace(" mm", ", mm").replace(" ms", ", ms") for c in columns)],
                 [[variant, DART_DETECTORS[detector], *(shown(row.get(c)) for c in columns)] for (variant, detector), row in of.items()])


def dart_stack():
    return dart("stack", "boxes of 1 m", "creep mm/s", "depth told mm", "normals off degrees", "contacts of a pair, most",
                "step ms", "detection ms")


def dart_slide():
    return dart("slide", "ground", "sideways mm/s", "speed off", "tilt degrees", "contacts", "step ms", "detection ms")


def dart_enclosed():
    return dart("enclosed", "bodies", "seen %", "normal right %")


def dart_pile():
    return dart("pile", "pile", "detection ms", "step ms", "contacts", "lost bodies", "fastest at the end mm/s", "simulated s",
                "failures of the solver")


def dart_overlap():
    return dart("overlap", "bodies", "detection ms", "contacts")


def dart_nut():
    return dart("nut M16", "nut M16", "mm per turn", "turns", "tilt degrees", "depth told mm", "contacts", "detection ms", "step ms",
                "failures of the solver")


TABLES = {f.__name__: f for f in (headline, many, many_pairs, exact_cost, narrow, narrow_large, narrow_pairs, continuous, study, study_peers, octants, octants_missed, paper, comparators, gpu, planner, rays,
                                  contacts, contacts_played,
                                  world, broad, hard, spheres, sphere_levels, occlusion_losses, delimitation,
                                  environments, worlds, distances, shape_distances, shapes, reading, clash,
                                  python, view, robot_models, robot_checks, robot_edges, robot_plans, mutants,
                                  dart_stack, dart_slide, dart_enclosed, dart_pile, dart_overlap, dart_nut)}
# Ranges of ratios. many, environments: how many times as fast as FCL in Release, on tumbling meshes (1,000 and 10,000) and in large
# environments.
PHRASES = {
    "many_exact": lambda: many_totals("1k-exact", "10k-exact"),
    "many_bound": lambda: many_totals("1k", "10k"),
    "environments": environment_ratios,
    "halved_error": halved_error,
    "sweeps": sweeps,
    "articulated": articulated,
}
# On these pages every speed comes from the data.
HEADLINES = [DOCS.parent / "README.md", DOCS / "index.md", DOCS / "choosing.md"]
TYPED = re.compile(r"\b[\d.,]+ times\b|\b(?:half|third|quarter|fifth|sixth|seventh|eighth|tenth) (?:as|of (?:the|its|FCL's) time)\b")
PHRASE = re.compile(r"(<!-- figure: (\w+) -->)(.*?)(<!-- end -->)")
BLOCK = re.compile(r"(<!-- figures: (\w+) -->\n)(.*?)(<!-- end -->)", re.S)


def update(write):
    wrong, typed, seen = [], [], set()
    for page in [DOCS.parent / "README.md", *sorted(DOCS.glob("**/*.md"))]:
        text = page.read_text(encoding="utf-8")

        def block(match):
            name = match[2]
            if name not in TABLES:
                sys.exit(f"{page.name}: no figures '{name}'; there are: {', '.join(TABLES)}")
            seen.add(name)
            made = "\n" + TABLES[name]() + "\n"
            if match[3] != made:
                wrong.append(f"{page.name}: {name}")
            return match[1] + made + match[4]

        def phrase(match):
            name = match[2]
            if name not in PHRASES:
                sys.exit(f"{page.name}: no figure '{name}'; there are: {', '.join(PHRASES)}")
            made = PHRASES[name]()
            if match[3] != made:
                wrong.append(f"{page.name}: {name}")
            return match[1] + made + match[4]

        new = PHRASE.sub(phrase, BLOCK.sub(block, text))
        if page in HEADLINES:
            typed += [f"{page.name}: {match[0]}" for match in TYPED.finditer(PHRASE.sub("", text))]
        if write and new != text:
            page.write_text(new, encoding="utf-8")
    for name in TABLES.keys() - seen:
        sys.exit(f"no page shows the figures '{name}'")
    if typed:
        sys.exit("typed speeds; use <!-- figure: NAME -->: " + "; ".join(typed))
    if wrong and not write:
        sys.exit("not what docs/data says (docs/site/figures.py --write): " + "; ".join(wrong))


def plot_all(folder):
    import matplotlib
    matplotlib.use("svg")
    import matplotlib.pyplot as plt
    plt.rcParams.update({"svg.hashsalt": "oncollide", "font.size": 10, "axes.grid": True, "grid.alpha": 0.3,
                         "axes.spines.top": False, "axes.spines.right": False})
    colours = ["#0072b2", "#e69f00", "#009e73", "#d55e00", "#cc79a7", "#56b4e9", "#555555"]  # Okabe and Ito

    def save(figure, name):
        figure.tight_layout()
        figure.savefig(folder / f"{name}.svg", metadata={"Date": None})
        plt.close(figure)

    figure, axes = plt.subplots(figsize=(8, 3.8))
    rows = rows_of("environments")
    for k, bodies in enumerate(("meshes", "shapes")):
        values = [[float(r["ratio"]) for r in rows if (r["environment"], r["bodies"]) == (e, bodies)] for e in ENVIRONMENTS]
        at = [i + 0.36 * (k - 0.5) for i in range(len(values))]
        middle = [sorted(v)[len(v) // 2] for v in values]
        axes.bar(at, middle, 0.34, color=colours[k], label=bodies,
                 yerr=[[m - min(v) for m, v in zip(middle, values)], [max(v) - m for m, v in zip(middle, values)]])
    axes.axhline(1, color="#555555", linewidth=1)
    axes.set_xticks(range(len(ENVIRONMENTS)), ENVIRONMENTS)
    axes.set_ylabel("FCL's time over oncollide's")
    axes.set_title("500 bodies in large environments, errors from 1 m to exact (bars: from least to most)")
    axes.legend(frameon=False)
    save(figure, "environments")

    for name, rows, title in (("distances", rows_of("distances", "map_distances"), "Distances to large environments"),
                              ("shape_distances", rows_of("shape_distances"), "Distances of two shapes")):
        figure, axes = plt.subplots(figsize=(8, 4))
        lines = list(dict.fromkeys((r["environment"], r["bodies"]) for r in rows))
        environments = list(dict.fromkeys(e for e, _ in lines))
        for environment, bodies in lines:
            chosen = [r for r in rows if (r["environment"], r["bodies"]) == (environment, bodies)]
            axes.plot([float(r["percent"]) for r in chosen], [float(r["ratio"]) for r in chosen], marker="o", markersize=3,
                      color=colours[environments.index(environment) % len(colours)],
                      linestyle="-" if bodies != "shapes" else "--",
                      label=environment if bodies == "all-shapes" else f"{environment}, {bodies}")
        axes.set_xscale("log"), axes.set_yscale("log")
        axes.axhline(1, color="#555555", linewidth=1)
        axes.set_xlabel("distance, per cent of the diagonal"), axes.set_ylabel("FCL's time over oncollide's")
        axes.set_title(title)
        axes.legend(frameon=False, fontsize=8, loc="center left", bbox_to_anchor=(1, 0.5))
        save(figure, name)

    figure, panels = plt.subplots(1, len(STUDIES), figsize=(10, 3.6))
    for axes, (name, title) in zip(panels, STUDIES.items()):
        rows = {r["variant"]: r for r in rows_of(name)}
        errors = [50 / 2 ** k for k in range(7)]
        for k, volume in enumerate(("spheres", "OBBs")):
            axes.plot(errors, [1000 * float(rows[f"{volume}, depth {d}"]["ms_median"]) for d in range(2, 9)], marker="o",
                      markersize=3, color=colours[k], label=f"{volume}, within the error")
        for k, variant in enumerate(("OBBs, predicates", "FCL", "ODE", "Bullet")):
            axes.axhline(1000 * float(rows[variant]["ms_median"]), color=colours[k + 2], linestyle="--",
                         label="oncollide, exact" if k == 0 else f"{variant}, exact")
        axes.set_xscale("log"), axes.set_yscale("log")
        axes.set_xlabel("error, per cent of a body"), axes.set_title(title.split("`")[1].split()[0].strip("-"))
    panels[0].set_ylabel("microseconds a frame")
    panels[-1].legend(frameon=False, fontsize=8, loc="center left", bbox_to_anchor=(1, 0.5))
    save(figure, "study")

    figure, axes = plt.subplots(figsize=(8, 3.8))
    rows = [r for r in rows_of("broad", "broad_1m") if r["scene"] == "brown"]
    for k, contender in enumerate(dict.fromkeys(r["contender"] for r in rows)):
        of = [r for r in rows if r["contender"] == contender]
        axes.plot([int(r["boxes"]) for r in of], [1e6 * float(r["ms"]) / int(r["boxes"]) for r in of], marker="o", markersize=3,
                  color=colours[k % len(colours)], linestyle="-" if k < len(colours) else "--", label=contender)
    axes.set_xscale("log"), axes.set_yscale("log")
    axes.set_xlabel("boxes, all of which move"), axes.set_ylabel("nanoseconds a box"), axes.set_title("Broad phase: all pairs of a frame")
    axes.legend(frameon=False, fontsize=8, loc="center left", bbox_to_anchor=(1, 0.5))
    save(figure, "broad")

    runs = list(gpu_runs())
    figure, panels = plt.subplots(1, len(runs), figsize=(7 * len(runs), 3.8), squeeze=False)
    for axes, (path, run, parts) in zip(panels[0], runs):
        mesh = parts["octants"][-1]["what"]
        for k, backend in enumerate(dict.fromkeys(r["backend"] for r in parts["octants"])):
            of = [r for r in parts["octants"] if (r["what"], r["backend"]) == (mesh, backend)]
            axes.plot([r["rows"] for r in of], [r["octants_per_s"] for r in of], marker="o", markersize=3, color=colours[k], label=backend)
        axes.set_xscale("log"), axes.set_yscale("log")
        axes.set_xlabel("rows in a batch"), axes.set_ylabel("octants a second")
        axes.set_title(f"{mesh} on {run['gpu']['renderer']}", fontsize=9)
        axes.legend(frameon=False, fontsize=8)
    save(figure, "gpu")

    figure, axes = plt.subplots(figsize=(8, 3))
    rows = rows_of("reading")
    axes.barh([r["style"] for r in rows][::-1], [float(r["triangles_per_s"]) / 1e6 for r in rows][::-1], color=colours[0])
    axes.set_xlabel("million triangles a second"), axes.set_title("Reading mesh files of ten million triangles")
    save(figure, "reading")

    figure, axes = plt.subplots(figsize=(6, 4.6))
    rows = {(r["a"], r["b"]): float(r["fcl_ns"]) / float(r["oncollide_ns"]) for r in rows_of("shapes")}
    names = list(dict.fromkeys([a for a, _ in rows] + [b for _, b in rows]))
    matrix = [[rows.get((a, b), float("nan")) for b in names] for a in names]
    axes.grid(False)
    axes.imshow(matrix, cmap="cividis", vmin=0)
    for i, line in enumerate(matrix):
        for j, value in enumerate(line):
            if value == value:
                axes.text(j, i, f"{value:.1f}", ha="center", va="center", color="white" if value < 5 else "black", fontsize=8)
    axes.set_xticks(range(len(names)), names, rotation=45, ha="right"), axes.set_yticks(range(len(names)), names)
    axes.set_title("Close pairs of shapes: FCL's time over oncollide's")
    save(figure, "shapes")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--write", action="store_true")
    parser.add_argument("--check", action="store_true")
    parser.add_argument("--plots", type=pathlib.Path, metavar="FOLDER")
    options = parser.parse_args()
    if options.write or options.check:
        update(options.write)
    if options.plots:
        options.plots.mkdir(parents=True, exist_ok=True)
        plot_all(options.plots)


if __name__ == "__main__":
    main()
