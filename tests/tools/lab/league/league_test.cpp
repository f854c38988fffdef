// The league: its truths, its judge, and libraries that crash, hang or lie.
#include <cmath>
#include <fstream>
#include <map>
#include <set>

#include "league/families/families.hpp"
#include "tools/command_fixture.hpp"
#include "tools/csv_rows.hpp"

namespace oncollide::tools {
namespace {

using Meet = LeagueTruth::Meet;

LeagueFault fault_of(league_question question, const LeagueTruth& truth, const league_answer& answer,
                     const LeaguePromise& promised = {})
{
    return judge(question, truth, answer, promised, 0x1p-53).fault;
}

#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wmissing-field-initializers" // results have a few of all fields
TEST(LeagueJudge, NamesEveryFault)
{
    LeagueTruth apart{.meet = Meet::no, .lower = 1, .upper = 1, .gap = 1, .size = 2},
        meet{.meet = Meet::yes, .lower = 0, .upper = 0, .gap = -0.5, .size = 2};
    EXPECT_EQ(fault_of(LEAGUE_MEET, meet, {.meet = 0}), LeagueFault::missed);
    EXPECT_EQ(fault_of(LEAGUE_MEET, apart, {.meet = 1}), LeagueFault::invented);
    EXPECT_EQ(fault_of(LEAGUE_MEET, meet, {.meet = 1}), LeagueFault::none);
    EXPECT_EQ(fault_of(LEAGUE_MEET, apart, {.meet = 1}, {1e-2, true}), LeagueFault::invented) << "beyond its precision";
    LeagueTruth near{.meet = Meet::no, .exact = true, .gap = 1e-3, .size = 2};
    EXPECT_EQ(fault_of(LEAGUE_MEET, near, {.meet = 1}, {1e-2, true}), LeagueFault::extra);
    EXPECT_EQ(fault_of(LEAGUE_MEET, near, {.meet = 1}, {1e-2}), LeagueFault::invented);
    EXPECT_EQ(fault_of(LEAGUE_DISTANCE, apart, {.distance = 1 + 1e-7}), LeagueFault::none) << "1e-6 of the sizes";
    EXPECT_EQ(fault_of(LEAGUE_DISTANCE, apart, {.distance = 1 + 1e-5}), LeagueFault::distance);
    EXPECT_EQ(fault_of(LEAGUE_DISTANCE, apart, {.distance = 1 - 1e-5}), LeagueFault::distance);
    EXPECT_EQ(fault_of(LEAGUE_DISTANCE, apart, {.distance = 1 + 1e-5}, {1e-4}), LeagueFault::none) << "its promise";
    EXPECT_EQ(fault_of(LEAGUE_DISTANCE, apart, {.distance = 1.1, .error = 0.2}), LeagueFault::none) << "its own bound";
    EXPECT_EQ(fault_of(LEAGUE_DISTANCE, apart, {.distance = std::nan("")}), LeagueFault::distance);
    EXPECT_EQ(fault_of(LEAGUE_DISTANCE, apart, {.distance = 0}), LeagueFault::invented);
    EXPECT_EQ(fault_of(LEAGUE_DISTANCE, meet, {.distance = 1}), LeagueFault::missed);
    apart.off_surface = [](const Eigen::Vector3d& p, int of) { return std::abs(p.x() - of); };
    EXPECT_EQ(fault_of(LEAGUE_DISTANCE, apart, {.has_points = 1, .distance = 1, .point_b = {1, 0, 0}}),
              LeagueFault::none);
    EXPECT_EQ(fault_of(LEAGUE_DISTANCE, apart, {.has_points = 1, .distance = 1, .point_b = {1.1, 0, 0}}),
              LeagueFault::points);
    LeagueTruth deep{.meet = Meet::yes, .lower = 0.5, .upper = 0.5, .gap = -0.5, .size = 2};
    deep.way_out = [](const Eigen::Vector3d& along) { return along.x() > 0.9 ? 0.5L : 3.0L; };
    EXPECT_EQ(fault_of(LEAGUE_DEPTH, deep, {.meet = 1, .depth = 0.5, .normal = {1, 0, 0}}), LeagueFault::none);
    EXPECT_EQ(fault_of(LEAGUE_DEPTH, deep, {.meet = 1, .depth = 0.6, .normal = {1, 0, 0}}), LeagueFault::depth);
    EXPECT_EQ(fault_of(LEAGUE_DEPTH, deep, {.meet = 1, .depth = 0.4, .normal = {1, 0, 0}}), LeagueFault::depth);
    EXPECT_EQ(fault_of(LEAGUE_DEPTH, deep, {.meet = 1, .depth = 0.5, .normal = {0, 1, 0}}), LeagueFault::normal);
    EXPECT_EQ(fault_of(LEAGUE_DEPTH, deep, {.meet = 0}), LeagueFault::missed);
    const LeagueTruth hit{.meet = Meet::yes, .exact = true, .lower = 0.25, .upper = 0.25, .way = 10, .size = 2},
        pass{.meet = Meet::no, .exact = true, .way = 10, .size = 2};
    EXPECT_EQ(fault_of(LEAGUE_RAY, hit, {.meet = 1, .time = 0.25}), LeagueFault::none);
    EXPECT_EQ(fault_of(LEAGUE_RAY, hit, {.meet = 1, .time = 0.3}), LeagueFault::late);
    EXPECT_EQ(fault_of(LEAGUE_RAY, hit, {.meet = 1, .time = 0.2}), LeagueFault::early);
    EXPECT_EQ(fault_of(LEAGUE_RAY, hit, {.meet = 0}), LeagueFault::missed);
    EXPECT_EQ(fault_of(LEAGUE_RAY, pass, {.meet = 1, .time = 0.2}), LeagueFault::invented);
    // A graze: a later time is right as long as they are hardly deeper in each other.
    LeagueTruth graze{.meet = Meet::yes, .lower = 0.25, .upper = 0.25, .gap = -1, .way = 10, .size = 2};
    graze.deepest = [](long double, long double to) { return to < 0.5L ? 1e-7L : 1.0L; };
    EXPECT_EQ(fault_of(LEAGUE_TURN, graze, {.meet = 1, .time = 0.4}), LeagueFault::none);
    EXPECT_EQ(fault_of(LEAGUE_TURN, graze, {.meet = 1, .time = 0.6}), LeagueFault::late);
    EXPECT_EQ(fault_of(LEAGUE_TURN, graze, {.meet = 1, .time = std::nan("")}), LeagueFault::late);
    LeagueTruth rest{.meet = Meet::yes, .lower = 0.1, .upper = 0.1, .gap = -0.1, .size = 2};
    rest.tilt = [](const Eigen::Vector3d& along) { return std::acos(std::min(along.z(), 1.0)); };
    rest.off_surface = [](const Eigen::Vector3d& p, int of) { return std::abs(p.z() + 0.1 * of); };
    rest.off_middle = [](std::span<const Eigen::Vector3d> all) { return all.size() < 3 ? 0.5L : 0.0L; };
    const auto contacts = [&](std::vector<league_contact> of) {
        return fault_of(LEAGUE_CONTACTS, rest, {.meet = 1, .contact_count = of.size(), .contacts = of.data()});
    };
    const league_contact good{{0, 0, -0.05}, {0, 0, 1}, 0.1};
    EXPECT_EQ(contacts({good, good, good}), LeagueFault::none);
    EXPECT_EQ(contacts({good, good}), LeagueFault::support);
    EXPECT_EQ(contacts({good, good, {{0, 0, 0.3}, {0, 0, 1}, 0.1}}), LeagueFault::points);
    EXPECT_EQ(contacts({good, good, {{0, 0, -0.05}, {0, 0, 1}, 0.2}}), LeagueFault::depth);
    EXPECT_EQ(contacts({good, good, {{0, 0, -0.05}, {0, 1, 0}, 0.10000001}}), LeagueFault::normal);
    EXPECT_EQ(contacts({}), LeagueFault::missed);
    const LeagueTruth pairs{.pairs = {{0, 1}, {1, 2}}};
    const std::uint32_t all[] = {1, 0, 2, 1}, fewer[] = {0, 1}, more[] = {0, 1, 1, 2, 0, 2};
    EXPECT_EQ(fault_of(LEAGUE_PAIRS, pairs, {.pair_count = 2, .pairs = all}), LeagueFault::none);
    EXPECT_EQ(fault_of(LEAGUE_PAIRS, pairs, {.pair_count = 1, .pairs = fewer}), LeagueFault::missed);
    EXPECT_EQ(fault_of(LEAGUE_PAIRS, pairs, {.pair_count = 3, .pairs = more}), LeagueFault::invented);
}

#pragma GCC diagnostic pop

/// Another method confirms the truths of every family, also about cases that are rounded to float, and both results of
/// yes or no occur.
TEST(LeagueFamilies, HaveTruthsThatAnotherMethodConfirms)
{
    std::map<std::string, int> names, meet, apart; ///< by question
    for (const LeagueFamily& family : league_families()) {
        ++names[family.name];
        for (std::uint64_t seed = 0; seed < 24; ++seed) {
            const LeagueCase asked = family.make(seed), rounded = rounded_to_float(family.make(seed));
            EXPECT_EQ(json_of(AskedCase(asked).view()), json_of(AskedCase(family.make(seed)).view())) << family.name;
            EXPECT_EQ(json_of(AskedCase(rounded).view()), json_of(AskedCase(rounded_to_float(rounded)).view()))
                << family.name;
            for (const LeagueCase* one : {&asked, &rounded}) {
                const LeagueTruth truth = family.truth(*one);
                EXPECT_LE(truth.lower, truth.upper) << family.name << " " << seed;
                if (family.confirms) {
                    EXPECT_TRUE(family.confirms(*one, truth)) << family.name << ", seed " << seed;
                }
                if (family.question == LEAGUE_PAIRS) continue;
                const std::string question(name_of(family.question));
                meet[question] += truth.meet == Meet::yes, apart[question] += truth.meet == Meet::no;
            }
        }
    }
    for (const auto& [question, count] : meet) {
        EXPECT_GT(count, 20) << question;
        if (question != "depth") {
            EXPECT_GT(apart[question], 20) << question;
        }
    }
    EXPECT_GE(names.size(), 25u);
    for (const auto& [name, count] : names) EXPECT_EQ(count, 1) << name;
}

} // namespace
} // namespace oncollide::tools

