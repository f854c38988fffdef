#include "tools/command_fixture.hpp"
#include "tools/decoded_png.hpp"

#include <cmath>
#include <set>
#include <thread>

namespace oncollide::test {
namespace {

TEST_F(CommandLine, RunWritesResultsThatAgreeWithEachOther)
{
    const Outcome outcome = run({"run", "city", "--bodies", "60", "--frames", "4", "--exact", "fcl", "--separate",
                                 "--json", "r.json", "--csv", "r.csv", "--trace", "t.json", "--picture", "p.svg"});
    ASSERT_EQ(outcome.code, 0) << outcome.err;
    const nlohmann::json results = read_json("r.json");
    const nlohmann::json& header = results.at("header");
    EXPECT_EQ(header.at("frames"), 4);
    EXPECT_EQ(header.at("interrupted"), false);
    EXPECT_TRUE(header.at("renderer").is_null());
    EXPECT_EQ(header.at("hash").get<std::string>().size(), 16u);
    EXPECT_EQ(results.at("stages").size(), 5u);
    EXPECT_NE(outcome.out.find(header.at("hash").get<std::string>()), std::string::npos) << "the table shows the hash";

    std::size_t pairs = 0, counted = 0;
    for (const nlohmann::json& frame : results.at("frames")) pairs += frame.at("pairs").size();
    for (const auto& [verdict, count] : header.at("verdicts").items()) counted += count.get<std::size_t>();
    EXPECT_EQ(pairs, counted);
    const std::string csv = folder_.read("r.csv");
    EXPECT_EQ(std::size_t(std::count(csv.begin(), csv.end(), '\n')), pairs + 1);
    EXPECT_GT(read_json("t.json").at("traceEvents").size(), 4u * 6u);
    EXPECT_EQ(folder_.list(), (std::vector<std::string>{"p.svg", "r.csv", "r.json", "t.json"}));
}

TEST_F(CommandLine, QuietRunsPrintNothing)
{
    const Outcome outcome = run({"run", "city", "--bodies", "20", "--frames", "2", "--quiet"});
    EXPECT_EQ(outcome.code, 0);
    EXPECT_EQ(outcome.out + outcome.err, "");
}

/// Boxes of side 1 in a line: at 0 and 0.6 they overlap, at 3 and 4.1 they are close, at 9 one is alone.
constexpr const char* row_of_boxes =
    R"({"geometries": {"box": {"shape": {"kind": "box", "half": [0.5, 0.5, 0.5]}}}, "bodies": [
    {"geometry": "box", "name": "crane", "position": [0, 0, 0]}, {"geometry": "box", "name": "lorry", "position": [0.6, 0, 0]},
    {"geometry": "box", "name": "shed", "position": [3, 0, 0]}, {"geometry": "box", "name": "fence", "position": [4.1, 0, 0]},
    {"geometry": "box", "name": "tree", "position": [9, 0, 0]}]})";

TEST_F(CommandLine, ARunNamesThePairsThatCollideAndThoseThatMay)
{
    folder_.write("row.json", row_of_boxes);
    const Outcome exact = run({"run", "row.json", "--exact", "on", "--clearance", "0.2"});
    EXPECT_EQ(exact.code, 0) << exact.err;
    EXPECT_NE(exact.out.find("1 pair collides:\n  'crane' and 'lorry'\n"), std::string::npos) << exact.out;
    EXPECT_NE(exact.out.find("1 pair is close or undecided:\n  'shed' and 'fence', near, at most "), std::string::npos)
        << exact.out;
    EXPECT_EQ(exact.out.find("'tree'"), std::string::npos) << exact.out;
    const Outcome bound = run({"run", "row.json", "--exact", "off"});
    EXPECT_NE(bound.out.find("1 pair may or may not collide (--exact on decides):\n  'crane' and 'lorry', at most"),
              std::string::npos)
        << bound.out;

    const Outcome many = run({"run", "many", "--bodies", "100", "--frames", "2", "--exact", "on"});
    EXPECT_NE(many.out.find(", from frame 0\n"), std::string::npos) << many.out;
    EXPECT_NE(many.out.find(" more; --csv FILE writes them all\n"), std::string::npos) << many.out;
    EXPECT_EQ(run({"run", "row.json", "--exact", "on", "--csv", "-"}).err.find("--csv FILE"), std::string::npos);
}

