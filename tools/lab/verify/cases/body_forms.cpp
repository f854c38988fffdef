#include "verify/cases/body_forms.hpp"

#include <algorithm>
#include <random>

#include <oncollide/narrowphase/fcl/exact_fcl.hpp>

namespace oncollide::tools {
namespace {

using Eigen::Isometry3d;
using Eigen::Vector3d;

BodyForm as_stored(const BodyCase& c)
{
    return {"as stored", c.a, c.b, std::vector<Isometry3d>(c.poses_b.size(), c.pose_a), c.poses_b};
}

BodyForm swapped(const BodyForm& form)
{
    return {"swapped", form.b, form.a, form.poses_b, form.poses_a};
}

/// Shuffles triangles. With `turn` also shuffles each triangle's vertices, which flips some triangles; otherwise flips
/// all.
Mesh reordered(Mesh mesh, std::mt19937_64& random, bool turn)
{
    std::vector<std::uint32_t> place(mesh.vertices.size());
    for (std::uint32_t v = 0; v < place.size(); ++v) place[v] = v;
    std::shuffle(place.begin(), place.end(), random);
    std::vector<Vector3d> vertices(place.size());
    for (std::uint32_t v = 0; v < place.size(); ++v) vertices[place[v]] = mesh.vertices[v];
    for (Triangle& t : mesh.triangles) {
        for (std::uint32_t& v : t) v = place[v];
        if (turn)
            std::shuffle(t.begin(), t.end(), random);
        else
            std::swap(t[0], t[random() % 2 + 1]);
    }
    std::shuffle(mesh.triangles.begin(), mesh.triangles.end(), random);
    return mesh_of(std::move(vertices), std::move(mesh.triangles));
}

BodyForm reordered(BodyForm form, FormFor whom)
{
    std::mt19937_64 random(1);
    const bool turn = whom == FormFor::surfaces;
    form.name = turn ? "reordered" : "reordered and inside out", form.exact = true, form.whom = whom;
    form.a = reordered(std::move(form.a), random, turn), form.b = reordered(std::move(form.b), random, turn);
    return form;
}

/// Pose of b in a's frame, computed as FCL and the library do, at any distance from the origin.
Isometry3d between(const Isometry3d& a, const Isometry3d& b)
{
    return at(a.linear().transpose() * (b.translation() - a.translation()), a.linear().transpose() * b.linear());
}

BodyForm moved_form(BodyForm form, const char* name, const Isometry3d& motion)
{
    form.name = name, form.exact = true;
    for (std::size_t k = 0; k < form.poses_b.size(); ++k) {
        Isometry3d &a = form.poses_a[k], &b = form.poses_b[k];
        const Isometry3d before = between(a, b);
        a = motion * a, b = motion * b;
        form.exact &= between(a, b).matrix() == before.matrix();
    }
    return form;
}

void find_truth(BodyForm& form)
{
    const TruthModel a(form.a), b(form.b);
    const bool with_fcl = fcl_available();
    const auto fcl_a = with_fcl ? make_fcl_model(form.a) : nullptr, fcl_b = with_fcl ? make_fcl_model(form.b) : nullptr;
    for (std::size_t k = 0; k < form.poses_b.size(); ++k) {
        const Isometry3d &at_a = form.poses_a[k], &at_b = form.poses_b[k];
        PairTruth& truth = form.truths.emplace_back(truth_of(a, at_a, b, at_b));
        if (with_fcl) truth.fcl_collide = fcl_collides(*fcl_a, Isometry3d::Identity(), *fcl_b, between(at_a, at_b));
    }
}

} // namespace

double size_of(const Mesh& a, const Mesh& b)
{
    return std::max(a.bounds.diagonal(), b.bounds.diagonal());
}

std::vector<BodyForm> forms_of(const BodyCase& c)
{
    const BodyForm plain = as_stored(c);
    Eigen::Matrix3d quarter; // x to y to z to x
    quarter << 0, 0, 1, 1, 0, 0, 0, 1, 0;
    const Vector3d by = std::exp2(std::ceil(std::log2(size_of(c.a, c.b) + 1e-300))) * Vector3d(3, -5, 2);
    std::vector<BodyForm> forms{plain,
                                swapped(plain),
                                reordered(plain, FormFor::surfaces),
                                reordered(plain, FormFor::solids),
                                moved_form(plain, "turned by axes", at({0, 0, 0}, quarter)),
                                moved_form(plain, "moved", at(by, turn_by(2, {3, 1, -2})))};
    forms.back().exact = false;
    for (BodyForm& form : forms) find_truth(form);
    return forms;
}

} // namespace oncollide::tools
