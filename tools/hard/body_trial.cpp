#include "body_trial.hpp"

#include <algorithm>
#include <random>

#include <fmt/format.h>

#include <oncollide/pipeline/pipeline.hpp>
#include <oncollide/scenes/error.hpp>
#include <oncollide/scenes/mesh_generators.hpp>

#include "body_truth.hpp"
#include "fcl_pair.hpp"

namespace oncollide::tools {
namespace {

using Eigen::Isometry3d;
using Eigen::Vector3d;

/// A question in one of its forms, with its truth.
struct Asked {
    std::string form;
    Mesh a, b;
    std::vector<Isometry3d> poses_a, poses_b;
    std::vector<BodyTruth> truths{};
    std::vector<std::uint8_t> fcl{}; ///< FCL says that they collide
    bool exact = false;              ///< no coordinate was rounded: nothing may change
};

Asked as_stored(const BodyCase& c)
{
    return {"as stored", c.a, c.b, std::vector<Isometry3d>(c.poses_b.size(), c.pose_a), c.poses_b};
}

Asked swapped(const Asked& asked)
{
    return {"swapped", asked.b, asked.a, asked.poses_b, asked.poses_a};
}

Mesh reordered(Mesh mesh, std::mt19937_64& random)
{
    std::vector<std::uint32_t> place(mesh.vertices.size());
    for (std::uint32_t v = 0; v < place.size(); ++v) place[v] = v;
    std::shuffle(place.begin(), place.end(), random);
    std::vector<Vector3d> vertices(place.size());
    for (std::uint32_t v = 0; v < place.size(); ++v) vertices[place[v]] = mesh.vertices[v];
    for (Triangle& t : mesh.triangles) {
        for (std::uint32_t& v : t) v = place[v];
        std::shuffle(t.begin(), t.end(), random);
    }
    std::shuffle(mesh.triangles.begin(), mesh.triangles.end(), random);
    return mesh_of(std::move(vertices), std::move(mesh.triangles));
}

Asked reordered(Asked asked)
{
    std::mt19937_64 random(1);
    asked.form = "reordered", asked.exact = true;
    asked.a = reordered(std::move(asked.a), random), asked.b = reordered(std::move(asked.b), random);
    return asked;
}

/// Of b in a's frame, as FCL and the library compute it whatever the distance from the origin.
Isometry3d between(const Isometry3d& a, const Isometry3d& b)
{
    return at(a.linear().transpose() * (b.translation() - a.translation()), a.linear().transpose() * b.linear());
}

Asked moved(Asked asked, const char* form, const Isometry3d& motion)
{
    asked.form = form, asked.exact = true;
    for (std::size_t k = 0; k < asked.poses_b.size(); ++k) {
        Isometry3d &a = asked.poses_a[k], &b = asked.poses_b[k];
        const Isometry3d before = between(a, b);
        a = motion * a, b = motion * b;
        asked.exact &= between(a, b).matrix() == before.matrix();
    }
    return asked;
}

/// The case in all its forms, as it is first.
std::vector<Asked> forms_of(const BodyCase& c)
{
    std::vector<Asked> forms{as_stored(c)};
    const Asked& plain = forms.front();
    const double size = std::max(c.a.bounds.diagonal(), c.b.bounds.diagonal());
    Eigen::Matrix3d quarter; // x to y to z to x
    quarter << 0, 0, 1, 1, 0, 0, 0, 1, 0;
    const Vector3d by = std::exp2(std::ceil(std::log2(size + 1e-300))) * Vector3d(3, -5, 2);
    Asked turned = moved(plain, "turned by axes", at({0, 0, 0}, quarter)),
          round = moved(plain, "moved", at(by, turn_by(2, {3, 1, -2})));
    round.exact = false;
    Asked other = swapped(plain), shuffled = reordered(plain);
    forms.push_back(std::move(other)), forms.push_back(std::move(shuffled));
    forms.push_back(std::move(turned)), forms.push_back(std::move(round));
    return forms;
}

void find_truth(Asked& asked)
{
    const FclPair<fcl::OBBd> fcl(asked.a, asked.b);
    for (std::size_t k = 0; k < asked.poses_b.size(); ++k) {
        const Isometry3d &a = asked.poses_a[k], &b = asked.poses_b[k];
        asked.truths.push_back(truth_of(asked.a, a, asked.b, b));
        asked.fcl.push_back(fcl.collide(between(a, b)) > 0);
    }
}

Scene scene_of(const Asked& asked, bool among_others)
{
    Scene scene;
    const GeometryId a = scene.add("a", asked.a), b = scene.add("b", asked.b);
    scene.add_body({.name = "a", .geometry = a, .pose = asked.poses_a.front()});
    scene.add_body({.name = "b", .geometry = b, .pose = asked.poses_b.front()});
    if (!among_others) return scene;
    const double size = std::max(asked.truths.front().distance.size, 1e-9);
    const GeometryId other = scene.add("other", make_box_mesh(Vector3d::Constant(size)));
    for (int k = 0; k < 70; ++k)
        scene.add_body({.name = fmt::format("other {}", k),
                        .geometry = other,
                        .pose = at(asked.poses_a.front().translation() + size * Vector3d(40 + 5 * (k % 9), 5 * k, 0),
                                   Eigen::Matrix3d::Identity()),
                        .is_static = true});
    return scene;
}

struct Answer {
    Verdict verdict = Verdict::separate;
    double bound = 0;
};

std::vector<Answer> answers_of(const Asked& asked, const Variant& variant)
{
    Scene scene = scene_of(asked, variant.among_others);
    Pipeline pipeline(scene, variant.settings);
    std::vector<Answer> answers;
    for (std::size_t k = 0; k < asked.poses_b.size(); ++k) {
        scene.poses[0] = asked.poses_a[k], scene.poses[1] = asked.poses_b[k];
        Answer& answer = answers.emplace_back();
        for (const PairResult& pair : pipeline.step(scene).pairs)
            if (index(pair.a) == 0 && index(pair.b) == 1) answer = {pair.verdict, pair.bound};
    }
    return answers;
}

/// True when FCL, which may err, has the last word.
bool fcl_decides(const Settings& s)
{
    return s.exact == ExactLevel::fcl || (s.exact == ExactLevel::predicates && (s.node_budget || s.memory_budget));
}

/// One answer against the truth.
void judge(const Asked& asked, std::size_t k, const Variant& variant, Answer answer, Tally& tally,
           const std::string& what)
{
    const BodyTruth& truth = asked.truths[k];
    const Settings& settings = variant.settings;
    const bool decides = settings.exact != ExactLevel::off &&
                         std::find(settings.skip.begin(), settings.skip.end(), "exact") == settings.skip.end();
    const bool separate = answer.verdict == Verdict::separate, colliding = answer.verdict == Verdict::colliding;
    const bool expected = decides && fcl_decides(settings) ? asked.fcl[k] : truth.collide;
    ++tally.answers;
    if (separate && truth.collide && expected) tally.fault(&Tally::missed, what);
    if (colliding && (!decides || (!truth.collide && !expected))) tally.fault(&Tally::wrong, what + ": invented");
    if (decides && !separate && !colliding) tally.fault(&Tally::wrong, what + ": left open");
    tally.false_alarms += !separate && !colliding && !truth.collide;
    if (colliding) return;
    ++tally.bounds;
    const double rounding = 0x1p-50 * truth.distance.size;
    const bool holds = separate ? truth.collide || answer.bound <= truth.distance.high + rounding
                                : truth.distance.low <= answer.bound + rounding;
    if (!holds)
        tally.fault(&Tally::broken,
                    fmt::format("{}: {}, bound {:.9g} m, distance {:.9g} to {:.9g} m", what, name_of(answer.verdict),
                                answer.bound, truth.distance.low, truth.distance.high));
}

} // namespace

Tally try_bodies(const BodyCase& c, const std::vector<Variant>& variants)
{
    std::vector<Asked> forms = forms_of(c);
    for (Asked& asked : forms) find_truth(asked);
    const Asked& plain = forms.front();
    Tally tally{.family = c.family};
    for (std::size_t k = 0; k < plain.truths.size(); ++k) {
        const bool collide = plain.truths[k].collide;
        if (c.collide && collide != *c.collide)
            throw Error(ErrorKind::internal,
                        fmt::format("hard case '{}: {}', pose {}: meant to {}, but the exact oracle says no", c.family,
                                    c.name, k, *c.collide ? "collide" : "be apart"));
        ++tally.cases;
        tally.fcl_missed += collide && !plain.fcl[k], tally.fcl_false += !collide && plain.fcl[k];
    }
    for (const Variant& variant : variants) {
        std::vector<Answer> first;
        for (const Asked& asked : forms) {
            const std::vector<Answer> answers = answers_of(asked, variant);
            if (&asked == &plain) first = answers;
            for (std::size_t k = 0; k < answers.size(); ++k) {
                const std::string what =
                    fmt::format("{}: {}, pose {}, {}: {}", c.family, c.name, k, asked.form, variant.name);
                judge(asked, k, variant, answers[k], tally, what);
                if (fcl_decides(variant.settings) && asked.fcl[k] != plain.fcl[k]) continue; // FCL's own change of mind
                const bool must_hold = asked.exact || (plain.truths[k].deep && asked.truths[k].deep);
                if (must_hold && answers[k].verdict != first[k].verdict)
                    tally.fault(&Tally::changed, fmt::format("{}: {} became {}", what, name_of(first[k].verdict),
                                                             name_of(answers[k].verdict)));
            }
        }
    }
    return tally;
}

} // namespace oncollide::tools
