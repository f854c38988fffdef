#include <oncollide/pipeline/containment_test.hpp>

#include <algorithm>
#include <tuple>

#include <oncollide/base/parallel.hpp>
#include <oncollide/pipeline/exact_stages.hpp>

namespace oncollide {

namespace {

bool surfaces_apart(const PairResult& result, std::uint8_t stage)
{
    return result.stage == stage &&
           (result.verdict == Verdict::separate || (result.verdict == Verdict::within && stage == exact_stage_index));
}

const Mesh& mesh_of(const Scene& scene, std::uint32_t body)
{
    return std::get<Mesh>(scene.geometries[index(scene.geometry[body])].data);
}

/// Around all that can be inside a mesh, in its frame, for points that were moved there in double.
Aabb box_around(const Mesh& mesh, const RelativePose& into)
{
    Aabb box = mesh.bounds;
    const double far =
        std::max({box.min.cwiseAbs().maxCoeff(), box.max.cwiseAbs().maxCoeff(), into.translation.stableNorm()});
    const double slack = 0x1p-16 * (box.max - box.min).maxCoeff() + 0x1p-40 * far;
    box.min.array() -= slack, box.max.array() += slack;
    return box;
}

/// May a part with these points be inside?
bool may_hold(const Aabb& box, const PartPoints& part, const RelativePose& into)
{
    return std::all_of(part.begin(), part.end(), [&](const Eigen::Vector3d& p) {
        const Eigen::Vector3d point = into(p);
        return (point.array() >= box.min.array()).all() && (point.array() <= box.max.array()).all();
    });
}

bool may_hold(const Scene& scene, const Solids& solids, std::uint32_t outer, std::uint32_t inner)
{
    if (!solids.solid(scene.geometry[outer])) return false;
    const RelativePose into(scene.poses[outer], scene.poses[inner]);
    const Aabb box = box_around(mesh_of(scene, outer), into);
    return std::ranges::any_of(solids.parts(scene.geometry[inner]),
                               [&](const PartPoints& part) { return may_hold(box, part, into); });
}

} // namespace

std::uint64_t ContainmentTest::find(const Scene& scene, Frame& frame, std::uint8_t stage)
{
    if (!forest_.solids()) return 0;
    ask(scene, frame, stage);
    locators_.resize(static_cast<std::size_t>(std::max(frame.threads, 1)));
    parallel_chunks(questions_.size(), 4, frame.threads, [&](std::size_t begin, std::size_t end, int thread) {
        for (std::size_t i = begin; i < end; ++i)
            questions_[i].yes = holds(scene, questions_[i], locators_[static_cast<std::size_t>(thread)]);
    });
    std::uint64_t were_separate = 0;
    for (const Question& question : questions_) {
        if (!question.yes) continue;
        PairResult& result = frame.results[question.result];
        were_separate += result.verdict == Verdict::separate;
        result.verdict = Verdict::colliding, result.kind = ContactKind::enclosed, result.bound = 0;
    }
    return were_separate;
}

void ContainmentTest::ask(const Scene& scene, const Frame& frame, std::uint8_t stage)
{
    const Solids& solids = *forest_.solids();
    sides_.assign(frame.results.size(), 0);
    parallel_chunks(sides_.size(), 256, frame.threads, [&](std::size_t begin, std::size_t end, int) {
        for (std::size_t i = begin; i < end; ++i) {
            const PairResult& result = frame.results[i];
            if (!surfaces_apart(result, stage)) continue;
            const std::uint32_t a = index(result.a), b = index(result.b);
            sides_[i] = std::uint8_t(may_hold(scene, solids, a, b) | may_hold(scene, solids, b, a) << 1);
        }
    });
    questions_.clear();
    for (std::uint32_t i = 0; i < sides_.size(); ++i) {
        const std::uint32_t a = index(frame.results[i].a), b = index(frame.results[i].b);
        for (const auto& [side, outer, inner] : {std::tuple(1, a, b), std::tuple(2, b, a)}) {
            if (!(sides_[i] & side)) continue;
            const GeometryId geometry = scene.geometry[outer];
            const bool room = forest_.admit_triangles(geometry, frame.number);
            questions_.push_back({i, outer, inner, room ? &forest_.obb_trees()[geometry] : nullptr, false});
        }
    }
}

bool ContainmentTest::holds(const Scene& scene, const Question& question, PointLocator& locator) const
{
    // The coordinates of the exact level: those of the body with the larger number moved into the other's frame.
    const std::uint32_t outer = question.outer, inner = question.inner;
    const Eigen::Isometry3d here = Eigen::Isometry3d::Identity();
    const std::uint32_t a = std::min(outer, inner), b = std::max(outer, inner);
    const RelativePose b_to_a(scene.poses[a], scene.poses[b]), stay(here, here);
    const RelativePose into_outer(scene.poses[outer], scene.poses[inner]);
    const Mesh& mesh = mesh_of(scene, outer);
    const Aabb box = box_around(mesh, into_outer);
    return std::ranges::any_of(forest_.solids()->parts(scene.geometry[inner]), [&](const PartPoints& part) {
        if (!may_hold(box, part, into_outer)) return false;
        const bool outer_is_a = outer == a;
        return locator.place(outer_is_a ? b_to_a(part[0]) : part[0], mesh, question.tree, outer_is_a ? stay : b_to_a) !=
               PointPlace::outside;
    });
}

} // namespace oncollide
