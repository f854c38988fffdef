"""Segments, contacts for a solver, files, clash reports, pages, Python, JavaScript, robots and DART."""
import json

from .common import DOCS, listed, number, of, pivot, rows_of, table, three


def rays():
    titles = {"oncollide": "oncollide, one call each", "oncollide-batch": "oncollide, one call for all",
              "oncollide-cast": "oncollide, first point, one call each",
              "oncollide-cast-batch": "oncollide, first point, one call for all",
              "embree-closest": "Embree `rtcIntersect1`, robust, float, closest point",
              "embree-robust": "Embree `rtcOccluded1`, robust, float", "embree": "Embree, not robust, float",
              "bullet": "Bullet `rayTest`, float", "octomap": "OctoMap `castRay`"}
    by = pivot(rows_of("rays"), lambda r: (r["geometry"], r["parts"], r["contender"]), "rays")
    kinds = list(next(iter(by.values())))
    return table(["geometry, triangles or cells", "query", *(f"{k}, microseconds" for k in kinds), "missed", "invented"],
                 [[f"{geometry}, {number(parts)}", titles[contender], *(three(of_kind[k]["us_per_ray"]) for k in kinds),
                   *(number(sum(int(r[what]) for r in of_kind.values())) for what in ("missed", "invented"))]
                  for (geometry, parts, contender), of_kind in by.items()])


def contacts():
    who = {"oncollide": "oncollide", "fcl": "FCL", "bullet": "Bullet", "ode": "ODE"}
    cell = lambda r: f"{three(r['ms'])} ({float(r['contacts']):,.0f})" if r else "-"
    return table(["scene", *(f"{title}, ms (contacts)" for title in who.values())],
                 [[f"`{scene}`", *(cell(by.get(name)) for name in who)]
                  for scene, by in pivot(rows_of("contacts/contacts"), "scene", "who").items()])


def contacts_played():
    millimetres = lambda column: of(column, ".2g", 1e3)
    slides, screws = (lambda r: float(r["speed"])), (lambda r: float(r["lead"]))
    return listed([r for r in rows_of("contacts/contacts") if r["who"] == "oncollide" and float(r["step_ms"])], {
        "scene": of("scene", "`{}`".format),
        "step with the solver, ms": of("step_ms", three),
        "points of a pair, at most": of("most_points", str),
        "creep, mm/s": lambda r: "" if slides(r) or screws(r) else millimetres("creep")(r),
        "depth, mm": millimetres("depth"),
        "speed aside, mm/s": lambda r: millimetres("aside")(r) if slides(r) else "",
        "mm a turn": lambda r: f"{abs(1e3 * float(r['lead'])):.3f}" if screws(r) else "",
    })


def contacts_of_shapes():
    two = pivot(rows_of("contacts/shapes_two_threads"), lambda r: (r["scene"], r["mode"]), "who")
    ms = lambda r: three(r["ms"]) if r else "-"
    counts = lambda by: " / ".join(f"{float(by[who]['contacts']):,.0f}" for who in ("oncollide", "bullet", "ode"))
    return table(["scene", "mode", "oncollide, ms", "`step()` + manifolds", "on two threads", "Bullet", "ODE", "FCL",
                  "contacts: oncollide / Bullet / ODE"],
                 [[f"`{scene}`", mode, ms(by["oncollide"]),
                   f"{three(by['oncollide']['pairs_ms'])} + {three(by['oncollide']['manifolds_ms'])}",
                   ms(two.get((scene, mode), {}).get("oncollide")), *(ms(by.get(who)) for who in ("bullet", "ode", "fcl")),
                   counts(by)]
                  for (scene, mode), by in pivot(rows_of("contacts/shapes"), lambda r: (r["scene"], r["mode"]), "who").items()])


def contacts_of_pairs():
    who = {"oncollide": "oncollide", "bullet": "Bullet", "ode": "ODE", "fcl": "FCL"}
    cell = lambda r: f"{three(1e3 * float(r['ms']))} ({float(r['contacts']):.2g})" if r else "-"
    return table(["pair", *(f"{title}, us (points)" for title in who.values())],
                 [[scene.removeprefix("pair-").replace("-", ", "), *(cell(by.get(name)) for name in who)]
                  for scene, by in pivot(rows_of("contacts/pairs"), "scene", "who").items()])


def avalanche():
    titles = {"oncollide": "manifolds and the reference solver", "bullet": "Bullet"}
    made = []
    for bodies, name in ("1,050", "avalanche"), ("10,500", "avalanche_full"):
        rows = rows_of(f"contacts/{name}")
        for who, title in titles.items():
            seconds = [r for r in rows if r["who"] == who]
            if not seconds:
                continue
            rest = next((r for r in rows if r["who"] == f"{who}, at rest"), None)
            values = lambda column: [float(r[column]) for r in seconds]
            mean = lambda part: three(sum(part) / len(part))
            ms = lambda column: f"{mean(values(column)[1:4])} ({mean(values(column))})"
            made.append([bodies, title, ms("detection_ms"), ms("solver_ms"),
                         f"{float(rest['s']):.0f} s" if rest else f"not in {float(seconds[-1]['s']):.0f} s",
                         three(rest["detection_ms"]) if rest else "-", f"{max(values('lost')):.0f}"])
    return table(["bodies", "moved by", "detection, ms a step in seconds 2 to 4, when all move (of all seconds)", "solver",
                  "all at rest after", "detection then, ms", "bodies below the hill"], made)