TEST_F(CommandLine, TheExitCodeOfARunTellsOfItsPairsOnRequest)
{
    const std::string boxes(row_of_boxes);
    folder_.write("row.json", boxes);
    const auto code = [&](std::vector<std::string> more) {
        std::vector<std::string> arguments{"run", "row.json", "--quiet"};
        arguments.insert(arguments.end(), more.begin(), more.end());
        return run(arguments).code;
    };
    EXPECT_EQ(code({"--exact", "on"}), 0);
    EXPECT_EQ(code({"--exit-code"}), 1) << "exact by default";
    for (const std::vector<std::string>& bounded : std::vector<std::vector<std::string>>{
             {"--exact", "off"}, {"--max-error", "0.01"}, {"--depth", "3"}, {"--bounding-volume", "sphere"}}) {
        std::vector<std::string> more = bounded;
        more.push_back("--exit-code");
        EXPECT_EQ(code(more), 2) << bounded[0] << ": nothing is called colliding without an exact level";
        if (bounded[0] == "--exact") continue;
        more.insert(more.end(), {"--exact", "on"});
        EXPECT_EQ(code(more), 1) << bounded[0];
    }
    std::string apart = boxes;
    apart.replace(apart.find("[0.6, 0, 0]"), 11, "[1.5, 0, 0]");
    folder_.write("row.json", apart);
    EXPECT_EQ(code({"--exact", "on", "--exit-code"}), 0);
    EXPECT_EQ(code({"--exact", "on", "--exit-code", "--clearance", "0.2"}), 2);
    folder_.write("row.json", "{");
    EXPECT_EQ(code({"--exit-code"}), 65);
}

TEST_F(CommandLine, JsonOnStandardOutputIsNothingButJson)
{
    const Outcome outcome = run({"run", "city", "--bodies", "20", "--frames", "2", "--json", "-"});
    ASSERT_EQ(outcome.code, 0);
    EXPECT_EQ(nlohmann::json::parse(outcome.out).at("frames").size(), 2u);
    EXPECT_NE(outcome.err.find("delimitation"), std::string::npos) << "the table goes to standard error";
}

TEST_F(CommandLine, ThreadsAndCoherenceDoNotChangeTheHash)
{
    std::set<std::string> hashes;
    for (const std::vector<std::string>& more : std::vector<std::vector<std::string>>{{},
                                                                                      {"--threads", "4"},
                                                                                      {"--threads", "0"},
                                                                                      {"--no-coherence"},
                                                                                      {"--broad", "brute"},
                                                                                      {"--broad", "octree"}}) {
        std::vector<std::string> arguments{"run", "city",    "--bodies", "80",    "--frames",
                                           "6",   "--quiet", "--json",   "r.json"};
        arguments.insert(arguments.end(), more.begin(), more.end());
        ASSERT_EQ(run(arguments).code, 0);
        hashes.insert(read_json("r.json").at("header").at("hash").get<std::string>());
    }
    EXPECT_EQ(hashes.size(), 1u);
}

TEST_F(CommandLine, EveryInstructionSetAndBuildTypeGivesTheKnownHash)
{
    // Pinned: debug and release builds, with and without AVX, must all produce it. It changes if results change; the
    // author of the change must explain why.
    const std::string known = "f5eb4e7481dbad57";
    for (const char* set : {"baseline", "avx2", "avx512"}) {
        const Outcome outcome =
            run({"run", "many", "--bodies", "60", "--frames", "3", "--depth", "5", "--json", "-", "--quiet"},
                {.folder = {}, .environment = {{"ONCOLLIDE_ISA", set}}});
        ASSERT_EQ(outcome.code, 0) << outcome.err;
        EXPECT_EQ(nlohmann::json::parse(outcome.out)["header"]["hash"], known) << set;
    }
}

TEST_F(CommandLine, GlComputeGivesTheKnownHash)
{
    const Outcome outcome = run({"run", "many", "--bodies", "60", "--frames", "3", "--depth", "5", "--json", "-",
                                 "--quiet", "--backend", "gl-compute"});
    ASSERT_EQ(outcome.code, 0) << outcome.err;
    const nlohmann::json header = nlohmann::json::parse(outcome.out)["header"];
    EXPECT_EQ(header["hash"], "f5eb4e7481dbad57");
    EXPECT_FALSE(header["renderer"].get<std::string>().empty());
    EXPECT_GT(header["trees"]["gpu_bytes"], 0);
}

