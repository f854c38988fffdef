// The other libraries in 'oncollide-lab study'. The build determines which are available.
#include <set>

#include "tools/command/study/study_fixture.hpp"

namespace oncollide::test {
namespace {

const std::set<std::string> everybody{"FCL", "ODE", "Bullet", "Embree", "CGAL"};

class StudyPeers : public Study {
protected:
    StudyPeers() { command_ = {"study"}; }

    /// The libraries that take part, and the libraries whose packages are missing.
    static std::set<std::string> names(const nlohmann::json& study)
    {
        std::set<std::string> found;
        for (const nlohmann::json& row : study["peers"]) found.insert(row["name"]);
        for (const std::string note : study["left_out"])
            if (note.find("not in this build (Debian: lib") != std::string::npos)
                found.insert(note.substr(0, note.find(':')));
        return found;
    }

    /// Expects every library that takes part to be correct.
    static void expect_right(const nlohmann::json& study)
    {
        EXPECT_EQ(names(study), everybody);
        for (const nlohmann::json& row : study["peers"]) {
            SCOPED_TRACE(row["name"]);
            EXPECT_EQ(row["colliding"], study["header"]["colliding"]);
            EXPECT_EQ(row["missed"], 0);
            EXPECT_EQ(row["invented"], 0);
            EXPECT_GE(row["candidates"], row["colliding"]);
            EXPECT_GT(row["ms_mean"], 0);
            EXPECT_GT(row["times_fcl"], 0);
        }
    }

    void expect_left_out(std::vector<std::string> arguments, const std::string& who, const std::string& why)
    {
        arguments.insert(arguments.end(), {"--depths", "2", "--peers", "all"});
        const nlohmann::json all = study(arguments);
        bool told = peer(all, who).is_null();
        for (const std::string note : all["left_out"])
            told &= !note.starts_with(who) || note.find(why) != std::string::npos ||
                    note.find("not in this build") != std::string::npos;
        EXPECT_TRUE(told && !all["left_out"].empty()) << all["left_out"] << why;
    }
};

TEST_F(StudyPeers, PlayScenesOfMovingStaticAndLayeredBodies)
{
    // Bodies in another order than their geometries, several pairs of these, and a pair that layers forbid.
    folder_.write("mixed.json", R"({"frames": 4, "geometries": {
        "knot": {"mesh": {"generate": {"kind": "torus_knot", "p": 2, "q": 3, "major": 1, "minor": 0.4, "tube": 0.15,
                                       "triangles": 300}}},
        "plank": {"mesh": {"generate": {"kind": "box", "half": [3, 0.1, 0.2]}}},
        "ball": {"mesh": {"generate": {"kind": "sphere", "radius": 0.5, "triangles": 100}}}},
        "bodies": [
        {"name": "ball", "geometry": "ball", "position": [2, 0.05, 0.1], "layer": 3},
        {"name": "plank", "geometry": "plank", "rotation": [0, 0, 0.38268343236508977, 0.92387953251128674],
         "motion": {"drift": {"velocity": [0.31, 0.07, 0.11]}}},
        {"name": "floor", "geometry": "plank", "position": [0, 0.15, 0.03], "static": true},
        {"name": "wall", "geometry": "plank", "position": [0.3, 0.1, 0.1], "static": true},
        {"name": "knot", "geometry": "knot", "position": [1.1, -0.13, 0.17],
         "motion": {"drift": {"velocity": [-0.3, 0.21, 0.05]}}},
        {"name": "ghost", "geometry": "ball", "position": [0.2, 0.1, 0.07], "mask": 2}]})");
    const nlohmann::json all = study(
        {"mixed.json", "--depths", "3", "--warm-up", "0", "--peers", "all", "--csv", "s.csv", "--html", "s.html"});
    EXPECT_GT(all["header"]["colliding"], 8);
    expect_right(all);
    const std::string csv = folder_.read("s.csv"), page = folder_.read("s.html");
    std::size_t rows = 0;
    for (const nlohmann::json& row : all["peers"]) {
        const std::string name = row["name"];
        rows += count_of(csv, "\n\"" + name + "\",");
        EXPECT_NE(page.find(name + " missed 0 collisions and invented 0."), std::string::npos) << name;
        EXPECT_NE(page.find(">" + name + "  "), std::string::npos) << name << " is not a point of the curve";
    }
    EXPECT_EQ(rows, all["peers"].size());
    EXPECT_EQ(std::count(csv.begin(), csv.end(), '\n'), std::ptrdiff_t(1 + all["variants"].size() + rows));
    const std::size_t commas = std::size_t(std::count(csv.begin(), csv.begin() + std::ptrdiff_t(csv.find('\n')), ','));
    EXPECT_EQ(std::count(csv.begin() + std::ptrdiff_t(csv.rfind('\n', csv.size() - 2)), csv.end(), ','),
              std::ptrdiff_t(commas));
}

