#!/usr/bin/env python3
"""Draws the plots of the site from docs/data (needs matplotlib).

    plots.py FOLDER
"""
import pathlib
import sys

import matplotlib

sys.dont_write_bytecode = True  # the sources stay clean
matplotlib.use("svg")

import matplotlib.pyplot as plt  # noqa: E402

from tables.common import distinct, pivot, rows_of  # noqa: E402
from tables.scenes import ENVIRONMENTS  # noqa: E402
from tables.spheres import STUDIES, gpu_runs, study_ms  # noqa: E402

COLOURS = ["#0072b2", "#e69f00", "#009e73", "#d55e00", "#cc79a7", "#56b4e9", "#555555"]  # Okabe and Ito
RATIO = "FCL's time over oncollide's"


def line(axes, x, y, k, **style):
    axes.plot(x, y, marker="o", markersize=3, color=COLOURS[k % len(COLOURS)], **style)


def label(axes, x, y, title, logarithmic=True, **title_style):
    if logarithmic:
        axes.set_xscale("log"), axes.set_yscale("log")
    axes.set_xlabel(x), axes.set_ylabel(y)
    axes.set_title(title, **title_style)


def legend_outside(axes):
    axes.legend(frameon=False, fontsize=8, loc="center left", bbox_to_anchor=(1, 0.5))