namespace oncollide::test {
namespace {

class League : public CommandLine {
protected:
    Outcome league(std::vector<std::string> arguments)
    {
        arguments.insert(arguments.begin(), {"league", "--quiet"});
        return run_program(ONCOLLIDE_LAB, arguments, {.folder = folder_.path()});
    }
    Outcome faulty(const std::string& library, std::vector<std::string> more = {})
    {
        more.insert(more.begin(), {"--adapter", ONCOLLIDE_FAULTY_ADAPTER, "--library", library, "--family",
                                   "triangles: random large", "--out", library});
        return league(std::move(more));
    }
    nlohmann::json result(const std::string& library) { return read_json(library + "/league.json")["results"][0]; }
};

TEST_F(League, CountsTheFaultsOfLibrariesAndSurvivesThem)
{
    for (const char* library : {"apart", "meets", "crashes", "hangs", "hungry", "fails", "talks"})
        EXPECT_EQ(faulty(library, {"--cases", library == std::string("hangs") ? "3" : "12"}).code, 0) << library;
    const auto apart = result("apart"), meets = result("meets"), crashes = result("crashes"), hangs = result("hangs"),
               hungry = result("hungry"), talks = result("talks");
    EXPECT_GT(apart["missed"], 0);
    EXPECT_EQ(apart["invented"], 0);
    EXPECT_EQ(apart["missed"].get<int>() + apart["right"].get<int>(), 12);
    EXPECT_EQ(meets["invented"], apart["right"]);
    EXPECT_EQ(crashes["crashed"], 3);
    EXPECT_EQ(crashes["worst"][0]["seed"], 3);
    EXPECT_EQ(crashes["wrong_seeds"].size(), crashes["missed"].get<std::size_t>() + 3);
    EXPECT_EQ(hangs["hung"], 1) << "the third case";
    EXPECT_EQ(hungry["crashed"], 12);
    EXPECT_EQ(result("fails")["failed"], 12);
    EXPECT_EQ(talks["right"], apart["right"]) << "its output does not disturb the results";
    const Outcome opening =
        run_program(ONCOLLIDE_LAB, {"league", "--adapter", ONCOLLIDE_FAULTY_ADAPTER, "--cases", "3"},
                    {.folder = folder_.path(), .environment = {{"ONCOLLIDE_FAULTY_OPEN", "1"}}});
    EXPECT_EQ(opening.code, 65);
    EXPECT_NE(opening.err.find("crashes as it is loaded or in league_open()"), std::string::npos) << opening.err;
}

TEST_F(League, ListsAllFamiliesAndLibraries)
{
    const Outcome outcome = league({"--list"});
    EXPECT_EQ(outcome.code, 0);
    for (const tools::LeagueFamily& family : tools::league_families())
        EXPECT_NE(outcome.out.find(family.name), std::string::npos) << family.name;
    EXPECT_NE(outcome.out.find("\nfcl "), std::string::npos) << outcome.out;
}

TEST_F(League, GoesOnWhereItWasInterrupted)
{
    ASSERT_EQ(faulty("apart", {"--cases", "3000"}).code, 0);
    const std::string steps = folder_.read("apart/league.steps"), csv = folder_.read("apart/league.csv");
    EXPECT_EQ(std::ranges::count(steps, '\n'), 2);
    folder_.write("apart/league.steps", steps.substr(0, steps.size() - 20)); // the last line is cut short
    ASSERT_EQ(faulty("apart", {"--cases", "3000"}).code, 0);
    const auto counts = [](const std::string& text) { return text.substr(0, text.rfind(',')); }; // without the time
    EXPECT_EQ(counts(folder_.read("apart/league.csv")), counts(csv));
    EXPECT_EQ(std::ranges::count(folder_.read("apart/league.steps"), '\n'), 2) << "one step was queried again";
}

TEST_F(League, IsRightAboutOncollideAndItsPageHoldsTheWorstCases)
{
    EXPECT_EQ(league({"--cases", "12", "--library", "oncollide", "--out", "ours"}).code, 0);
    const nlohmann::json ours = read_json("ours/league.json")["results"];
    EXPECT_EQ(ours.size(), tools::league_families().size());
    for (const nlohmann::json& r : ours) EXPECT_EQ(r["right"], 12) << r["family"];
    // All libraries: one family of each group and question.
    std::vector<std::string> arguments{"--cases", "12", "--out", "all"};
    std::set<std::pair<std::string, int>> taken;
    for (const tools::LeagueFamily& family : tools::league_families())
        if (taken.emplace(family.group, family.question).second)
            arguments.insert(arguments.end(), {"--family", family.name});
    const Outcome outcome = league(arguments);
    EXPECT_EQ(outcome.code, 0) << outcome.out;
    const nlohmann::json all = read_json("all/league.json");
    ASSERT_GE(all["libraries"].size(), 4u) << "oncollide in three ways, FCL";
    EXPECT_EQ(all["libraries"][0]["name"], "oncollide");
    for (const nlohmann::json& r : all["results"]) {
        for (const nlohmann::json& worst : r["worst"]) EXPECT_TRUE(worst["case"].contains("question"));
    }
    const std::string page = folder_.read("all/league.html");
    EXPECT_NE(page.find("id=\"league\""), std::string::npos);
    EXPECT_EQ(page.find("{{"), std::string::npos);
    EXPECT_EQ(read_csv(folder_.read("all/league.csv")).size(), all["results"].size());
}

TEST_F(League, AsksAboutOneCaseAndWritesIt)
{
    const Outcome outcome = league({"--family", "rays: through edges", "--seed", "17", "--write", "case.obj"});
    EXPECT_NE(outcome.out.find("oncollide          right"), std::string::npos) << outcome.out;
    EXPECT_NE(folder_.read("case.obj").find("o ray"), std::string::npos);
    EXPECT_EQ(
        league({"--family", "rays: through edges", "--seed", "17", "--library", "oncollide", "--write", "case.json"})
            .code,
        0);
    EXPECT_EQ(read_json("case.json")["question"], "ray");
    // The program gives the same case to the library's adapter.
    const std::string include = std::string("-I") + ONCOLLIDE_SOURCE_DIR + "/tools/lab/league";
    for (const char* family : {"distance: hulls", "contacts: shapes at rest on a mesh", "boxes: touching"}) {
        ASSERT_EQ(league({"--family", family, "--seed", "3", "--library", "oncollide", "--write", "case.cpp"}).code, 0);
        const Outcome built = run_program(
            "/usr/bin/c++", {"-std=c++20", include, (folder_ / "case.cpp").string(), "-o", (folder_ / "case").string()},
            {.folder = folder_.path()});
        ASSERT_EQ(built.code, 0) << built.err;
        const std::string adapter =
            (std::filesystem::path(ONCOLLIDE_LAB).parent_path() / "league/oncollide.so").string();
        const Outcome ran = run_program((folder_ / "case").string(), {adapter}, {.folder = folder_.path()});
        EXPECT_EQ(ran.code, 0) << ran.out;
        EXPECT_NE(ran.out.find("distance "), std::string::npos) << ran.out;
    }
}

/// The page of docs/ shows the example as it is, and what it is right about.
TEST_F(League, TheExampleOfThePageIsRight)
{
    const auto text = [](const char* name) {
        std::ifstream file(std::filesystem::path(ONCOLLIDE_SOURCE_DIR) / name);
        return std::string(std::istreambuf_iterator<char>(file), {});
    };
    EXPECT_NE(text("docs/league.md").find(text("tools/lab/league/adapters/example.cpp")), std::string::npos);
    const Outcome outcome =
        league({"--library", "example", "--family", "distance: spheres and capsules", "--cases", "90"});
    EXPECT_NE(outcome.out.find("example                   30    100.0000"), std::string::npos) << outcome.out;
}

TEST_F(League, RefusesInOneLine)
{
    const auto refused = [&](std::vector<std::string> arguments, int code, const std::string& text) {
        const Outcome outcome = league(std::move(arguments));
        EXPECT_EQ(outcome.code, code) << outcome.err;
        EXPECT_NE(outcome.err.find(text), std::string::npos) << outcome.err;
        EXPECT_EQ(std::ranges::count(outcome.err, '\n'), 1) << outcome.err;
    };
    folder_.write("none.so", "not a library");
    refused({"--adapter", "absent.so"}, 66, "--adapter absent.so: ");
    refused({"--adapter", "none.so"}, 66, "--adapter none.so: ");
    refused({"--library", "flc"}, 64, "--library: unknown 'flc'");
    refused({"--family", "rays"}, 64, "--family: unknown 'rays'");
    refused({"--cases", "0"}, 64, "--cases");
    refused({"--seed", "3"}, 64, "--seed: needs one --family");
    refused({"--write", "x.obj"}, 64, "--write: needs --seed");
    refused({"--write", "x.txt", "--seed", "1", "--family", "boxes: long"}, 64, "--write x.txt: the name must end in");
    folder_.write("file", "");
    refused({"--cases", "1", "--out", "file/x"}, 73, "--out file/x");
}

} // namespace
} // namespace oncollide::test
