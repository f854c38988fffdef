"""Tables of the pages, and figures within sentences, from docs/data, which the benchmarks wrote."""
from . import phases, products, scenes, spheres

TABLES = {f.__name__: f for f in (
    phases.headline, scenes.many, scenes.many_pairs, scenes.exact_cost, scenes.worlds, scenes.world, scenes.environments,
    scenes.distances, scenes.shape_distances, scenes.self_contacts, scenes.deform, scenes.dig, scenes.shapes, phases.broad, phases.broad_ratios, phases.delimitation,
    phases.narrow_pairs, phases.planner, spheres.study, spheres.study_peers, spheres.occlusion_losses, spheres.spheres,
    spheres.sphere_levels, spheres.octants, spheres.octants_missed, spheres.paper, spheres.comparators, spheres.gpu, spheres.gpu_walks, spheres.gpu_host,
    spheres.continuous, products.rays, products.contacts, products.contacts_played,
    products.contacts_of_shapes, products.contacts_of_pairs, products.avalanche, products.reading, products.clash, products.league, products.view, products.python, products.web, products.web_native, products.robot_models, products.robot_checks, products.robot_distances, products.robot_edges, products.robot_plans)}
TABLES |= {name: lambda name=name: phases.medians(name) for name in ("narrow", "narrow_large")}
TABLES |= {f"dart_{scene}": lambda scene=scene: products.dart(scene, *products.DART[scene]) for scene in products.DART}

# many, environments: how many times as fast as FCL in Release, on tumbling meshes (1,000 and 10,000) and in large environments.
FIGURES = {
    "many_exact": lambda: scenes.many_ratios("1k-exact", "10k-exact"),
    "many_bound": lambda: scenes.many_ratios("1k", "10k"),
    "environments": scenes.environment_ratios,
    "halved_error": spheres.halved_error,
    "sweeps": spheres.sweeps,
    "articulated": spheres.articulated,
}
