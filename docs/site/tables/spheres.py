"""Speed against error, sphere-trees, cells on a GPU, the paper, hard cases, contacts on the way."""
import json
import statistics

from .common import DOCS, distinct, listed, number, of, pivot, rows_of, span, table, three

STUDIES = {"study/paper": "`paper --every 8`, four bodies of 1,500 triangles", "study/many": "`many --frames 6`, 1,000 bodies",
           "study/poses": "`--poses --every 3 --age 1000000`, bunny and cow"}


def study_ms(name):
    return {r["variant"]: float(r["ms_median"]) for r in rows_of(name)}


def study():
    out = []
    for name, title in STUDIES.items():
        ms = study_ms(name)
        for volume in ("spheres", "OBBs"):
            variants = [f"{volume}, depth {d}" for d in range(2, 9)] + [f"{volume}, predicates"]
            out.append([f"{title}; {volume}"] + [f"{ms['FCL'] / ms[v]:.2g}" for v in variants])
    return table(["", "50 %", "25 %", "12.5 %", "6.3 %", "3.1 %", "1.6 %", "0.8 %", "exact"], out)


def study_peers():
    names = {"oncollide, exact": "OBBs, predicates", "FCL": "FCL", "ODE": "ODE", "Bullet": "Bullet"}
    return listed([dict({r["variant"]: r for r in rows_of(name)}, title=title) for name, title in STUDIES.items()], {
        "microseconds, median": of("title", str),
        **{title: lambda by, v=v: three(1000 * float(by[v]["ms_median"])) for title, v in names.items()},
        "Bullet: missed, invented": lambda by: f"{number(by['Bullet']['missed'])}, {number(by['Bullet']['invented'])}",
    })


def halved_error():
    """Returns the middle half of the ratios of times when the error of spheres is halved, from 50 % to 0.8 % of a body."""
    ratios = [ms[f"spheres, depth {d + 1}"] / ms[f"spheres, depth {d}"] for ms in map(study_ms, STUDIES) for d in range(2, 8)]
    lower, _, upper = statistics.quantiles(ratios)
    return span([lower, upper])


def occlusion_losses():
    titles = {"paper": "`paper --every 4`", "poses": "`--poses --every 4`, bunny and cow", "hard": "`hard --frames 3`",
              "needles": "[`needles.json`](data/gl_query/needles.json): a knot that passes needles of 1 : 100,000 "
                         "and tiny triangles"}
    rows = [dict({r["variant"].removesuffix(", spheres, depth 6"): r for r in rows_of(f"gl_query/{name}")}, title=title)
            for name, title in titles.items()]
    return listed(rows, {
        "": of("title", str),
        "collisions": lambda by: number(by["spheres, depth 6"]["truly_colliding"]),
        "`cpu`, `gl-compute`": lambda by: number(int(by["spheres, depth 6"]["missed"]) + int(by["gl-compute"]["missed"])),
        **{f"{px} px": lambda by, px=px: number(by[f"gl-query {px} px"]["missed"]) for px in (8, 16, 64)},
    })


def levels_of(mesh):
    """Rows of `spheres --levels` by kind and level."""
    return pivot(rows_of(f"spheres/{mesh}"), "kind", lambda r: int(r["level"]))


def over_reach(r):
    """Worst and mean over-reach, in thousandths of the longest side."""
    return ", ".join(f"{1000 * float(r[f'{what}_outside']) / float(r['longest_side']):.1f}" for what in ("worst", "mean"))


def spheres():
    out = []
    for mesh in ("paper/bunny", "paper/cow", "paper/dragon", "paper/lamp", "paper/cow_5144", "spot", "armadillo_86k"):
        by = levels_of(mesh.removeprefix("paper/"))
        fine, boxes = by["sphere"][5], by["box"]
        out.append([f"`{mesh}.obj`", number(fine["triangles"]), number(fine["count"]), over_reach(fine),
                    f"{float(fine['volume']):.3f}",
                    *(f"{number(boxes[level]['count'])}: {over_reach(boxes[level])}" for level in (3, 4)),
                    f"{float(boxes[4]['volume']):.3f}", f"{int(boxes[4]['tree_bytes']) / int(fine['triangles']):.0f}"])
    out.append(["published: octree, depth 5", "", "about 4,100", "mean 19 to 26", "", "", "", "", ""])
    out.append(["published: adaptive medial axis", "", "484",
                "mean 5 to 7, with 2.0 to 2.6 % of the surface uncovered"] + 5 * [""])
    return table(["mesh", "triangles", "spheres of level 5", "worst, mean", "volume", "boxes of level 3: number, worst, mean",
                  "boxes of level 4: number, worst, mean", "volume", "bytes per triangle, all boxes"], out)


