#pragma once
#include "cli/arguments.hpp"

// The benchmarks. Each runs oncollide and other libraries on the same workload in one program, in alternation, and
// reports ratios. Each function adds one command to 'oncollide-lab bench'.
namespace oncollide::tools {

void add_broad(Arguments bench);
void add_narrow(Arguments bench);
void add_poses(Arguments bench);
void add_planner(Arguments bench);
void add_continuous(Arguments bench);
void add_self(Arguments bench);
void add_deform_bench(Arguments bench);
void add_dig(Arguments bench);
void add_shapes(Arguments bench);
void add_rays(Arguments bench);
void add_edges_bench(Arguments bench);
void add_contacts(Arguments bench);
void add_avalanche(Arguments bench);
void add_robot_bench(Arguments bench);
void add_robot_distances_bench(Arguments bench);
void add_world(Arguments bench);
void add_environment(Arguments bench);
void add_distances(Arguments bench);
void add_clash_bench(Arguments bench);
void add_read(Arguments bench);
void add_gpu(Arguments bench);
void add_scale(Arguments bench);
/// One scene of the catalogue by its name, as a benchmark of its own.
void add_scene_bench(Arguments bench, const char* name, const char* summary);
/// Any scene.
void add_any_scene_bench(Arguments bench);

} // namespace oncollide::tools
