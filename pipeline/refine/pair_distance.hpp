#pragma once
#include <oncollide/pipeline/refine/contact_finding.hpp>
#include <oncollide/pipeline/refine/non_mesh_pairs.hpp>

namespace oncollide {

/// Distances of any two bodies, as World::distance(). One thread's working memory.
class PairDistance {
public:
    /// The trees of both models must exist.
    /// @param mode  whether the inside of a closed mesh belongs to the mesh
    Distance find(const PairTask& task, Mode mode, double tolerance, double farthest);

private:
    ContactFinding surfaces_;
    NonMeshPairs solids_;
    PointLocator locator_;
};

} // namespace oncollide
