// The table of settings is complete; its reader accepts the text of its writer.
#include <gtest/gtest.h>

#include <set>
#include <utility>

#include <oncollide/base/error.hpp>
#include <oncollide/pipeline/settings_table.hpp>
#include <oncollide/runs/report.hpp>

namespace oncollide {
namespace {

/// A row is missing if this does not compile or the number differs: name every member here.
std::size_t members(const Settings& settings)
{
    const auto& [depth, max_error, clearance, exact, contact_kinds, ignore_touching, mode, open_as_surface, backend,
                 bounding_volume, gpu, viewport, broad_phase, threads, executor, skip, age_limit, node_budget,
                 memory_budget, resident_budget, look_ahead, coherence, stop] = settings;
    (void)depth;
    constexpr std::size_t all = 23;
    return all;
}

TEST(SettingsTable, HasARowForEveryMemberButTheObjectsOfTheProgram)
{
    EXPECT_EQ(settings_table().size(), members({}) - 2) << "without executor and stop";
    std::set<std::string_view> names, keys;
    for (const SettingRow& row : settings_table()) names.insert(row.member), keys.insert(row.key);
    EXPECT_EQ(names.size(), settings_table().size());
    EXPECT_EQ(keys.size(), settings_table().size());
}

TEST(SettingsTable, ReadsWhatItWrites)
{
    const Settings odd{.max_error = 0.125,
                       .clearance = 1e-3,
                       .exact = ExactLevel::predicates,
                       .contact_kinds = true,
                       .mode = Mode::solid,
                       .open_as_surface = true,
                       .backend = BackendKind::gl_query,
                       .bounding_volume = BoundingVolume::sphere,
                       .gpu = 3,
                       .viewport = 64,
                       .broad_phase = BroadPhaseKind::octree,
                       .threads = 7,
                       .skip = {StageId::refine, StageId::bounds},
                       .age_limit = 5,
                       .node_budget = 11,
                       .memory_budget = 12,
                       .resident_budget = 64 << 20,
                       .look_ahead = 5,
                       .coherence = false};
    const nlohmann::json written = nlohmann::json::parse(settings_json(odd)),
                         plain = nlohmann::json::parse(settings_json({}));
    EXPECT_EQ(written.at("resident"), 64 << 20);
    EXPECT_EQ(written.at("look_ahead"), 5);
    EXPECT_EQ(written.at("skip"), (nlohmann::json{"bounds", "refine"}));
    Settings all, results;
    for (const SettingRow& row : settings_table()) row.set(all, written.at(std::string(row.key)));
    EXPECT_EQ(settings_json(all), settings_json(odd));
    set_results_settings(results, written);
    for (const SettingRow& row : settings_table())
        EXPECT_EQ(row.get(results), row.get(row.affects_results ? odd : Settings{})) << row.member;
    set_results_settings(results, {{"skip", {"refine"}}});
    EXPECT_TRUE(results.skip.contains(StageId::refine)) << "the older name";
    EXPECT_NE(written, plain);
}

TEST(SettingsTable, RefusesEachValueOutOfRangeByItsName)
{
    const auto refusal = [](const Settings& settings) -> std::string {
        try {
            check(settings);
        } catch (const Error& error) {
            return error.what();
        }
        return "";
    };
    EXPECT_EQ(refusal({}), "");
    for (const auto& [member, bad] : {std::pair<std::string, nlohmann::json>{"max_error", -1.0},
                                      {"depth", 17},
                                      {"clearance", -1.0},
                                      {"gpu", 64},
                                      {"viewport", 0},
                                      {"threads", -1},
                                      {"age_limit", 0},
                                      {"look_ahead", -1}}) {
        Settings settings;
        setting_of(member)->set(settings, bad);
        const std::string_view option = setting_of(member)->option();
        EXPECT_EQ(refusal(settings).substr(0, option.size() - 2), option.substr(2)) << member;
    }
    EXPECT_EQ(setting_of("nothing"), nullptr);
}

TEST(SettingsTable, CallsALimitThatCanLeavePairsUndecidedOneOfTheResults)
{
    for (const std::string_view member : {"node_budget", "memory_budget", "resident_budget", "backend"})
        EXPECT_TRUE(setting_of(member)->affects_results) << member;
    for (const std::string_view member : {"threads", "coherence", "look_ahead", "age_limit", "gpu"})
        EXPECT_FALSE(setting_of(member)->affects_results) << member;
}

} // namespace
} // namespace oncollide
