#include "verify/trials/hard_trials.hpp"

#include <fmt/format.h>

#include <oncollide/base/error.hpp>
#include <oncollide/pipeline/settings_rules.hpp>
#include <oncollide/runs/pipeline.hpp>
#include <oncollide/samples/generators.hpp>

#include "truth/judge.hpp"
#include "verify/cases/body_forms.hpp"

namespace oncollide::tools {
namespace {

using Eigen::Vector3d;

Scene scene_of(const BodyForm& form, bool among_others)
{
    Scene scene;
    const GeometryId a = scene.add("a", form.a), b = scene.add("b", form.b);
    scene.add_body({.name = "a", .geometry = a, .pose = form.poses_a.front()});
    scene.add_body({.name = "b", .geometry = b, .pose = form.poses_b.front()});
    if (!among_others) return scene;
    const double size = std::max(form.truths.front().distance.size, 1e-9);
    const GeometryId other = scene.add("other", make_box_mesh(Vector3d::Constant(size)));
    for (int k = 0; k < 70; ++k)
        scene.add_body({.name = fmt::format("other {}", k),
                        .geometry = other,
                        .pose = at(form.poses_a.front().translation() + size * Vector3d(40 + 5 * (k % 9), 5 * k, 0),
                                   Eigen::Matrix3d::Identity()),
                        .is_static = true});
    return scene;
}

std::vector<Finding> results_of(const BodyForm& form, const Settings& settings, bool among_others)
{
    Scene scene = scene_of(form, among_others);
    Pipeline pipeline(scene, settings);
    std::vector<Finding> results;
    for (std::size_t k = 0; k < form.poses_b.size(); ++k) {
        scene.set_pose(SceneBodyId{0}, form.poses_a[k]), scene.set_pose(SceneBodyId{1}, form.poses_b[k]);
        Finding& result = results.emplace_back(unlisted(settings));
        for (const PairResult& pair : pipeline.step(scene).pairs)
            if (index(pair.a) == 0 && index(pair.b) == 1) result = pair;
    }
    return results;
}

/// Throws if the oracles contradict the purpose of the case.
void check_truth(const BodyCase& c, const BodyForm& plain)
{
    const auto check = [&](std::size_t k, const char* how, bool said, std::optional<bool> meant) {
        if (meant && *meant != said)
            throw Error(
                ErrorKind::internal,
                fmt::format("hard case '{}: {}', pose {}: as {} expected to {}, but the exact oracle contradicts",
                            c.family, c.name, k, how, *meant ? "collide" : "be apart"));
    };
    for (std::size_t k = 0; k < plain.truths.size(); ++k) {
        const PairTruth& truth = plain.truths[k];
        check(k, "surfaces", truth.collide, c.collide);
        check(k, "solids", truth.collide || truth.enclosed, c.solids_collide);
    }
}

/// The variant's settings for this case, which has `closed` closed meshes; empty if the variant does not apply.
std::optional<Settings> settings_for(const Variant& variant, const BodyForm& plain, int closed)
{
    if (variant.closed_alone && closed == 0) return std::nullopt;
    Settings settings = variant.settings;
    settings.open_as_surface = settings.mode == Mode::solid && closed < 2;
    if (variant.of_size == 0 && variant.of_distance == 0) return settings;
    double distance = 0;
    for (const PairTruth& truth : plain.truths)
        if (distance == 0 && !truth.collide) distance = truth.distance.high;
    settings.clearance = variant.of_size * size_of(plain.a, plain.b) + variant.of_distance * distance;
    return settings.clearance > 0 ? std::optional(settings) : std::nullopt;
}

void must_be_refused(const BodyCase& c, const BodyForm& form, const Settings& as_surfaces, Tally& tally)
{
    Settings settings = as_surfaces;
    settings.open_as_surface = false;
    ++tally.results;
    try {
        const Scene scene = scene_of(form, false);
        Pipeline pipeline(scene, settings);
        tally.fault(&Tally::wrong,
                    fmt::format("{}: {}: a mesh that is not closed is accepted as a solid", c.family, c.name));
    } catch (const Error& error) {
        if (error.kind() != ErrorKind::bad_data) throw;
    }
}

bool is_for(const BodyForm& form, const Settings& settings)
{
    const bool insides = settings.mode == Mode::solid || wants_kinds(settings);
    return form.whom == FormFor::all || (form.whom == FormFor::solids) == insides;
}

/// True if a budget explains that one of two results is undecided: the bodies grow their trees in their order.
bool out_of_room(const Settings& settings, const Finding& now, const Finding& before)
{
    return (settings.node_budget || settings.memory_budget) &&
           (now.verdict == Verdict::undecided || before.verdict == Verdict::undecided);
}

/// True if the result must equal the result of the case as stored.
bool must_hold(const BodyForm& form, const BodyForm& plain, std::size_t k, const Settings& settings)
{
    const PairTruth &now = form.truths[k], &before = plain.truths[k];
    if (settings.ignore_touching && (now.vague || before.vague)) return false;
    if (fcl_decides(settings)) { // FCL's result may change, and if it misses a contact no point is inside or outside
        const bool no_side = settings.mode == Mode::solid && now.fcl_collide != now.collide;
        if (now.fcl_collide != before.fcl_collide || no_side) return false;
    }
    return form.exact || (before.deep && now.deep);
}

} // namespace

Tally try_bodies(const BodyCase& c, const std::vector<Variant>& variants)
{
    const std::vector<BodyForm> forms = forms_of(c);
    const BodyForm& plain = forms.front();
    check_truth(c, plain);
    Tally tally{.family = c.family};
    tally.cases = plain.truths.size();
    const int closed = has_inside(c.a) + has_inside(c.b);
    for (const Variant& variant : variants) {
        const std::optional<Settings> settings = settings_for(variant, plain, closed);
        if (!settings) continue;
        if (settings->open_as_surface) must_be_refused(c, plain, *settings, tally);
        std::vector<Finding> first;
        for (const BodyForm& form : forms) {
            if (!is_for(form, *settings)) continue;
            const std::vector<Finding> results = results_of(form, *settings, variant.among_others);
            if (&form == &plain) first = results;
            for (std::size_t k = 0; k < results.size(); ++k) {
                const std::string what =
                    fmt::format("{}: {}, pose {}, {}: {}", c.family, c.name, k, form.name, variant.name);
                judge(results[k], form.truths[k], *settings, what, tally);
                if (must_hold(form, plain, k, *settings) && results[k].verdict != first[k].verdict &&
                    !out_of_room(*settings, results[k], first[k]))
                    tally.fault(&Tally::changed, fmt::format("{}: {} became {}", what, name_of(first[k].verdict),
                                                             name_of(results[k].verdict)));
            }
        }
    }
    return tally;
}

} // namespace oncollide::tools
