#include "bench/contacts/contact_race.hpp"

#include <algorithm>
#include <memory>

#include "bench/contacts/our_contacts.hpp"
#include "common/race.hpp"

namespace oncollide::tools {
namespace {

struct TimedStep {
    double ms = std::numeric_limits<double>::infinity(), manifolds_ms = 0;
};

} // namespace

std::vector<ContactRow> race(const ContactScene& scene, const ContactSteps& steps, const ContactContenders& contenders,
                             int threads, int repeats)
{
    std::vector<ContactPeerBody> bodies;
    for (std::size_t i = 0; i < scene.bodies.size(); ++i)
        bodies.push_back({scene.bodies[i].geometry.get(), scene.bodies[i].half.isZero(0), steps.first[i]});
    std::vector<BodyPair> pairs;
    if (scene.pairs_alone)
        for (std::uint32_t i = 0; i + 1 < bodies.size(); i += 2) pairs.push_back({i, i + 1});
    auto ours = std::make_unique<OurContacts>(scene, threads);
    const OurContacts& us = *ours;
    std::vector<ContactRow> rows = {{"oncollide"}};
    std::vector<std::unique_ptr<ContactPeer>> who;
    who.push_back(std::move(ours));
    for (const ContactContender& c : contenders.all) rows.push_back({c.name}), who.push_back(c.make(bodies));

    const auto time = [&](std::size_t k, const Poses& poses) { // the time and the contacts of one step
        if (scene.pairs_alone) who[k]->place(poses);
        std::size_t contacts = 0;
        const double ms = least_ms(1, [&] {
            if (!scene.pairs_alone) who[k]->place(poses);
            contacts = scene.pairs_alone ? who[k]->contacts_of(pairs) : who[k]->contacts();
        });
        return std::pair(ms, static_cast<double>(contacts));
    };
    for (std::size_t k = 0; k < who.size(); ++k) rows[k].first_ms = time(k, steps.first).first;
    std::vector<std::vector<TimedStep>> least(who.size(), std::vector<TimedStep>(steps.steps.size()));
    for (int repeat = -1; repeat < repeats; ++repeat) // trees grow in the first, which does not count
        take_turns(who.size(), static_cast<std::size_t>(repeat + 1), [&](std::size_t k) {
            rows[k].contacts = 0;
            for (std::size_t i = 0; i < steps.steps.size(); ++i) {
                const auto [ms, contacts] = time(k, steps.steps[i]);
                rows[k].contacts += contacts;
                if (repeat >= 0 && ms < least[k][i].ms) least[k][i] = {ms, us.manifolds_ms()};
            }
        });
    const double items = scene.pairs_alone ? static_cast<double>(std::max<std::size_t>(pairs.size(), 1)) : 1;
    const auto shares = items * static_cast<double>(steps.steps.size());
    for (std::size_t k = 0; k < who.size(); ++k) {
        double manifolds_ms = 0;
        for (const TimedStep& step : least[k])
            rows[k].ms += step.ms / shares, manifolds_ms += step.manifolds_ms / shares;
        rows[k].contacts /= shares, rows[k].first_ms /= items;
        if (k == 0 && !scene.pairs_alone)
            rows[k].pairs_ms = rows[k].ms - manifolds_ms, rows[k].manifolds_ms = manifolds_ms;
    }
    return rows;
}

} // namespace oncollide::tools
