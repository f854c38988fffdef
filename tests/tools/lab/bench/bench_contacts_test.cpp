#include <array>
#include <map>

#include "tools/command_fixture.hpp"
#include "tools/csv_rows.hpp"

namespace oncollide::test {
namespace {

TEST_F(CommandLine, BenchContactsComparesScenesAtTheSamePoses)
{
    const Outcome outcome = run({"bench", "contacts", "--scene", "stack-12,stack-1200,enclosed-mesh,knots-1500",
                                 "--steps", "60", "--repeats", "1", "--csv", "c.csv", "--json", "c.json"});
    EXPECT_EQ(outcome.code, 0) << outcome.out << outcome.err;
    EXPECT_NE(folder_.read("c.json").find("\"schema\": \"oncollide.bench_contacts\""), std::string::npos);
    int ours = 0, others = 0;
    for (auto& row : read_csv(folder_.read("c.csv"))) {
        if (row["who"] != "oncollide") {
            ++others;
            if (row["scene"] == "enclosed-mesh") {
                EXPECT_EQ(std::stod(row["contacts"]), 0) << row["who"] << " sees no body inside another";
            } else {
                EXPECT_GT(std::stod(row["contacts"]), 0) << row["who"] << " " << row["scene"];
            }
            continue;
        }
        ++ours;
        EXPECT_EQ(row["complete"], "1") << row["scene"];
        const double contacts = std::stod(row["contacts"]);
        if (row["scene"].starts_with("stack")) {
            EXPECT_EQ(contacts, 20) << "five pairs of four points";
        } else if (row["scene"] == "enclosed-mesh") {
            EXPECT_EQ(contacts, 1);
        } else {
            EXPECT_LE(std::stoi(row["most_points"]), 64);
        }
    }
    EXPECT_EQ(ours, 4);
    EXPECT_GE(others, 4) << "FCL is always there";
    expect_error(64, {"bench", "contacts", "--scene", "none"}, {"--scene", "'none'", "stack-12"});
    expect_error(64, {"bench", "contacts", "--nut", "nut.obj"}, {"--nut and --bolt"});
    expect_error(64, {"bench", "contacts", "--repeats", "0"}, {"--repeats 0"});
}

/// The rows of 'bench contacts' with few bodies, by scene, mode and library.
class ShapeContacts : public CommandLine {
protected:
    using Row = std::map<std::string, std::string>;
    std::map<std::array<std::string, 3>, Row> rows(const std::string& scenes, const std::string& threads = "1")
    {
        const Outcome outcome = run({"bench", "contacts", "--scene", scenes, "--bodies", "40", "--steps", "2",
                                     "--repeats", "1", "--threads", threads, "--csv", "c.csv"});
        EXPECT_EQ(outcome.code, 0) << outcome.out << outcome.err;
        std::map<std::array<std::string, 3>, Row> by;
        for (auto& row : read_csv(folder_.read("c.csv"))) by[{row["scene"], row["mode"], row["who"]}] = row;
        return by;
    }
    static double number(const Row& row, const std::string& name) { return std::stod(row.at(name)); }
};

TEST_F(ShapeContacts, ArePlentyInPilesAndOnTheGroundInEachMode)
{
    const auto all = rows("pile-boxes-1000,pile-mixed-1000,pile-hulls-1000,pile-round-1000,pile-spheres-1000,"
                          "pile-capsules-1000,terrain-shapes-1000,mesh-shapes-1000");
    std::map<std::string, int> modes, others;
    for (const auto& [key, row] : all) {
        const auto& [scene, mode, who] = key;
        EXPECT_TRUE(scene.ends_with("-40")) << scene;
        EXPECT_EQ(row.at("bodies"), "41") << scene;
        EXPECT_GT(number(row, "contacts"), 20) << scene << " " << mode << " " << who;
        EXPECT_LT(number(row, "contacts"), 2000) << scene << " " << mode << " " << who;
        if (who != "oncollide") {
            ++others[mode];
            continue;
        }
        ++modes[mode];
        EXPECT_EQ(row.at("complete"), "1") << scene;
        EXPECT_GE(number(row, "regions"), 35) << scene << ": nearly all bodies lie on something";
        EXPECT_LE(number(row, "regions"), 400) << scene;
        EXPECT_GE(number(row, "pairs"), 40) << scene;
    }
    EXPECT_EQ(modes, (std::map<std::string, int>{{"moving", 8}, {"slow", 8}, {"rest", 8}}));
    for (const auto& [mode, count] : others) EXPECT_GE(count, 8) << mode << ": FCL is always there";
}

TEST_F(ShapeContacts, AreTheSameOnTwoThreads)
{
    const std::string scenes = "pile-mixed-1000,terrain-shapes-1000";
    const auto one = rows(scenes), two = rows(scenes, "2");
    ASSERT_EQ(one.size(), two.size());
    for (const auto& [key, row] : one) {
        if (key[2] != "oncollide") continue;
        for (const char* column : {"contacts", "pairs", "regions", "hash"})
            EXPECT_EQ(row.at(column), two.at(key).at(column)) << key[0] << " " << key[1] << " " << column;
    }
}

TEST_F(ShapeContacts, OfSinglePairsAreThoseOfEachPair)
{
    for (const auto& [key, row] : rows("pair-sphere-sphere,pair-box-box,pair-box-sphere,pair-hull20-hull20")) {
        EXPECT_EQ(key[1], "fresh");
        const double contacts = number(row, "contacts");
        if (key[2] != "oncollide") {
            EXPECT_GE(contacts, 0.8) << key[0] << " " << key[2] << ": other libraries miss some";
            EXPECT_LE(contacts, 8) << key[0] << " " << key[2];
        } else if (key[0].ends_with("-sphere")) {
            EXPECT_EQ(contacts, 1) << key[0];
        } else {
            EXPECT_GE(contacts, 1) << key[0];
            EXPECT_LE(contacts, 4) << key[0];
        }
    }
}

TEST_F(CommandLine, AccuracyManifoldsContradictsNoClaim)
{
    const Outcome outcome = run({"manifolds", "--pairs", "200", "--seed", "77"});
    EXPECT_EQ(outcome.code, 0) << outcome.out << outcome.err;
    EXPECT_NE(outcome.out.find("0 faults"), std::string::npos) << outcome.out;
    expect_error(64, {"manifolds", "--pairs", "0"}, {"--pairs 0"});
}

TEST_F(CommandLine, BenchDigFindsTheContactsOfANewTerrain)
{
    const Outcome outcome =
        run({"bench", "dig", "--side", "100", "--bodies", "40", "--frames", "5", "--repeats", "1", "--csv", "d.csv"});
    EXPECT_EQ(outcome.code, 0) << outcome.err;
    std::map<std::string, std::string> contacts;
    for (auto& row : read_csv(folder_.read("d.csv"))) contacts[row["contender"]] = row["contacts"];
    EXPECT_GT(std::stoi(contacts.at("oncollide")), 100);
    EXPECT_EQ(contacts.at("oncollide"), contacts.at("oncollide-replace"));
    expect_error(64, {"bench", "dig", "--side", "2"}, {"--side 2"});
}

} // namespace
} // namespace oncollide::test
