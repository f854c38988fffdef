#include "tools/command_fixture.hpp"

#include <cmath>
#include <sstream>

namespace oncollide::test {
namespace {

/// Two cubes of side 1; each test gives the second cube's pose.
class Check : public CommandLine {
protected:
    void SetUp() override { write_cube("a.off"), write_cube("b.off"); }
    Outcome check(const std::string& pose_b, std::vector<std::string> more = {})
    {
        std::vector<std::string> arguments{"check", "a.off", "b.off", "--pose-b", pose_b};
        arguments.insert(arguments.end(), more.begin(), more.end());
        return run(arguments);
    }
};

TEST_F(Check, AnswersSeparateWithACertifiedDistance)
{
    const Outcome outcome = check("1.5 0 0 0 0 0 1", {"--json", "-", "--exact", "fcl"});
    EXPECT_EQ(outcome.code, 0) << outcome.err;
    const nlohmann::json pair = nlohmann::json::parse(outcome.out).at("frames").at(0).at("pairs").at(0);
    EXPECT_EQ(pair.at(2), "separate");
    EXPECT_GT(pair.at(3).get<double>(), 0);
    EXPECT_LE(pair.at(3).get<double>(), 0.5);
}

TEST_F(Check, GivesADistanceEvenWhenTheBoxesAreFarApart)
{
    const Outcome outcome = check("100 0 0 0 0 0 1", {"--json", "-"});
    EXPECT_EQ(outcome.code, 0);
    const double bound = nlohmann::json::parse(outcome.out).at("frames").at(0).at("pairs").at(0).at(3);
    EXPECT_GT(bound, 90);
    EXPECT_LE(bound, 99);
}

TEST_F(Check, NeverCallsADistanceOfZeroCertified)
{
    for (const char* exact : {"predicates", "fcl"}) {
        // Their boxes overlap, and no sphere separates them.
        const Outcome outcome = check("0.71 0.71 0 0 0 0.3826834323650898 0.9238795325112867", {"--exact", exact});
        EXPECT_EQ(outcome.out.find("at least 0 m"), std::string::npos) << outcome.out;
    }
    const Outcome near = check("1.0000001 0 0 0 0 0 1", {"--exact", "predicates"});
    EXPECT_EQ(near.code, 0);
    EXPECT_EQ(near.out.find("at least 0 m"), std::string::npos) << near.out;
    EXPECT_NE(near.out.find("separate: "), std::string::npos) << near.out;
}

TEST_F(Check, BoundsTheDistanceToTheToleranceAsked)
{
    const Outcome exact = check("3 0 0 0 0 0 1", {"--distance", "0"});
    EXPECT_EQ(exact.code, 0) << exact.err;
    EXPECT_NE(exact.out.find("distance: from 1.99999999"), std::string::npos) << exact.out;
    const Outcome rough = check("3 0 0 0 0 0 1", {"--distance", "0.5"});
    const std::size_t from = rough.out.find("distance: from ");
    ASSERT_NE(from, std::string::npos) << rough.out;
    std::istringstream text(rough.out.substr(from + 15));
    double lower = 0, upper = 0;
    std::string to;
    text >> lower >> to >> upper;
    EXPECT_LE(lower, 2);
    EXPECT_GE(upper, 2);
    EXPECT_LE(upper - lower, 0.5 + 1e-9);
    EXPECT_NE(check("0.5 0.2 0 0 0 0 1", {"--distance", "0"}).out.find("distance: 0, triangle"), std::string::npos);
    expect_error(64, {"check", "a.off", "b.off", "--distance=-1"}, {"tolerance of -1"});
    expect_error(64, {"check", "a.off", "b.off", "--distance", "nan"}, {"tolerance of nan"});
}

TEST_F(Check, WritesTheTrianglesThatMeet)
{
    const Outcome touching = check("1 0 0 0 0 0 1", {"--exact", "predicates", "--contacts", "c.csv"});
    EXPECT_EQ(touching.code, 1) << touching.err;
    std::istringstream rows(folder_.read("c.csv"));
    std::string row;
    std::getline(rows, row);
    EXPECT_TRUE(row.starts_with("part_a,part_b,kind,x0")) << row;
    int count = 0;
    for (; std::getline(rows, row); ++count) EXPECT_NE(row.find(",touching,0.5,"), std::string::npos) << row;
    EXPECT_GE(count, 4) << "two triangles of each face meet, and more triangles at the edges";
    EXPECT_EQ(check("1.0000001 0 0 0 0 0 1", {"--exact", "predicates"}).code, 0);
    expect_error(64, {"check", "a.off", "b.off", "--max-error", "1", "--contacts", "c.csv"}, {"--exact on"});
    expect_error(73, {"check", "a.off", "b.off", "--exact", "predicates", "--contacts", "no/c.csv"}, {"no/c.csv"});
}

TEST_F(Check, DecidesUnlessABoundIsAskedFor)
{
    const Outcome decided = check("0.9 0.1 0 0 0 0 1");
    EXPECT_EQ(decided.code, 1) << decided.err;
    EXPECT_TRUE(decided.out.starts_with("colliding (crossing): ")) << decided.out;
    for (const std::vector<std::string>& asked :
         {std::vector<std::string>{"--exact", "off"}, {"--max-error", "0.1"}, {"--depth", "4"}}) {
        const Outcome within = check("0.9 0.1 0 0 0 0 1", asked);
        EXPECT_EQ(within.code, 2) << within.err;
        EXPECT_TRUE(within.out.starts_with("within ")) << within.out;
    }
    EXPECT_EQ(check("0.9 0.1 0 0 0 0 1", {"--max-error", "0.1", "--exact", "predicates"}).code, 1);
}

TEST_F(Check, AnswersCollidingOnlyWhenTheExactLevelRan)
{
    const Outcome outcome = check("0.9 0.1 0 0 0 0 1", {"--exact", "fcl"});
    EXPECT_EQ(outcome.code, 1) << outcome.err;
    EXPECT_NE(outcome.out.find("colliding"), std::string::npos);
    const Outcome within = check("0.9 0.1 0 0 0 0 1", {"--exact", "off"});
    EXPECT_EQ(within.code, 2) << within.err;
    EXPECT_NE(within.out.find("within"), std::string::npos);
}

TEST_F(Check, SaysHowTheyCollide)
{
    const auto says = [&](const char* pose, std::vector<std::string> more, int code, const char* text) {
        more.insert(more.end(), {"--exact", "predicates"});
        const Outcome outcome = check(pose, more);
        EXPECT_EQ(outcome.code, code) << outcome.err;
        EXPECT_TRUE(outcome.out.starts_with(text)) << outcome.out;
    };
    says("1 0.1 0 0 0 0 1", {}, 1, "colliding (touching): ");
    says("0.9 0.1 0.2 0 0 0 1", {}, 1, "colliding (crossing): ");
    says("1 0.1 0 0 0 0 1", {"--ignore-touching"}, 0, "separate: ");
    says("0.9 0.1 0.2 0 0 0 1", {"--ignore-touching"}, 1, "colliding (crossing): ");
    says("1.1 0 0 0 0 0 1", {"--clearance", "0.2"}, 2, "within 0.1 m (near): ");
    expect_error(64, {"check", "a.off", "b.off", "--exact", "off", "--ignore-touching"},
                 {"ignore-touching", "predicates"});
    expect_error(64, {"check", "a.off", "b.off", "--kinds", "--exact", "fcl"}, {"kinds", "predicates"});
}

TEST_F(Check, SolidBodiesEncloseAndOpenMeshesAreRefused)
{
    folder_.write("small.off", "OFF\n4 4 0\n0 0 0\n0.1 0 0\n0 0.1 0\n0 0 0.1\n3 0 2 1\n3 0 1 3\n3 1 2 3\n3 2 0 3\n");
    folder_.write("open.off", "OFF\n4 3 0\n0 0 0\n0.1 0 0\n0 0.1 0\n0 0 0.1\n3 0 2 1\n3 0 1 3\n3 1 2 3\n");
    for (const char* exact : {"off", "predicates", "fcl"}) {
        const Outcome inside = run({"check", "a.off", "small.off", "--mode", "solid", "--exact", exact});
        EXPECT_EQ(inside.code, 1) << inside.err;
        EXPECT_TRUE(inside.out.starts_with("colliding (enclosed): ")) << inside.out;
        EXPECT_EQ(run({"check", "a.off", "small.off", "--exact", exact}).code, 0);
    }
    expect_error(65, {"check", "open.off", "a.off", "--mode", "solid"},
                 {"open.off", "not closed", "3 open edges (vertices 0-2, 3-0, 2-3)", "open-as-surface"});
    const std::vector<std::string> taken{"check", "open.off", "a.off", "--mode", "solid", "--open-as-surface"};
    EXPECT_EQ(run(taken).code, 1) << "the surface is inside the cube";
    expect_error(64, {"check", "a.off", "b.off", "--open-as-surface"}, {"open-as-surface", "solid"});
}

TEST_F(Check, ASmallerMaxErrorNarrowsTheBound)
{
    const auto bound = [&](const char* max_error) {
        const Outcome outcome = check("0.9 0.1 0 0 0 0 1", {"--max-error", max_error, "--json", "-", "--quiet"});
        EXPECT_EQ(outcome.code, 2);
        return nlohmann::json::parse(outcome.out).at("frames").at(0).at("pairs").at(0).at(3).get<double>();
    };
    EXPECT_LE(bound("0.5"), 0.5);
    EXPECT_LE(bound("0.01"), 0.01);
}

TEST_F(Check, ClearanceCountsAsTouching)
{
    EXPECT_EQ(check("1.5 0 0 0 0 0 1", {"--clearance", "0.4"}).code, 0);
    EXPECT_NE(check("1.5 0 0 0 0 0 1", {"--clearance", "0.6"}).code, 0);
}

TEST_F(Check, TheSameFileMayStandOnBothSides)
{
    EXPECT_EQ(run({"check", "a.off", "a.off", "--pose-b", "3 0 0 0 0 0 1"}).code, 0);
    EXPECT_EQ(run({"check", "a.off", "a.off", "--exact", "fcl"}).code, 1);
}

TEST_F(Check, RotationsAreApplied)
{
    // Two cubes at 1.2 along x: apart when parallel, touching if the second is rotated by 45 degrees around z.
    EXPECT_EQ(check("1.2 0 0 0 0 0 1").code, 0);
    const double s = std::sin(M_PI / 8), c = std::cos(M_PI / 8);
    EXPECT_EQ(check(fmt::format("1.2 0 0 0 0 {} {}", s, c), {"--exact", "fcl"}).code, 1);
    EXPECT_EQ(check(fmt::format("1.25 0 0 0 0 {} {}", s, c)).code, 0);
}

TEST_F(Check, QuaternionsThatAreNotUnitAreNormalisedWithAWarning)
{
    const Outcome outcome = check("1.5 0 0 0 0 0 2");
    EXPECT_EQ(outcome.code, 0);
    EXPECT_NE(outcome.err.find("warning: --pose-b"), std::string::npos) << outcome.err;
    EXPECT_EQ(check("1.5, 0, 0, 0, 0, 0, 1").err, "");
}

TEST_F(Check, BadPosesAreUsageErrors)
{
    for (const char* pose : {"1 2 3", "1 2 3 0 0 0 1 9", "a b c d e f g", "nan 0 0 0 0 0 1", "0 0 0 0 0 0 inf",
                             "1e999 0 0 0 0 0 1", "0 0 0 0 0 0 0", "1 2 3 0 0 0 1x"})
        expect_error(64, {"check", "a.off", "b.off", "--pose-b", pose}, {"--pose-b", "x y z qx qy qz qw"});
}

TEST_F(Check, FindsTheFirstContactOnTheWay)
{
    const Outcome passes = check("3 0.25 0 0 0 0 1", {"--to-pose-b", "-5 0.25 0 0 0 0 1"});
    EXPECT_EQ(passes.code, 1) << passes.err;
    EXPECT_NE(passes.out.find("first meet from time 0.25 to 0.250"), std::string::npos) << passes.out;
    const Outcome misses = check("3 1.001 0 0 0 0 1", {"--to-pose-b", "-5 1.001 0 0 0 0 1"});
    EXPECT_EQ(misses.code, 0) << misses.err;
    EXPECT_NE(misses.out.find("never meet on the way"), std::string::npos) << misses.out;
    const auto starts = [&](const char* to) { return check("1 0 0 0 0 0 1", {"--to-pose-b", to}).out; };
    EXPECT_NE(starts("5 0 0 0 0 0 1").find("in contact at time 0, and apart soon after."), std::string::npos);
    EXPECT_NE(starts("1 0.5 0 0 0 0 1").find("in contact at time 0.\n"), std::string::npos);
    const Outcome both =
        check("3 0 0 0 0 0 1", {"--to-pose-a", "4 0 0 0 0 0 1", "--to-pose-b", "0 0 0 0 0 0 1", "--json", "-"});
    EXPECT_EQ(both.code, 1);
    const nlohmann::json frame = nlohmann::json::parse(both.out).at("frames").at(0);
    EXPECT_EQ(frame.at("pairs").at(0).at(2), "colliding");
    EXPECT_NEAR(frame.at("sweeps").at(0).at(4).get<double>(), 2.0 / 7, 1e-4);
    expect_error(64, {"check", "a.off", "b.off", "--to-pose-b", "1 2 3"}, {"--to-pose-b", "x y z qx qy qz qw"});
    expect_error(64, {"check", "a.off", "b.off", "--to-pose-b", "9 0 0 0 0 0 1", "--distance", "0"},
                 {"--to-pose-b", "--distance"});
}

TEST_F(Check, NeverWritesOverItsInputs)
{
    expect_error(64, {"check", "a.off", "b.off", "--json", "b.off"}, {"overwrite the input"});
}

} // namespace
} // namespace oncollide::test