TEST_F(CommandLine, AccuracyShowsWhatOcclusionQueriesMiss)
{
    ASSERT_EQ(run({"scene", "hard", "--out", "hard.json"}).code, 0);
    const Outcome query = run({"accuracy", "hard.json", "--depths", "6", "--backend", "gl-query"});
    EXPECT_EQ(query.code, 70) << query.out; // needles and slivers leave no fragment
    EXPECT_NE(query.out.find("gl-query (16 px"), std::string::npos) << query.out;
    EXPECT_NE(query.out.find("VIOLATIONS"), std::string::npos) << query.out;
}

TEST_F(CommandLine, ARunOnTheCpuNeverTouchesEgl)
{
    const auto loads_egl = [&](std::vector<std::string> options) {
        std::vector<std::string> arguments{"run", "many", "--bodies", "10", "--frames", "2"};
        arguments.insert(arguments.end(), options.begin(), options.end());
        const Outcome outcome = run(arguments, {.folder = {}, .environment = {{"LD_DEBUG", "libs"}}});
        EXPECT_EQ(outcome.code, 0);
        return outcome.err.find("libEGL") != std::string::npos;
    };
    EXPECT_FALSE(loads_egl({}));
    EXPECT_FALSE(loads_egl({"--backend", "cpu", "--exact", "fcl"}));
    EXPECT_TRUE(loads_egl({"--backend", "gl-compute"}));
}

TEST_F(CommandLine, WithoutAGpuABackendByNameIsAnErrorAndAutoSaysWhyOnce)
{
    const Surroundings no_driver{.folder = {}, .environment = {{"__EGL_VENDOR_LIBRARY_FILENAMES", "/nowhere"}}};
    const Outcome by_name = run({"run", "many", "--bodies", "10", "--backend", "gl-compute"}, no_driver);
    EXPECT_EQ(by_name.code, 71);
    EXPECT_NE(by_name.err.find("EGL"), std::string::npos) << by_name.err;
    const Outcome any = run({"run", "many", "--bodies", "10", "--frames", "3", "--backend", "auto"}, no_driver);
    EXPECT_EQ(any.code, 0);
    const std::size_t note = any.err.find("auto: the CPU was chosen");
    EXPECT_NE(note, std::string::npos) << any.err;
    EXPECT_EQ(any.err.find("auto: the CPU was chosen", note + 1), std::string::npos) << "once";
    expect_error(71, {"run", "city", "--backend", "gl-compute", "--gpu", "63"}, {"63", "doctor"});
}

TEST_F(CommandLine, AWrittenSceneRunsLikeItsName)
{
    small_scene();
    ASSERT_EQ(run({"run", "small.json", "--quiet", "--json", "file.json"}).code, 0);
    ASSERT_EQ(run({"run", "city", "--bodies", "40", "--frames", "5", "--quiet", "--json", "name.json"}).code, 0);
    EXPECT_EQ(read_json("file.json").at("header").at("hash"), read_json("name.json").at("header").at("hash"));
    EXPECT_EQ(read_json("file.json").at("header").at("frames"), 5);
    ASSERT_EQ(run({"run", "small.json", "--frames", "2", "--quiet", "--json", "file.json"}).code, 0);
    EXPECT_EQ(read_json("file.json").at("header").at("frames"), 2);
}

