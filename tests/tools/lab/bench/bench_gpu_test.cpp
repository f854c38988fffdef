// bench gpu, at its small sizes on a software renderer.
#include "tools/command_fixture.hpp"
#include "tools/csv_rows.hpp"

namespace oncollide::test {
namespace {

TEST_F(CommandLine, BenchGpuWritesOneTableAndOneJson)
{
    const Outcome outcome = run({"bench", "gpu", "--sizes", "small"});
    ASSERT_EQ(outcome.code, 0) << outcome.out << outcome.err;
    const std::size_t json = outcome.out.find("\n{");
    ASSERT_NE(json, std::string::npos);
    EXPECT_NE(outcome.out.find("faults     0"), std::string::npos);
    const nlohmann::json all = nlohmann::json::parse(outcome.out.substr(json));
    EXPECT_EQ(all["schema"], "oncollide.bench_gpu");
    EXPECT_EQ(all["schema_version"], 1);
    EXPECT_EQ(all["sizes"], "small");
    for (const char* key : {"renderer", "vendor", "version", "platform"}) EXPECT_NE(all["gpu"][key], "") << key;
    EXPECT_GT(all["gpu"]["limits"]["GL_MAX_SHADER_STORAGE_BLOCK_SIZE"], 1 << 20);
    std::map<std::string, nlohmann::json> parts;
    for (const nlohmann::json& part : all["parts"]) {
        EXPECT_EQ(part["left_out"].size(), 0u) << part["name"];
        parts[part["name"]] = part["rows"];
        for (const nlohmann::json& row : part["rows"]) {
            EXPECT_EQ(row.size(), part["rows"][0].size()) << row;
            EXPECT_TRUE(row["what"].is_string() && row["backend"].is_string()) << row;
        }
    }
    ASSERT_EQ(parts.size(), 11u);
    for (const char* part : {"frames", "batches"})
        for (const nlohmann::json& row : parts[part]) {
            EXPECT_EQ(row["equal"], true) << row;
            EXPECT_EQ(row["renderer"], all["gpu"]["renderer"]) << row;
            const bool gl = row["backend"].get<std::string>().starts_with("gl");
            EXPECT_EQ(gl, row["gpu_pairs"] > 0) << row;
            EXPECT_EQ(gl, row["bytes_down"] > 0) << row;
        }
    EXPECT_EQ(parts["levels"].size(), 7u * 5);
    EXPECT_EQ(parts["correctness"].size(), 3u);
    for (const nlohmann::json& row : parts["correctness"]) EXPECT_EQ(row["equal"], true) << row;
    for (const nlohmann::json& row : parts["octants"]) EXPECT_GT(row["octants_per_s"], 0) << row;
    EXPECT_EQ(parts["trees"].size(), 4u);
    int missing = 0, certified = 0;
    for (const char* part : {"paper", "comparators"})
        for (const nlohmann::json& row : parts[part]) {
            EXPECT_GE(row["candidates"], row["left_over"]) << row;
            EXPECT_GT(row["collisions"], 0) << row;
            const std::string name = row["backend"];
            if (name == "cpu" || name == "gl-compute" || name == "CULLIDE, fattened") {
                EXPECT_EQ(row["missed"], 0) << row;
                ++certified;
            } else {
                missing += row["missed"] > 0;
            }
        }
    EXPECT_EQ(certified, 9);
    EXPECT_GT(missing, 0) << "CULLIDE and viewing volumes miss hard cases";
    std::map<std::string, nlohmann::json> many;
    for (const nlohmann::json& row : parts["many"]) {
        many[row["backend"]] = row;
        EXPECT_EQ(row["hash"], parts["many"][0]["hash"]) << row;
    }
    EXPECT_LT(many["gl-compute, ahead"]["first_rounds"], many["gl-compute"]["first_rounds"]);
}

TEST_F(CommandLine, BenchGpuLeavesOutWhatTheTimeDoesNotAllow)
{
    const Outcome outcome = run({"bench", "gpu", "--sizes", "small", "--limit", "1e-9", "--json", "g.json"});
    EXPECT_EQ(outcome.code, 0) << outcome.err;
    EXPECT_EQ(outcome.out.find("\n{"), std::string::npos);
    const nlohmann::json all = read_json("g.json");
    for (const nlohmann::json& part : all["parts"]) {
        EXPECT_GT(part["left_out"].size(), 0u) << part["name"];
        EXPECT_EQ(part["rows"].size(), 0u);
    }
}

TEST_F(CommandLine, BenchGpuRefusesNonsenseAndEndsInOneLineWithoutAGpu)
{
    expect_error(64, {"bench", "gpu", "--sizes", "huge"}, {"--sizes huge", "auto, full, small"});
    expect_error(64, {"bench", "gpu", "--limit", "0"}, {"--limit 0"});
    expect_error(73, {"bench", "gpu", "--json", "no/where.json"}, {"no/where.json"});
    expect_error(71, {"bench", "gpu", "--gpu", "63"}, {"no GPU 63"});
    const Outcome none =
        run({"bench", "gpu"}, {.folder = {}, .environment = {{"__EGL_VENDOR_LIBRARY_FILENAMES", "/none"}}});
    EXPECT_EQ(none.code, 71);
    EXPECT_EQ(none.out, "");
    EXPECT_EQ(std::count(none.err.begin(), none.err.end(), '\n'), 1) << none.err;
    EXPECT_NE(none.err.find("no GPU"), std::string::npos) << none.err;
}

TEST_F(CommandLine, BenchGpuCountsTheMissesOfComparators)
{
    const Outcome outcome = run({"bench", "gpu", "--part", "comparators", "--scene", "hard", "--frames", "1", "--sizes",
                                 "full", "--csv", "p.csv"});
    ASSERT_EQ(outcome.code, 0) << outcome.err;
    EXPECT_EQ(outcome.out.find("\n{"), std::string::npos) << "the CSV is the result";
    std::map<std::string, std::map<std::string, std::string>> rows;
    for (const auto& row : read_csv(folder_.read("p.csv"))) rows[row.at("backend")] = row;
    ASSERT_EQ(rows.size(), 6u);
    for (const auto& [name, row] : rows) {
        SCOPED_TRACE(name);
        EXPECT_EQ(row.at("collisions"), rows["cpu"]["collisions"]);
        EXPECT_EQ(row.at("candidates"), rows["cpu"]["candidates"]);
        EXPECT_EQ(std::stoi(row.at("queries")) > 0, name != "cpu" && name != "gl-compute");
    }
    EXPECT_GT(std::stoi(rows["CULLIDE"]["missed"]), 0);
    EXPECT_EQ(rows["CULLIDE, fattened"]["missed"], "0");
    EXPECT_EQ(rows["cpu"]["missed"], "0");
    expect_error(64, {"bench", "gpu", "--part", "comparators", "--scene", "no"}, {"no"});
}

TEST_F(CommandLine, BenchGpuRunsSinglePartsAndRefusesNonsense)
{
    const Outcome paper = run({"bench", "gpu", "--part", "timeline", "--sizes", "full", "--frames", "24", "--data",
                               folder_.path().string(), "--csv", "p.csv"});
    EXPECT_EQ(paper.code, 0) << paper.err;
    std::map<std::string, int> frames; // by backend
    for (const auto& row : read_csv(folder_.read("p.csv"))) frames[row.at("backend")] += std::stoi(row.at("frames"));
    EXPECT_EQ(frames.size(), 5u);
    for (const auto& [backend, count] : frames) EXPECT_EQ(count, 24) << backend;
    const Outcome octants = run({"bench", "gpu", "--part", "misses,trees", "--all-backends", "--sizes", "small",
                                 "--repeats", "1", "--data", folder_.path().string(), "--json", "o.json"});
    EXPECT_EQ(octants.code, 0) << octants.err;
    int missing = 0;
    const nlohmann::json misses = read_json("o.json")["parts"][1];
    for (const nlohmann::json& row : misses["rows"]) {
        const std::string name = row["backend"];
        if (name == "cpu" || name == "gl-compute") {
            EXPECT_EQ(row["missed"], 0) << row;
        } else {
            missing += row["missed"] > 0;
        }
    }
    EXPECT_GT(missing, 0) << "occlusion queries miss octants that needles enter";
    expect_error(64, {"bench", "gpu", "--part", "half"}, {"half", "octants, trees, misses"});
    expect_error(64, {"bench", "gpu", "--part", "paper,many", "--csv", "x.csv"}, {"--csv", "--part"});
    expect_error(64, {"bench", "gpu", "--repeats", "0"}, {"--repeats 0"});
    expect_error(64, {"bench", "gpu", "--frames", "0"}, {"--frames 0"});
    expect_error(64, {"bench", "gpu", "--every", "0"}, {"--every 0"});
    expect_error(64, {"bench", "gpu", "--viewport", "0"}, {"viewport", "1024"});
}

} // namespace
} // namespace oncollide::test