def sphere_levels():
    by = levels_of("cow_5144")
    cells = lambda level: [form(by[kind][level]) for kind in ("sphere", "box") for form in (of("count"), over_reach)]
    return table(["level", "spheres", "worst, mean", "boxes", "worst, mean"], [[str(level), *cells(level)] for level in range(6)])


def octants():
    rows = rows_of("gpu/octants")
    per_second = {(r["backend"], r["what"], r["rows"]): float(r["octants_per_s"]) / 1e6 for r in rows}
    meshes = dict.fromkeys((r["what"], r["triangles"]) for r in rows)
    backends = ["cpu", "gl-compute"] + [f"gl-query 16 px, {way}" for way in ("soup", "indexed", "strips", "inherited")]
    cell = lambda value: "-" if value is None else f"{value:.2g}" if value < 10 else f"{value:.0f}"
    return table(["batches of 24 / 240 / 2,400 / 24,000"] +
                 [f"{mesh}, {number(n)}" for mesh, n in meshes],
                 [[f"`{b}`"] + [" / ".join(cell(per_second.get((b, mesh, n))) for n in ("24", "240", "2400", "24000"))
                                for mesh, _ in meshes] for b in backends])


def octants_missed():
    by = pivot(rows_of("gpu/misses"), "backend", "what")
    ways = ["cpu", "gl-compute"] + [f"gl-query {px} px, soup" for px in (8, 16, 32, 64)] + ["gl-query 16 px, inherited, inflated"]

    def cell(r):
        missed, extra = (f"{three(round(100 * int(r[k]) / int(r['octants']), 2))} %" for k in ("missed", "extra"))
        return missed + ("" if extra == "0 %" else f", {extra} too many")
    return table(["", *by["cpu"]], [[f"`{way}`"] + [cell(by[way][mesh]) for mesh in by["cpu"]] for way in ways])


def paper():
    by = pivot(rows_of("gpu/timeline"), "backend", "to_frame")
    rates = lambda b: [1000 * int(r["frames"]) / float(r["ms"]) for r in by[b].values()]
    return listed(by, {
        "": lambda b: f"`{b}`",
        "seconds": lambda b: three(sum(float(r["ms"]) for r in by[b].values()) / 1000),
        "frames per second, in twelfths of the animation": lambda b: f"{min(rates(b)):,.0f} to {max(rates(b)):,.0f}",
        "queries": lambda b: number(sum(int(r["queries"]) for r in by[b].values())),
    })


def comparators():
    scenes = {"paper": "`paper`", "many": "`many`", "hard": "`hard`", "needles": "[`needles.json`](data/gl_query/needles.json)"}
    methods = ["CULLIDE", "CULLIDE, fattened", "viewing volumes", "gl-query, inherited", "gl-compute", "cpu"]
    by = {name: {r["backend"]: r for r in rows_of(f"comparators/{name}")} for name in scenes}

    def title(name):
        r = by[name]["cpu"]
        return (f"{scenes[name]}, {number(r['frames'])} frames: {number(r['collisions'])} collisions of "
                f"{number(r['candidates'])} pairs")

    def cell(r):
        queries, seconds = (float(r[k]) / int(r["frames"]) for k in ("queries", "seconds"))
        return f"{number(r['left_over'])}, {number(r['missed'])}; {number(round(queries))}; {three(1000 * seconds)}"
    return table(["left over, missed; queries per frame; ms per frame", *map(title, scenes)],
                 [[f"`{m}`"] + [cell(by[name][m]) for name in scenes] for m in methods])


def gpu_runs():
    """The runs of `bench gpu`: parts by name, each with its rows."""
    for path in sorted((DOCS / "data/gpu").glob("*.json")):
        run = json.loads(path.read_text(encoding="utf-8"))
        yield path, run, {part["name"]: part["rows"] for part in run["parts"]}


def gpu():
    out = []
    for path, run, parts in gpu_runs():
        lines = []
        equal = [r["equal"] for r in parts["correctness"]]
        lines.append(["result hashes equal to the cpu's", f"{sum(equal)} of {len(equal)}", ""])
        most = max(r["rows"] for r in parts["octants"])
        for mesh, by in pivot([r for r in parts["octants"] if r["rows"] == most], "what", "backend").items():
            lines.append([f"{mesh}, {number(most)} rows: million octants per second",
                          *(three(by[b]["octants_per_s"] / 1e6) for b in ("gl-compute", "cpu"))])
        for what, by in pivot(parts["trees"], "what", "backend").items():
            lines.append([f"whole tree, {what}: ms (by the GPU's clock)",
                          f"{three(by['gl-compute']['ms'])} ({three(by['gl-compute']['gpu_ms'])})", three(by["cpu"]["ms"])])
        for what, by in pivot(parts["many"], "what", "backend").items():
            cell = lambda r: ", ".join(f"{three(r[f'{k}_ms'])} ({three(r[f'{k}_rounds'])})" for k in ("first", "warm"))
            for way, title in (("", ""), (", ahead", ", cells grow ahead")):
                lines.append([f"`{what}`{title}: first frame, others, ms (rounds)",
                              *(cell(by[b + way]) for b in ("gl-compute", "cpu"))])
        out += [[f"[{run['gpu']['renderer']}](data/gpu/{path.name})", *line] for line in lines]
    return table(["renderer", "", "gl-compute", "cpu"], out)