TEST_F(CommandLine, ARecordedPoseThatIsNoneEndsTheRunThereWithTheFramesBeforeIt)
{
    constexpr int frames = 100, bodies = 2, wrong = 50;
    std::string header = "{'descr': '<f4', 'fortran_order': False, 'shape': (100, 2, 7), }";
    header.resize(117, ' '), header += '\n';
    std::string bytes = std::string("\x93NUMPY\x01\0", 8) + char(header.size()) + '\0' + header;
    for (int f = 0; f < frames; ++f)
        for (int b = 0; b < bodies; ++b) {
            const float pose[] = {f == wrong && b == 1 ? NAN : 0.1f * float(f * b), 0, 0, 0, 0, 0, 1};
            bytes.append(reinterpret_cast<const char*>(pose), sizeof pose);
        }
    folder_.write("run.npy", bytes);
    folder_.write("s.json", R"({"geometries": {"ball": {"shape": {"kind": "sphere", "radius": 1}}}, "recording":
        {"file": "run.npy"}, "bodies": [{"geometry": "ball"}, {"geometry": "ball", "name": "drone"}]})");
    const Outcome outcome = run({"run", "s.json", "--csv", "r.csv", "--json", "r.json", "--quiet"});
    EXPECT_EQ(outcome.code, 65);
    for (const char* part : {"run.npy: frame 50: body 'drone': (nan", "after 50 of 100 frames", "r.csv"})
        EXPECT_NE(outcome.err.find(part), std::string::npos) << outcome.err;
    EXPECT_EQ(read_json("r.json").at("header").at("frames"), wrong);
    const std::string rows = folder_.read("r.csv"); // they separate after frame 20
    EXPECT_EQ(std::count(rows.begin(), rows.end(), '\n'), 1 + 21) << rows;
}

TEST_F(CommandLine, UnwritableOutputsAreRefusedBeforeTheRun)
{
    // Runs of this length take far longer than the test's time limit.
    const std::vector<std::string> endless{"run", "city", "--frames", "100000000", "--quiet"};
    for (const char* option : {"--json", "--csv", "--trace", "--picture"}) {
        std::vector<std::string> arguments = endless;
        arguments.insert(arguments.end(), {option, "no/such/folder/file"});
        expect_error(73, arguments, {"no/such/folder/file", "no folder"});
    }
    std::vector<std::string> arguments = endless;
    arguments.insert(arguments.end(), {"--json", folder_.path().string()});
    expect_error(73, arguments, {"folder"});
    expect_error(73, {"scene", "city", "--out", "no/such/folder/file.json"}, {"no/such/folder"});
    EXPECT_TRUE(folder_.list().empty());
}

TEST_F(CommandLine, AFullDiskIsAnErrorAndLeavesNothing)
{
    for (const char* option : {"--json", "--csv", "--trace", "--picture"})
        expect_error(73, {"run", "city", "--bodies", "20", "--frames", "2", "--quiet", option, "/dev/full"},
                     {"/dev/full", "No space left"});
    Surroundings around;
    around.out = "/dev/full";
    const Outcome outcome = run({"run", "city", "--bodies", "20", "--frames", "2"}, around);
    EXPECT_EQ(outcome.code, 73) << outcome.err;
    EXPECT_TRUE(folder_.list().empty());
}

TEST_F(CommandLine, AnOutputMayNotBeTheInputOrAnotherOutput)
{
    small_scene();
    const std::string before = folder_.read("small.json");
    expect_error(64, {"run", "small.json", "--json", "./small.json"}, {"overwrite the input"});
    EXPECT_EQ(folder_.read("small.json"), before);
    expect_error(64, {"run", "city", "--json", "x", "--csv", "./x"}, {"--json", "--csv"});
    expect_error(64, {"run", "city", "--json", "-", "--csv", "-"}, {"--json", "--csv"});
}

TEST_F(CommandLine, ALinkedOutputIsReplacedAtItsTarget)
{
    folder_.write("target.json", "old");
    std::filesystem::create_symlink("target.json", folder_ / "link.json");
    ASSERT_EQ(run({"run", "city", "--bodies", "20", "--frames", "1", "--quiet", "--json", "link.json"}).code, 0);
    EXPECT_TRUE(std::filesystem::is_symlink(folder_ / "link.json"));
    EXPECT_EQ(read_json("target.json").at("frames").size(), 1u);
}

class Interrupted : public CommandLine, public ::testing::WithParamInterface<int> {};

