#pragma once
#include <string>
#include <vector>

#include "hard/body_case.hpp"
#include "hard/body_truth.hpp"
#include "hard/solid_truth.hpp"

namespace oncollide::tools {

/// What is true of two bodies, and what FCL says of them.
struct PairTruth {
    BodyTruth surfaces;
    SolidTruth solids;
    bool fcl_collide = false;
};

/// Whom a form is for: all, those for whom meshes are surfaces alone, or those for whom insides count.
enum class FormFor { all, surfaces, solids };

/// A case in one of its forms, with its truth.
struct BodyForm {
    std::string name;
    Mesh a, b;
    std::vector<Eigen::Isometry3d> poses_a, poses_b;
    std::vector<PairTruth> truths{}; ///< by pose
    bool exact = false;              ///< no coordinate was rounded: nothing may change
    FormFor whom = FormFor::all;
};

/// As stored, first; with the bodies swapped; with triangles, corners and vertices in another order, where insides
/// count so that they are kept, if inside out; after a motion of both that is exact; and after one that is rounded.
std::vector<BodyForm> forms_of(const BodyCase& c);

/// The larger one's diagonal.
double size_of(const Mesh& a, const Mesh& b);

} // namespace oncollide::tools
