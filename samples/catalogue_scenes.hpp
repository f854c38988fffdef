#pragma once
#include <oncollide/base/random.hpp>
#include <oncollide/samples/catalogue.hpp>
#include <oncollide/samples/sample_geometry.hpp>

namespace oncollide {

// The functions that make the scenes of catalogue.cpp, which checks their options. Private to the samples.

Scene make_paper_scene(const CatalogueOptions& options);
Scene make_paper_5k_scene(const CatalogueOptions& options);
Scene make_many_scene(const CatalogueOptions& options);
Scene make_boxes_scene(const CatalogueOptions& options);
Scene make_city_scene(const CatalogueOptions& options);
Scene make_octomap_scene(const CatalogueOptions& options);
Scene make_hills_scene(const CatalogueOptions& options);
Scene make_campus_scene(const CatalogueOptions& options);
Scene make_st_helens_scene(const CatalogueOptions& options);
Scene make_chunks_scene(const CatalogueOptions& options);
Scene make_tiles_scene(const CatalogueOptions& options);
Scene make_swarm_scene(const CatalogueOptions& options);
Scene make_hard_scene(const CatalogueOptions& options);
Scene make_random_scene(const CatalogueOptions& options);

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
GeometryId add_knot(Scene& scene, const std::string& name, double diagonal, int triangles);
/// Adds "drone": add_knot() with 1,200 triangles and 3 m.
GeometryId add_drone(Scene& scene);

/// Adds a mesh of the data folder or, if it is missing, the generator's mesh with a warning; either is scaled to a
/// bounding-box diagonal of 2 m and centred.
GeometryId add_model(Scene& scene, const CatalogueOptions& options, const std::string& name, const std::string& file,
                     const Json& generator);

} // namespace oncollide