def reading():
    styles = {
        "obj": "OBJ, six decimals, `f a b c`",
        "obj-full": "OBJ, `vt`, `vn`, `f a/b/c`, comments, CR LF",
        "obj-back": "OBJ, negative numbers of vertices",
        "obj-exact": "OBJ, every digit of a double",
        "stl": "STL, binary, welded",
        "stl-mixed": "STL, binary, welded, triangles in no order",
        "ply": "PLY, binary, floats",
    }
    return listed(rows_of("reading"), {
        "file": lambda r: styles[r["style"]], "MB": of("bytes", ",.0f", 1e-6),
        "triangles per second": lambda r: f"{float(r['triangles_per_s']) / 1e6:.1f} million",
        "peak MB": of("peak_bytes", ",.0f", 1e-6),
    })


def clash():
    def assembly(r):
        meshes = " of scanned and drawn meshes" if r["meshes"] == "real" else ""
        return (f"{number(r['parts'])} parts{meshes}, {float(r['triangles']) / 1e6:.1f} million triangles, "
                f"{r['planted']} planted pairs")
    rows = rows_of("clash")
    repeated = [k > 0 and assembly(rows[k - 1]) == assembly(r) for k, r in enumerate(rows)]
    return listed([dict(r, name="the same" if again else assembly(r)) for r, again in zip(rows, repeated)], {
        "assembly": of("name", str),
        "files": lambda r: f"{number(r['parts'])} STL files" if r["files"] == "STL files" else r["files"],
        "reading": of("read_s", ".1f"), "finding": of("find_s", ".1f"), "JSON": of("json_s", ".2f"), "all": of("all_s", ".1f"),
        "the page, 40 pictures": of("page_s", ".1f"),
    })


def league():
    libraries = {}
    for r in rows_of("league"):
        sums = libraries.setdefault(r["library"], dict.fromkeys(("answers", "right", "missed", "invented", "inexact", "extra", "none", "ns"), 0.0))
        count = {name: int(value) for name, value in r.items() if name not in ("family", "question", "library", "ns")}
        answers = count["cases"] - count["unsupported"] - count["failed"] - count["crashed"] - count["hung"]
        for name, value in (("answers", answers), ("right", count["right"]), ("missed", count["missed"] + count["late"]),
                            ("invented", count["invented"] + count["early"]), ("ns", float(r["ns"]) * answers),
                            ("inexact", count["distance"] + count["depth"] + count["normal"] + count["points"] + count["support"]),
                            ("extra", count["extra"]),
                            ("none", count["failed"] + count["crashed"] + count["hung"])):
            sums[name] += value
    rows = [dict(sums, library=name) for name, sums in libraries.items() if name != "example"]
    return listed(rows, {
        "library": of("library", "`{}`".format), "answers": of("answers"),
        "right": lambda r: f"{100 * r['right'] / (r['answers'] + r['none']):.4g} %", "missed": of("missed"), "invented": of("invented"),
        "inexact": of("inexact"), "extra": of("extra"), "no answer": of("none"), "microseconds": lambda r: three(1e-3 * r["ns"] / r["answers"]),
    })


def view():
    def frames(r):
        shown, played = int(r["frames_on_page"]), int(r["frames"])
        return f"{shown}" if shown == played else f"{shown} (one in {played // shown})"
    return listed(rows_of("view"), {
        "scene": of("scene", "`{}`".format), "bodies": of("bodies"), "page": lambda r: f"{float(r['bytes']) / 1e6:.1f} MB",
        "frames on it": frames, "run without the page": lambda r: f"{float(r['cpu_seconds_without_page']):.2f} s",
        "with it": lambda r: f"{float(r['cpu_seconds']):.1f} s",
    })


def python():
    return listed(rows_of("python"), {"call": of("call", "`{}`".format), "items": of("items"), "Python": of("python_ns", str),
                                      "C++": of("cpp_ns", str), "overhead": of("overhead_ns", str)})


def measured_in_node():
    return json.loads((DOCS / "data/web/node.json").read_text(encoding="utf-8"))


def web():
    """The npm package and three-mesh-bvh."""
    return listed(measured_in_node()["pairs"], {
        "triangles of each mesh": of("triangles"), "yes or no, us": of("ours_us", three),
        "`intersectsGeometry`, us": of("bvh_us", three), "distance, us": of("ours_distance_us", three),
        "`closestPointToGeometry`, ms": of("bvh_distance_us", three, 1e-3)})


