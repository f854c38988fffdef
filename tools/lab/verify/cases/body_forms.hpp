#pragma once
#include <string>
#include <vector>

#include "truth/truth.hpp"
#include "verify/cases/body_case.hpp"

namespace oncollide::tools {

/// The settings that a form applies to: all settings, settings with meshes as surfaces, or settings with insides.
enum class FormFor { all, surfaces, solids };

/// A case in one of its forms, with the truth.
struct BodyForm {
    std::string name;
    Mesh a, b;
    std::vector<Eigen::Isometry3d> poses_a, poses_b;
    std::vector<PairTruth> truths{}; ///< by pose
    bool exact = false;              ///< no coordinate was rounded, so no result may change
    FormFor whom = FormFor::all;
};

/// First as stored; with the bodies swapped; with triangles, vertices and their order shuffled, where insides count so
/// that they are kept or all inside out; after an exact motion of both bodies; and after a rounded one.
std::vector<BodyForm> forms_of(const BodyCase& c);

/// Diagonal of the larger body.
double size_of(const Mesh& a, const Mesh& b);

} // namespace oncollide::tools