def environments():
    figure, axes = plt.subplots(figsize=(8, 3.8))
    rows = rows_of("environments")
    for k, bodies in enumerate(("meshes", "shapes")):
        values = [[float(r["ratio"]) for r in rows if (r["environment"], r["bodies"]) == (e, bodies)] for e in ENVIRONMENTS]
        at = [i + 0.36 * (k - 0.5) for i in range(len(values))]
        middle = [sorted(v)[len(v) // 2] for v in values]
        axes.bar(at, middle, 0.34, color=COLOURS[k], label=bodies,
                 yerr=[[m - min(v) for m, v in zip(middle, values)], [max(v) - m for m, v in zip(middle, values)]])
    axes.axhline(1, color="#555555", linewidth=1)
    axes.set_xticks(range(len(ENVIRONMENTS)), ENVIRONMENTS)
    axes.set_ylabel(RATIO)
    axes.set_title("500 bodies in large environments, errors from 1 m to exact (bars: from least to most)")
    axes.legend(frameon=False)
    return figure


def of_distances(rows, title):
    figure, axes = plt.subplots(figsize=(8, 4))
    environments = distinct(rows, "environment")
    for (environment, bodies), by in pivot(rows, lambda r: (r["environment"], r["bodies"]), "percent").items():
        line(axes, [float(p) for p in by], [float(r["ratio"]) for r in by.values()], environments.index(environment),
             linestyle="-" if bodies != "shapes" else "--",
             label=environment if bodies == "all-shapes" else f"{environment}, {bodies}")
    axes.axhline(1, color="#555555", linewidth=1)
    label(axes, "distance, per cent of the diagonal", RATIO, title)
    legend_outside(axes)
    return figure


def distances():
    return of_distances(rows_of("distances", "map_distances"), "Distances to large environments")


def shape_distances():
    return of_distances(rows_of("shape_distances"), "Distances of two shapes")


def study():
    figure, panels = plt.subplots(1, len(STUDIES), figsize=(10, 3.6))
    for axes, (name, title) in zip(panels, STUDIES.items()):
        ms = study_ms(name)
        for k, volume in enumerate(("spheres", "OBBs")):
            line(axes, [50 / 2 ** k for k in range(7)], [1000 * ms[f"{volume}, depth {d}"] for d in range(2, 9)], k,
                 label=f"{volume}, within the error")
        for k, variant in enumerate(("OBBs, predicates", "FCL", "ODE", "Bullet")):
            axes.axhline(1000 * ms[variant], color=COLOURS[k + 2], linestyle="--",
                         label="oncollide, exact" if k == 0 else f"{variant}, exact")
        label(axes, "error, per cent of a body", "", title.split("`")[1].split()[0].strip("-"))
    panels[0].set_ylabel("microseconds per frame")
    legend_outside(panels[-1])
    return figure


def broad():
    figure, axes = plt.subplots(figsize=(8, 3.8))
    rows = [r for r in rows_of("broad", "broad_1m") if r["scene"] == "brown"]
    for k, (contender, by) in enumerate(pivot(rows, "contender", "boxes").items()):
        line(axes, [int(n) for n in by], [1e6 * float(r["ms"]) / int(n) for n, r in by.items()], k,
             linestyle="-" if k < len(COLOURS) else "--", label=contender)
    label(axes, "boxes, all of which move", "nanoseconds per box", "Broad phase: all pairs of a frame")
    legend_outside(axes)
    return figure


def gpu():
    runs = list(gpu_runs())
    figure, panels = plt.subplots(1, len(runs), figsize=(7 * len(runs), 3.8), squeeze=False)
    for axes, (_, run, parts) in zip(panels[0], runs):
        mesh = parts["octants"][-1]["what"]
        of_mesh = [r for r in parts["octants"] if r["what"] == mesh]
        for k, (backend, by) in enumerate(pivot(of_mesh, "backend", "rows").items()):
            line(axes, list(by), [r["octants_per_s"] for r in by.values()], k, label=backend)
        label(axes, "rows in a batch", "octants per second", f"{mesh} on {run['gpu']['renderer']}", fontsize=9)
        axes.legend(frameon=False, fontsize=8)
    return figure


def reading():
    figure, axes = plt.subplots(figsize=(8, 3))
    rows = rows_of("reading")[::-1]
    axes.barh([r["style"] for r in rows], [float(r["triangles_per_s"]) / 1e6 for r in rows], color=COLOURS[0])
    label(axes, "million triangles per second", "", "Reading mesh files of ten million triangles", logarithmic=False)
    return figure


def shapes():
    figure, axes = plt.subplots(figsize=(6, 4.6))
    rows = {(r["a"], r["b"]): float(r["fcl_ns"]) / float(r["oncollide_ns"]) for r in rows_of("shapes")}
    names = list(dict.fromkeys([a for a, _ in rows] + [b for _, b in rows]))
    axes.grid(False)
    axes.imshow([[rows.get((a, b), float("nan")) for b in names] for a in names], cmap="cividis", vmin=0)
    for (a, b), value in rows.items():
        axes.text(names.index(b), names.index(a), f"{value:.1f}", ha="center", va="center",
                  color="white" if value < 5 else "black", fontsize=8)
    axes.set_xticks(range(len(names)), names, rotation=45, ha="right"), axes.set_yticks(range(len(names)), names)
    axes.set_title(f"Close pairs of shapes: {RATIO}")
    return figure


def contacts():
    figure, axes = plt.subplots(figsize=(8, 4.2))
    by = pivot(rows_of("contacts/shapes"), lambda r: (r["scene"], r["mode"]), "who")
    scenes, modes = distinct(rows_of("contacts/shapes"), "scene"), ("moving", "slow", "rest")
    for k, mode in enumerate(modes):
        ratio = [float(by[scene, mode]["bullet"]["ms"]) / float(by[scene, mode]["oncollide"]["ms"]) for scene in scenes]
        axes.barh([i + 0.27 * (k - 1) for i in range(len(scenes))], [r - 1 for r in ratio], 0.25, left=1, color=COLOURS[k],
                  label={"moving": "2 mm a step", "slow": "0.1 mm a step", "rest": "at rest"}[mode])
    axes.axvline(1, color="#555555", linewidth=1)
    axes.set_xscale("log")
    axes.set_yticks(range(len(scenes)), scenes)
    axes.invert_yaxis()
    axes.set_xlabel("Bullet's time over oncollide's"), axes.set_title("Contacts of shapes")
    axes.legend(frameon=False)
    return figure


def avalanche():
    figure, axes = plt.subplots(figsize=(8, 3.4))
    for k, (who, title) in enumerate({"oncollide": "oncollide", "bullet": "Bullet"}.items()):
        rows = [r for r in rows_of("contacts/avalanche") if r["who"].partition(",")[0] == who]
        line(axes, [float(r["s"]) for r in rows], [float(r["detection_ms"]) for r in rows], k, label=f"{title}: detection")
        line(axes, [float(r["s"]) for r in rows], [float(r["solver_ms"]) for r in rows], k, linestyle=":",
             label=f"{title}: solver")
    axes.set_yscale("log")
    label(axes, "simulated seconds", "ms per step", "An avalanche, from its start to its rest", logarithmic=False)
    legend_outside(axes)
    return figure


def main():
    folder = pathlib.Path(sys.argv[1])
    folder.mkdir(parents=True, exist_ok=True)
    plt.rcParams.update({"svg.hashsalt": "oncollide", "font.size": 10, "axes.grid": True, "grid.alpha": 0.3,
                         "axes.spines.top": False, "axes.spines.right": False})
    for plot in (environments, distances, shape_distances, study, broad, gpu, reading, shapes, contacts, avalanche):
        figure = plot()
        figure.tight_layout()
        figure.savefig(folder / f"{plot.__name__}.svg", metadata={"Date": None})
        plt.close(figure)


if __name__ == "__main__":
    main()