def web_native():
    """The module, and the native library with its baseline kernels."""
    found = measured_in_node()
    rows = []
    for title, ours, native in (("yes or no", "batch_us", "native_us"), ("distance", "batch_distance_us", "native_distance_us")):
        rows += [(f"{title}, {number(r['triangles'])} triangles each", r[ours], r[native], "us") for r in found["pairs"]]
    rows += [(f"a frame of {number(r['bodies'])} moving bodies", r["median_ms"], r["native_ms"], "ms") for r in found["crowds"]]
    return table(["", "WebAssembly", "native, baseline", "ratio"],
                 [[title, f"{three(ours)} {unit}", f"{three(native)} {unit}", f"{ours / native:.2f}"] for title, ours, native, unit in rows])


def robot_models():
    models = {"panda_vamp": "Panda, of VAMP", "panda_curobo": "Panda, of cuRobo", "ur5_vamp": "UR5, of VAMP",
              "panda_59": "Panda, `--count 59`", "ur5_40": "UR5, `--count 40`",
              "panda_20mm": "Panda, `--max-error 20mm`", "panda_5mm": "Panda, `--max-error 5mm`"}

    def uncovered(rows):
        area, least, most = (sum(float(r[c]) for r in rows) for c in ("area", "uncovered", "uncovered_most"))
        return "0" if most == 0 else f"{100 * least / area:.1f} to {100 * most / area:.1f}"
    worst = lambda column: lambda rows: f"{1000 * max(float(r[column]) for r in rows if r['spheres'] != '0'):.1f}"
    columns = {"spheres": lambda rows: str(sum(int(r["spheres"]) for r in rows)), "surface in no sphere, %": uncovered,
               "worst gap, mm": worst("gap"), "over-reach, mm": worst("over_reach")}
    return table(["model", *columns],
                 [[title, *(cell(rows_of(f"robots/{name}")) for cell in columns.values())] for name, title in models.items()])


def of_robots(measured, columns):
    """A table over the rows of robots/MEASURED_ROBOT.csv."""
    rows = [dict(r, robot=title) for robot, title in (("panda", "Panda"), ("ur5", "UR5"))
            for r in rows_of(f"robots/{measured}_{robot}")]
    return listed(rows, {"robot": of("robot", str), **columns})


def robot_checks():
    return of_robots("bench", {
        "checks by": of("who", str), "configurations per second": of("per_second"), "self alone": of("self_per_second"),
        "missed": of("missed"), "refused": of("refused"), "missed, self": of("self_missed", str),
        "refused, self": of("self_refused"),
    })


def robot_distances():
    return of_robots("distances", {
        "measured by": of("who", str), "us per configuration": of("us", three), "of the first row": of("of_oncollide", ".2f"),
        "pairs": of("pairs"), "configurations": of("configurations"), "in contact": of("meeting"),
        "in contact by one alone": of("differ", str),
    })


def robot_edges():
    return of_robots("edges", {
        "motions": of("edges"), "first contact, us": of("first_us", str), "free or not, us": of("any_us", str),
        "sampled, us": of("sampled_us", str), "free": of("free", str), "contacts": of("contacts", str),
        "undecided": of("undecided", str), "missed by samples": of("missed", str),
        "certified, but in contact": of("refuted", str),
    })


def robot_plans():
    return of_robots("plan", {
        "checks by": of("who", str), "solved": lambda r: f"{r['solved']} of {r['problems']}", "refused": of("refused", str),
        "mean, ms": of("mean_ms", str), "median, ms": of("median_ms", str), "states": of("state_checks"),
        "motions": of("edge_checks"),
        "in contact": of("collide", str), "undecided": of("undecided", str), "refuted": of("refuted", str),
    })


def dart(scene, first, *columns):
    """A table with one row per variant and detector; `columns` are measures of docs/data/contacts/dart.csv."""
    detectors = {"fcl": "FCL", "bullet": "Bullet", "ode": "ODE", "oncollide": "oncollide"}

    def shown(r):
        value = float(r["value"]) if r else float("nan")
        if value != value:
            return "-"
        return f"{value:,.0f}" if abs(value) >= 100 or value == int(value) else f"{value:.3g}"
    rows = [r for r in rows_of("contacts/dart") if r["scene"].partition(" ")[0] == scene]
    return table([first, "detector", *(c.replace(" mm", ", mm").replace(" ms", ", ms") for c in columns)],
                 [[variant, detectors[detector], *(shown(by.get(c)) for c in columns)]
                  for (variant, detector), by in pivot(rows, lambda r: (r["variant"], r["detector"]), "measure").items()])


DART = {
    "stack": ("boxes of 1 m", "creep mm/s", "depth told mm", "normals off degrees", "contacts of a pair, most", "step ms",
              "detection ms"),
    "slide": ("ground", "sideways mm/s", "speed off", "tilt degrees", "contacts", "step ms", "detection ms"),
    "enclosed": ("bodies", "seen %", "normal right %"),
    "pile": ("pile", "detection ms", "step ms", "contacts", "lost bodies", "fastest at the end mm/s", "simulated s",
             "failures of the solver"),
    "overlap": ("bodies", "detection ms", "contacts"),
    "nut": ("nut M16", "mm per turn", "turns", "tilt degrees", "depth told mm", "contacts", "detection ms", "step ms",
            "failures of the solver"),
}
