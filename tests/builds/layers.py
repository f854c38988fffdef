"""Reads the includes of all sources, and fails where a module includes one that is not below it (BELOW), where a folder
includes a folder that LAYERS does not permit, or where the includes of folders form a circle.

layers.py PROJECT
"""

import pathlib
import re
import sys

MODULES = ["base", "scenes", "samples", "broadphase", "narrowphase", "pipeline", "robots", "runs"]
# Both are include folders of each other's files; the first one, which users install, must not include the second.
TOOLS = ["tools/command", "tools/lab"]

# The modules that each module may include. scenes/ holds three: geometry, scenes and files.
BELOW = {
    "base": [],
    "geometry": ["base"],
    "broadphase": ["geometry", "base"],
    "narrowphase": ["broadphase", "geometry", "base"],
    "pipeline": ["narrowphase", "broadphase", "geometry", "base"],
    "scenes": ["geometry", "base"],
    "files": ["scenes", "geometry", "base"],
}
GEOMETRY = re.compile(r"scenes/(model/|cooked/|geometry\.|rigid_motion\.)")

# The folders that each folder may include, within its top folder. Folders that are not listed may include any folder, as
# long as that makes no circle.
LAYERS = {
    "base": [],
    "broadphase": [],
    "broadphase/bounds": [""],
    "broadphase/tree": [""],
    "narrowphase/exact/kernels": [],
    "narrowphase/exact": ["exact/kernels"],
    "narrowphase/fcl": [],
    "narrowphase/shapes": ["exact"],
    "narrowphase/obb/fits": ["exact"],
    "narrowphase/obb": ["exact", "shapes", "obb/fits"],
    "narrowphase/walks": ["exact", "exact/kernels", "shapes", "obb"],
    "narrowphase/spheres": [],
    "narrowphase/gl": ["spheres"],
    "narrowphase/gl/walk": ["exact", "obb", "gl"],
    "narrowphase/hulls": ["exact", "shapes"],
    "narrowphase/inside": ["exact", "obb", "walks"],
    "narrowphase": ["exact", "shapes", "obb", "spheres", "hulls", "inside", "rays/tree", "fcl"],
    "narrowphase/pairs": ["", "exact", "shapes", "obb", "walks", "spheres", "inside"],
    "narrowphase/pairs/depth": ["shapes", "pairs"],
    "narrowphase/pairs/manifolds": ["", "exact", "shapes", "obb", "walks", "inside", "rays", "pairs",
                                    "pairs/depth", "pairs/manifolds/points", "pairs/manifolds/shapes"],
    "narrowphase/pairs/manifolds/shapes": ["", "exact", "shapes", "pairs", "pairs/manifolds/points"],
    "narrowphase/pairs/manifolds/points": ["", "exact", "shapes", "pairs"],
    "narrowphase/self": ["", "exact", "exact/kernels", "walks", "pairs/manifolds", "pairs/manifolds/points"],
    "narrowphase/rays/tree": ["obb"],
    "narrowphase/rays": ["", "exact", "shapes", "obb", "inside", "rays/tree"],
    "pipeline": [],
    "pipeline/models": [""],
    "pipeline/refine": ["", "models"],
    "robots": [],
    "robots/edges": [""],
    "robots/files": [""],
    "robots/spheres": [""],
    "runs": [],
    "runs/ranks": [""],
    "scenes/model": [],
    "scenes/model/map": ["model"],
    "scenes/model/terrain": ["model"],
    "scenes/cooked": ["model", "model/map", "model/terrain"],
}


def module_of(path):
    if GEOMETRY.match(path):
        return "geometry"
    return "files" if path.startswith("scenes/files/") else path.split("/")[0]


def includes(project):
    """{(folder, included folder): the first such include}, within top folders and within tools/, and the includes that BELOW
    forbids."""
    found, upward = {}, []
    for module in MODULES + TOOLS:
        roots = TOOLS if module in TOOLS else [module]
        for source in sorted((project / module).rglob("*.[ch]pp")):
            folder = source.parent.relative_to(project).as_posix()
            for name in re.findall(r'^ *#include [<"](?:oncollide/)?([\w/]+\.hpp)[>"]', source.read_text(), re.MULTILINE):
                candidates = [name, *(f"{root}/{name}" for root in roots), f"{folder}/{name}"]
                path = next((c for c in candidates if (project / c).is_file()), None)
                line = f"{source.relative_to(project)} includes {name}"
                own = module_of(source.relative_to(project).as_posix())
                if path and (other := module_of(path)) != own and other not in BELOW.get(own, [other]):
                    upward.append(f"{line}: {own} may not see {other}")
                within = path and any(path.startswith(f"{root}/") for root in roots)
                if within and (to := path.rpartition("/")[0]) != folder:
                    found.setdefault((folder, to), line)
    return found, upward


def circle(arrows):
    """The folders of a circle, in order; None if there is none."""
    below = {}
    for a, b in arrows:
        below.setdefault(a, []).append(b)
    done, path = set(), []

    def visit(folder):
        if folder in path:
            return path[path.index(folder):] + [folder]
        if folder in done:
            return None
        path.append(folder)
        for to in below.get(folder, []):
            if found := visit(to):
                return found
        path.pop()
        done.add(folder)
        return None

    return next((found for folder in sorted(below) if (found := visit(folder))), None)


def main():
    found, faults = includes(pathlib.Path(sys.argv[1]))
    faults += [f"{line}: not permitted by LAYERS" for (folder, to), line in found.items()
               if folder in LAYERS and to not in {f"{folder.split('/')[0]}/{name}".rstrip("/") for name in LAYERS[folder]}]
    faults += [f"{line}: the command must not include the laboratory" for (folder, to), line in found.items()
               if folder.startswith(TOOLS[0]) and to.startswith(TOOLS[1])]
    if round_trip := circle(set(found)):
        faults.append("a circle: " + " -> ".join(round_trip))
        faults += [found[arrow] for arrow in zip(round_trip, round_trip[1:])]
    if len(found) < 40:
        faults.append(f"only {len(found)} arrows between folders were found: are the includes read?")
    sys.exit("\n".join(faults) or 0)


if __name__ == "__main__":
    main()
