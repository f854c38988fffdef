#pragma once
#include <oncollide/base/numbers/random.hpp>
#include <oncollide/samples/catalogue.hpp>
#include <oncollide/samples/sample_geometry.hpp>
#include <oncollide/scenes/scene_builder.hpp>

namespace oncollide {

// The functions that make the scenes of catalogue.cpp, which checks their options. Private to the samples.

void make_paper_scene(SceneBuilder& scene, const CatalogueOptions& options);
void make_paper_5k_scene(SceneBuilder& scene, const CatalogueOptions& options);
void make_many_scene(SceneBuilder& scene, const CatalogueOptions& options);
void make_boxes_scene(SceneBuilder& scene, const CatalogueOptions& options);
void make_city_scene(SceneBuilder& scene, const CatalogueOptions& options);
void make_octomap_scene(SceneBuilder& scene, const CatalogueOptions& options);
void make_hills_scene(SceneBuilder& scene, const CatalogueOptions& options);
void make_avalanche_scene(SceneBuilder& scene, const CatalogueOptions& options);
void make_flags_scene(SceneBuilder& scene, const CatalogueOptions& options);
void make_campus_scene(SceneBuilder& scene, const CatalogueOptions& options);
void make_st_helens_scene(SceneBuilder& scene, const CatalogueOptions& options);
void make_chunks_scene(SceneBuilder& scene, const CatalogueOptions& options);
void make_tiles_scene(SceneBuilder& scene, const CatalogueOptions& options);
void make_swarm_scene(SceneBuilder& scene, const CatalogueOptions& options);
void make_hard_scene(SceneBuilder& scene, const CatalogueOptions& options);
void make_random_scene(SceneBuilder& scene, const CatalogueOptions& options);

/// Uniformly random numbers of one body: next() uses k = 0, 1, ...
class Dice {
public:
    Dice(std::uint64_t seed, std::uint64_t index) : seed_(seed), index_(index) {}
    double next() { return u01(seed_, index_, k_++); }
    double between(double low, double high) { return low + (high - low) * next(); }
    /// Uniform in the box with corners +-half.
    Eigen::Vector3d within(const Eigen::Vector3d& half);
    Eigen::Vector3d direction();
    Eigen::Quaterniond rotation();

private:
    std::uint64_t seed_, index_, k_ = 0;
};

/// A pose from a position and, if it is not the identity, a rotation.
Eigen::Isometry3d placed(const Eigen::Vector3d& position,
                         const Eigen::Quaterniond& rotation = Eigen::Quaterniond::Identity());

/// Adds a tube along a trefoil knot, centred at the origin.
GeometryId add_knot(SceneBuilder& scene, const std::string& name, double diagonal, int triangles);
/// Adds "drone": add_knot() with 1,200 triangles and 3 m.
GeometryId add_drone(SceneBuilder& scene);

/// Adds a mesh of the data folder or, if it is missing, the generator's mesh with a warning; either is scaled to a
/// bounding-box diagonal of 2 m and centred.
GeometryId add_model(SceneBuilder& scene, const CatalogueOptions& options, const std::string& name,
                     const std::string& file, const Json& generator);

} // namespace oncollide