TEST_P(Interrupted, RunsWriteWhatTheyHave)
{
    Surroundings around;
    around.meanwhile = [](pid_t child) {
        std::this_thread::sleep_for(std::chrono::milliseconds(1500));
        ::kill(child, GetParam());
    };
    const Outcome outcome =
        run({"run", "city", "--bodies", "100", "--frames", "100000000", "--quiet", "--json", "r.json"}, around);
    EXPECT_EQ(outcome.code, 130) << outcome.err;
    EXPECT_NE(outcome.err.find("interrupted after"), std::string::npos) << outcome.err;
    const nlohmann::json results = read_json("r.json");
    EXPECT_EQ(results.at("header").at("interrupted"), true);
    EXPECT_EQ(results.at("header").at("frames"), results.at("frames").size());
    EXPECT_EQ(folder_.list(), std::vector<std::string>{"r.json"});
}
INSTANTIATE_TEST_SUITE_P(Signals, Interrupted, ::testing::Values(SIGINT, SIGTERM),
                         [](const auto& signal) { return std::string(signal.param == SIGINT ? "SIGINT" : "SIGTERM"); });

TEST_F(CommandLine, SceneListsTheCatalogue)
{
    const Outcome outcome = run({"scene", "--list"});
    EXPECT_EQ(outcome.code, 0);
    EXPECT_NE(outcome.out.find("city"), std::string::npos);
    expect_error(64, {"scene", "city"}, {"--out"});
    expect_error(64, {"scene"}, {"--list"});
}

TEST_F(CommandLine, DoctorAnswersAndWritesNothing)
{
    const Outcome outcome = run({"doctor"});
    EXPECT_EQ(outcome.code, 0) << outcome.out;
    for (const char* word : {"processor", "threads", "FCL 0.", "self-test", "passed", "GPU 0"})
        EXPECT_NE(outcome.out.find(word), std::string::npos) << word;
    for (const char* word : {"build ", "parts ", "HDF5 files", "GeoTIFF files"})
        EXPECT_NE(outcome.out.find(word), std::string::npos) << word;
    EXPECT_TRUE(folder_.list().empty());
}

TEST_F(CommandLine, TheDoctorsReportHasWhatABugReportNeeds)
{
    const Outcome outcome = run({"doctor", "--report", "bug.txt"},
                                {.folder = {}, .environment = {{"OMP_NUM_THREADS", "3"}, {"SECRET", "x"}}});
    EXPECT_EQ(outcome.code, 0) << outcome.err;
    const std::string report = folder_.read("bug.txt");
    for (const char* word : {"processor", "self-test", "flags", "system ", "glibc", "memory", "OMP_NUM_THREADS=3"})
        EXPECT_NE(report.find(word), std::string::npos) << word << "\n" << report;
    EXPECT_EQ(report.find("SECRET"), std::string::npos);
    EXPECT_NE(outcome.out.find("Written to bug.txt"), std::string::npos) << outcome.out;
    expect_error(73, {"doctor", "--report", "no/such/folder/bug.txt"}, {"no/such/folder"});
}

TEST_F(CommandLine, TheDemoGivesEveryLevelSomethingToDo)
{
    const Outcome outcome = run({"demo", "--out", "a/b"});
    ASSERT_EQ(outcome.code, 0) << outcome.err;
    const nlohmann::json results = nlohmann::json::parse(folder_.read("a/b/results.json"));
    for (const nlohmann::json& stage : results.at("stages")) {
        EXPECT_EQ(stage.at("skipped"), false) << stage;
        if (stage.at("stage") != "bounds") {
            EXPECT_GT(stage.at("culled"), 0) << stage;
        }
    }
    EXPECT_GT(results.at("header").at("verdicts").at("colliding"), 0);
    for (const char* file : {"results.csv", "trace.json", "picture.svg"})
        EXPECT_GT(folder_.read(std::string("a/b/") + file).size(), 500u) << file;
    const Decoded collision = decode(folder_.read("a/b/collision.png"));
    EXPECT_GT(collision.count([](const std::uint8_t* c) { return c[0] > 2 * c[1]; }), 200) << "triangles that meet";
    EXPECT_LT(collision.count([](const std::uint8_t* c) { return c[0] == 255 && c[1] == 255; }),
              9 * collision.width * collision.height / 10);
    if (std::filesystem::exists("/usr/share/javascript/three/three.min.js")) {
        EXPECT_NE(folder_.read("a/b/page.html").find("<html"), std::string::npos);
        EXPECT_NE(outcome.out.find("xdg-open a/b/page.html"), std::string::npos) << outcome.out;
    }
}

} // namespace
} // namespace oncollide::test