TEST_F(StudyPeers, PlayPoses)
{
    write_cube("cube.off");
    expect_right(study({"cube.off", "cube.off", "--count", "6", "--distances", "-5,5", "--depths", "2", "--peers",
                        "all", "--repeats", "2"}));
}

TEST_F(StudyPeers, OneThatErrsIsNotExact)
{
    // A gap below single precision and ODE's tolerance; the boxes of the rotated bodies do not show it either.
    folder_.write("gap.json", R"({"frames": 2, "geometries": {"cube": {"mesh": {"generate": {"kind": "box", "half":
        [0.5, 0.5, 0.5]}}}}, "bodies": [{"name": "a", "geometry": "cube", "rotation": [0.28, 0, 0, 0.96]},
        {"name": "b", "geometry": "cube", "position": [1.00000000001, 0.25, 0.25], "rotation": [0.28, 0, 0, 0.96]}]})");
    const nlohmann::json all =
        study({"gap.json", "--depths", "2", "--warm-up", "0", "--peers", "all", "--html", "s.html"});
    EXPECT_EQ(all["header"]["colliding"], 0);
    const std::string page = folder_.read("s.html");
    double fastest = 1e300;
    int erring = 0;
    for (const nlohmann::json& row : all["peers"]) {
        const bool errs = row["name"] == "ODE" || row["name"] == "Bullet";
        erring += errs;
        EXPECT_EQ(row["invented"], errs ? 2 : 0) << row;
        EXPECT_EQ(row["errors"].size(), errs ? 2u : 0u);
        EXPECT_EQ(page.find(row["name"].get<std::string>() + ", not error-free") != std::string::npos, errs);
        if (!errs) fastest = std::min(fastest, row["ms_mean"].get<double>());
    }
    if (!erring) GTEST_SKIP() << "neither ODE nor Bullet in this build";
    for (const nlohmann::json& row : all["variants"])
        if (row["error"] == 0) fastest = std::min(fastest, row["ms_mean"].get<double>());
    for (const char* kind : {"peers", "variants"})
        for (const nlohmann::json& row : all[kind]) {
            const bool exact = kind == std::string("peers") ? row["invented"] == 0 : row["error"] == 0;
            if (kind == std::string("variants") && !exact) continue;
            EXPECT_EQ(row["on_front"], exact && row["ms_mean"] == fastest) << row;
        }
}

TEST_F(StudyPeers, AreLeftOutWhereTheyCannotPlayAndSayWhy)
{
    write_cube("cube.off");
    folder_.write("flat.off", "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n");
    folder_.write("shape.json", R"({"geometries": {"cube": {"mesh": {"generate": {"kind": "box", "half": [1, 1, 1]}}},
        "ball": {"shape": {"kind": "sphere", "radius": 1}}}, "bodies": [{"name": "a", "geometry": "cube"},
        {"name": "b", "geometry": "ball", "position": [1.5, 0, 0]}]})");
    std::string many = R"({"geometries": {)", bodies;
    for (int k = 0; k < 15; ++k) {
        many += fmt::format(R"({}"g{}": {{"mesh": {{"generate": {{"kind": "box", "half": [1, 1, 1]}}}}}})",
                            k ? ", " : "", k);
        bodies += fmt::format(R"({}{{"name": "b{}", "geometry": "g{}"}})", k ? ", " : "", k, k);
    }
    folder_.write("many.json", many + R"(}, "bodies": [)" + bodies + "]}");
    expect_left_out({"shape.json"}, "ODE", "supports only meshes, and 'ball' is not a mesh");
    expect_left_out({"many.json"}, "Bullet", "105 are more than 100");
    expect_left_out({"cube.off", "flat.off", "--count", "2", "--distances", "5"}, "ODE", "fewer than 2 triangles");
    for (const char* who : {"FCL", "CGAL"}) {
        expect_left_out({"cubes.json", "--clearance", "0.01"}, who, "clearance");
        expect_left_out({"cubes.json", "--mode", "solid"}, who, "solids");
        expect_left_out({"cubes.json", "--ignore-touching", "--exact", "predicates"}, who, "touching");
    }
    const nlohmann::json none = study({"cubes.json", "--depths", "2", "--peers", "none"});
    EXPECT_TRUE(none["peers"].empty() && none["left_out"].empty());
    EXPECT_TRUE(none["variants"][0]["times_fcl"].is_null());
    expect_error(64, {"study", "cubes.json", "--peers", "fcl,jolt"},
                 {"--peers jolt", "fcl, ode, bullet, embree, cgal"});
}

TEST_F(StudyPeers, ASceneMayBeCalledAsAnotherCommandIs)
{
    // 'hard' is a scene of the catalogue, and a command beside 'study'.
    const nlohmann::json all =
        study({"hard", "--frames", "1", "--depths", "2", "--exact", "off", "--bounding-volume", "sphere"});
    EXPECT_EQ(all["header"]["bodies"], 50);
}

} // namespace
} // namespace oncollide::test