def gpu_walks():
    """Counts per frame of the backend gl, and of the CPU."""
    out = []
    for what, by in pivot([r for r in rows_of("gpu/walks") if float(r["pairs"])], "what", "backend").items():
        gl, cpu, all_gl, all_cpu = (by[b] for b in ("gl, 1 thread", "cpu, 1 thread", "gl, 1 thread, every pair walked",
                                                    "cpu, 1 thread, every pair walked"))
        both = lambda a, b, column: f"{number(a[column])}; {number(b[column])}"
        out.append([f"`{what}`".replace(", ", "`, ", 1)[:-1] if ", " in what else f"`{what}`", number(gl["gpu_pairs"]),
                    number(gl["bytes_up"]), number(gl["tree_bytes_up"]), number(gl["bytes_down"]), number(gl["dispatches"]),
                    both(gl, cpu, "box_rows"), both(all_gl, all_cpu, "box_rows"), both(gl, cpu, "triangle_pairs"),
                    number(gl["gpu_unsure_pairs"])])
    return table(["scene", "pairs on the GPU", "bytes up", "of trees", "bytes down", "dispatches", "box tests, gl and cpu",
                  "walked", "triangle tests, gl and cpu", "not certain"], out)


def gpu_host():
    """The CPU's time for a pair of a batch (ns), by stage."""
    gl = lambda name, what: next(r for r in rows_of(name) if r["what"].startswith(what) and r["backend"] == "gl, 1 thread")
    frame, poses = gl("gpu/walks", "many, 10,000"), gl("gpu/poses", "")
    ns = lambda r, stage: number(round(1e6 * float(r[f"host_{stage}_ms"]) / float(r["gpu_pairs"])))
    stages = {"tasks": ("reads and checks columns of poses", "all"), "sort": ("finds the pairs that need a walk", "all"),
              "trees": ("looks up the trees, divides the pairs", "one"), "fill": ("writes the pairs", "all"),
              "take": ("takes the results", "all")}
    out = [[f"`{stage}`", words, threads, ns(frame, stage), ns(poses, stage)] for stage, (words, threads) in stages.items()]
    out.append(["sum", "", "", *(number(round(float(r["host_ns_per_pair"]))) for r in (frame, poses))])
    return table(["column", "the CPU", "threads", f"a frame, {number(frame['gpu_pairs'])} pairs",
                  f"{number(poses['poses'])} poses"], out)


def continuous():
    titles = {"oncollide": "oncollide, `Pairs::sweep`", "fcl-advancement": "FCL, conservative advancement, linear motion",
              "fcl-sampled": "FCL, its default: ten poses of a translation"}
    rows = rows_of("continuous/continuous")
    counts = {"contacts found": "contacts", "missed": "missed", "invented": "invented", "too early": "early", "too late": "late"}
    return listed(rows, {
        "": lambda r: titles[r["contender"]],
        "median, microseconds": of("median_us", three),
        "ratio": lambda r: f"{float(r['median_us']) / float(rows[0]['median_us']):,.1f}",
        **{title: of(column) for title, column in counts.items()},
    })


def sweeps():
    r = next(r for r in rows_of("continuous/sweeps") if r["a"] == "all")
    n = {column: number(value) for column, value in r.items() if value.isdigit()}
    return (f"{n['sweeps']} sweeps: {n['contacts']} with a contact on the way, {n['at_start']} in contact at the start, "
            f"{n['clear']} free, {n['open']} not decided because of rounding or the limit of steps; {n['poses']} poses, "
            f"{n['truths']} by the reference: {n['missed']} missed, {n['early']} early, {n['wide']} out of tolerance, "
            f"{n['changed']} changed by the order of the bodies")


def articulated():
    r = next(r for r in rows_of("continuous/articulated") if r["a"] == "articulated")
    return (f"{number(r['a_triangles'])} triangles past {number(r['b_triangles'])} of posts, {number(r['motions'])} steps: "
            f"{float(r['mean_us']) / 1000:.2f} ms per step on average, {number(r['contacts'])} contacts, "
            f"{number(r['missed'])} contradicted")
