// Invalid command lines must give one clear line and the right exit code, before any work and without leaving files.
#include "tools/command_fixture.hpp"

namespace oncollide::test {
namespace {

TEST_F(CommandLine, HelpOfEveryCommandTeachesAndExitsWithZero)
{
    const Outcome help = run({"--help"});
    EXPECT_EQ(help.code, 0);
    for (const char* command : {"demo", "run", "render", "check", "clash", "scene", "spheres", "doctor"}) {
        EXPECT_NE(help.out.find(command), std::string::npos) << command;
        const Outcome sub = run({command, "--help"});
        EXPECT_EQ(sub.code, 0) << command;
        EXPECT_GT(sub.out.size(), 100u) << command;
        EXPECT_EQ(sub.err, "");
    }
    EXPECT_NE(run({"check", "--help"}).out.find("0 separate, 1 colliding, 2 within"), std::string::npos);
}

TEST_F(CommandLine, VersionIsTheProjectVersionAndTellsOfTheBuild)
{
    const Outcome outcome = run({"--version"});
    EXPECT_EQ(outcome.code, 0);
    EXPECT_TRUE(outcome.out.starts_with("oncollide " ONCOLLIDE_PROJECT_VERSION "\n")) << outcome.out;
    for (const char* word : {"build ", "flags", "parts ", "FCL", "instructions ", "baseline", "(in use: "})
        EXPECT_NE(outcome.out.find(word), std::string::npos) << word << "\n" << outcome.out;
    const Outcome lowered = run({"--version"}, {.folder = {}, .environment = {{"ONCOLLIDE_ISA", "baseline"}}});
    EXPECT_NE(lowered.out.find("(in use: baseline)"), std::string::npos) << lowered.out;
}

TEST_F(CommandLine, HelpAndVersionAreCommandsToo)
{
    EXPECT_EQ(run({"version"}).out, run({"--version"}).out);
    EXPECT_EQ(run({"help"}).out, run({"--help"}).out);
    EXPECT_EQ(run({"help", "accuracy", "study"}).out, run({"accuracy", "study", "--help"}).out);
    EXPECT_NE(run({"help", "run"}).out.find("Usage: oncollide run "), std::string::npos);
    expect_error(64, {"help", "rnu"}, {"unknown command 'rnu'"});
}

TEST_F(CommandLine, DoctorListsEveryOptionalPart)
{
    const Outcome outcome = run({"doctor"}, {.folder = {}, .environment = {{"ONCOLLIDE_THREE", "/no/folder"}}});
    for (const char* topic : {"\nparts ", "\npages in 3D ", "\nzip files ", "\nYAML files ", "\nHDF5 files ",
                              "\nGeoTIFF files ", "\ndata ", "\nGPU", "FCL", "OctoMap", "OpenMP", "GDAL", "XML", "MPI"})
        EXPECT_NE(outcome.out.find(topic), std::string::npos) << topic << "\n" << outcome.out;
    EXPECT_NE(outcome.out.find("/no/folder/three.min.js: not found"), std::string::npos) << outcome.out;
    EXPECT_NE(outcome.out.find("libjs-three"), std::string::npos) << outcome.out;
    std::filesystem::create_directories(folder_ / "three/examples/js/controls");
    folder_.write("three/three.min.js", "x"), folder_.write("three/examples/js/controls/OrbitControls.js", "x");
    const std::string folder = folder_ / "three";
    EXPECT_NE(run({"doctor"}, {.folder = {}, .environment = {{"ONCOLLIDE_THREE", folder}}})
                  .out.find("pages in 3D   three.js in " + folder + "\n"),
              std::string::npos);
}

TEST_F(CommandLine, UnknownCommandsAndOptionsAreUsageErrorsWithAHint)
{
    expect_error(64, {}, {"demo", "run"});
    expect_error(64, {"rnu"}, {"unknown command 'rnu'", "did you mean 'run'?", "check"});
    expect_error(64, {"--frobnicate"}, {"unknown option '--frobnicate'", "--help"});
    expect_error(64, {"run", "city", "--dpeth", "5"}, {"unknown option '--dpeth'", "did you mean '--depth'?"});
    expect_error(64, {"run", "city", "--zzzzzzzz"}, {"unknown option '--zzzzzzzz'", "valid: ", "--max-error"});
    expect_error(64, {"run", "city", "--dpeth=5"}, {"did you mean '--depth'?"});
    expect_error(64, {"run", "city", "town"}, {"unexpected argument 'town'"});
    expect_error(64, {"accuracy", "stduy"}, {"'stduy'", "did you mean 'study'?", "scene --list"});
    expect_error(64, {"run", "city", "--error", "5"}, {"unknown option '--error'", "did you mean '--max-error'?"});
    expect_error(64, {"run"}, {"scene"});
    expect_error(64, {"check", "a.obj"}, {"B"});
}

TEST_F(CommandLine, ValuesThatAreNoNumbersAreRefused)
{
    expect_error(64, {"run", "city", "--depth", "deep"}, {"--depth"});
    expect_error(64, {"run", "city", "--depth", "6.5"}, {"--depth"});
    expect_error(64, {"run", "city", "--threads", "99999999999999999999"}, {"--threads"});
    expect_error(64, {"run", "city", "--node-budget", "-1"}, {"--node-budget"});
    expect_error(64, {"run", "city", "--memory-budget", "-1"}, {"--memory-budget"});
    expect_error(64, {"run", "city", "--memory-budget", "5 apples"}, {"--memory-budget"});
    expect_error(64, {"run", "city", "--memory-budget", "99999999999G"}, {"--memory-budget"});
    expect_error(64, {"run", "city", "--max-error", "1 foot"}, {"--max-error 1 foot", "such as 2mm"});
    expect_error(64, {"run", "city", "--depth"}, {"--depth needs a D"});
    expect_error(64, {"run", "city", "--depth", "5", "--depth", "6"}, {"--depth is given more than once"});
    expect_error(64, {"run", "city", "--json", ""}, {"--json", "empty"});
}

TEST_F(CommandLine, SettingsOutOfRangeAreRefused)
{
    for (const char* bad : {"nan", "inf", "-1", "1e999"})
        expect_error(64, {"run", "city", "--clearance", bad}, {"clearance"});
    for (const char* bad : {"nan", "inf", "-1", "0"}) expect_error(64, {"run", "city", "--max-error", bad}, {"error"});
    for (const char* bad : {"0", "17", "-3"}) expect_error(64, {"run", "city", "--depth", bad}, {"depth", "1", "16"});
    for (const char* bad : {"-1", "1000000"}) expect_error(64, {"run", "city", "--threads", bad}, {"threads"});
    expect_error(64, {"run", "city", "--age", "0"}, {"age"});
    expect_error(64, {"run", "city", "--depth", "5", "--max-error", "0.1"}, {"depth", "error"});
    expect_error(64, {"run", "city", "--frames", "0"}, {"--frames 0"});
    for (const char* pace : {"-0.1", "-1", "nan", "inf", "1001"})
        expect_error(64, {"run", "city", "--pace", pace}, {"--pace"});
    expect_error(64, {"run", "city", "--bodies", "-5"}, {"--bodies -5"});
}

TEST_F(CommandLine, UnknownNamesListTheValidOnes)
{
    expect_error(64, {"run", "city", "--exact", "maybe"}, {"maybe", "; valid: ", "predicates", "fcl"});
    expect_error(64, {"run", "city", "--exact", "pred"}, {"did you mean 'predicates'?"});
    expect_error(64, {"run", "city", "--backend", "gl-compte"}, {"did you mean 'gl-compute'?"});
    expect_error(64, {"run", "city", "--skip", "delimitaton"}, {"did you mean 'delimitation'?"});
    expect_error(64, {"run", "ctiy"}, {"no scene named 'ctiy'", "did you mean 'city'?"});
    folder_.write("s.json", R"({"geometries": {"crane": {"shape": {"kind": "spere", "radius": 1}}}})");
    expect_error(65, {"run", "s.json"}, {"no shape named 'spere'", "did you mean 'sphere'?"});
    folder_.write("s.json", R"({"geometries": {"crane": {"shape": {"kind": "sphere", "radius": 1}}},
                                "bodies": [{"geometry": "crnae"}]})");
    expect_error(65, {"run", "s.json"}, {"no geometry named 'crnae'", "did you mean 'crane'?"});
    folder_.write("s.json", R"({"geometrys": {}})");
    expect_error(65, {"run", "s.json"}, {"unknown key", "did you mean 'geometries'?"});
    std::filesystem::remove(folder_ / "s.json");
    expect_error(64, {"run", "city", "--mode", "gas"}, {"gas", "surface", "solid"});
    expect_error(64, {"run", "city", "--backend", "abacus"}, {"abacus", "cpu", "gl-compute"});
    expect_error(64, {"run", "city", "--broad", "narrow"}, {"narrow", "kd", "octree", "brute"});
    expect_error(64, {"run", "city", "--skip", "lunch"}, {"lunch", "delimitation", "refine"});
    expect_error(64, {"run", "no-such-scene"}, {"no-such-scene", "city"});
    expect_error(64, {"scene", "no-such-scene", "--out", "x.json"}, {"no-such-scene", "city"});
    EXPECT_TRUE(folder_.list().empty());
}

TEST_F(CommandLine, MissingAndBrokenInputsAreToldApart)
{
    expect_error(66, {"run", "missing.json"}, {"missing.json"});
    expect_error(66, {"run", "./city"}, {"./city"});
    expect_error(66, {"run", "city", "--data", "no-folder"}, {"--data", "no-folder"});
    folder_.write("broken.json", "{\"bodies\": [");
    expect_error(65, {"run", "broken.json"}, {"broken.json"});
    write_cube("cube.off");
    expect_error(66, {"check", "cube.off", "none.off"}, {"none.off"});
    folder_.write("noise.off", "OFF\nnot a mesh\n");
    expect_error(65, {"check", "noise.off", "cube.off"}, {"noise.off"});
    folder_.write("cube.xyz", "1 2 3");
    expect_error(65, {"check", "cube.xyz", "cube.off"}, {"cube.xyz"});
    folder_.write("empty.bt", "");
    expect_error(65, {"check", "empty.bt", "cube.off"}, {"empty.bt"});
}

TEST_F(CommandLine, ANameThatIsBothASceneAndAFileIsAmbiguous)
{
    folder_.write("city", "{}");
    expect_error(64, {"run", "city"}, {"./city"});
}

TEST_F(CommandLine, OptionsOfTheCatalogueAreRefusedForFiles)
{
    folder_.write("file.json", "{}");
    expect_error(64, {"run", "file.json", "--bodies", "5"}, {"--bodies", "file.json"});
    expect_error(64, {"run", "file.json", "--seed", "5"}, {"--seed", "file.json"});
}

TEST_F(CommandLine, JsonHoldsAnyNameOfAScene)
{
    const std::string name = "a \"quoted\" \\ </script>\nname";
    nlohmann::json scene{{"name", name}, {"frames", 1}};
    scene["geometries"]["ball"]["shape"] = {{"kind", "sphere"}, {"radius", 1}};
    scene["bodies"] = nlohmann::json::array({{{"geometry", "ball"}}, {{"geometry", "ball"}, {"position", {1, 0, 0}}}});
    folder_.write("s.json", scene.dump());
    for (const std::vector<std::string>& command :
         {std::vector<std::string>{"accuracy", "s.json", "--depths", "2"}, {"run", "s.json", "--quiet"}}) {
        std::vector<std::string> arguments = command;
        arguments.insert(arguments.end(), {"--json", "r.json"});
        const Outcome outcome = run(arguments);
        ASSERT_EQ(outcome.code, 0) << command[0] << ": " << outcome.err;
        EXPECT_EQ(read_json("r.json").at("header").at("scene"), name) << command[0];
    }
}

TEST_F(CommandLine, AWrongDataVariableIsAnError)
{
    const Outcome outcome = run({"run", "city", "--frames", "1"}, {.folder = {}, .environment = {}});
    EXPECT_EQ(outcome.code, 0) << outcome.err;
    Surroundings around;
    around.folder = folder_.path();
    around.environment = {{"ONCOLLIDE_DATA", "/no/such/folder"}};
    const Outcome wrong = run_program(ONCOLLIDE_COMMAND, {"run", "city", "--frames", "1"}, around);
    EXPECT_EQ(wrong.code, 66);
    EXPECT_NE(wrong.err.find("ONCOLLIDE_DATA"), std::string::npos) << wrong.err;
}

TEST_F(CommandLine, EveryLengthMayHaveAUnit)
{
    write_cube("c.off");
    folder_.write("h.pgm", "P5\n3 3\n255\n123456789");
    const auto json_of = [&](std::vector<std::string> arguments) {
        arguments.insert(arguments.end(), {"--json", "r.json"});
        EXPECT_LT(run(arguments).code, 3) << arguments.back();
        return read_json("r.json").at("header");
    };
    const auto settings =
        json_of({"check", "c.off", "c.off", "--max-error", "9mm", "--clearance", "0.1in"})["settings"];
    EXPECT_EQ(settings["max_error"], 0.009);
    EXPECT_EQ(settings["clearance"], 0.1 * 25.4 / 1000);
    EXPECT_EQ(json_of({"check", "c.off", "c.off", "--clearance", "2 cm"})["settings"]["clearance"], 0.02);
    EXPECT_EQ(json_of({"check", "c.off", "c.off", "--clearance", "2", "cm"})["settings"]["clearance"], 0.02);
    EXPECT_EQ(json_of({"check", "--clearance", "2", "cm", "c.off", "c.off"})["settings"]["clearance"], 0.02);
    write_cube("d.off");
    EXPECT_EQ(run({"clash", "c.off", "d.off", "--units", "m", "--tolerance", "2", "mm", "-o", "clash.json"}).code, 1);
    EXPECT_EQ(read_json("clash.json")["tolerance"], 0.002);
    expect_error(64, {"check", "c.off", "d.off", "--clearance", "2", "feet"}, {"unexpected argument 'feet'"});
    expect_error(64, {"run", "many", "--threads", "2", "mm"}, {"unexpected argument 'mm'"});
    EXPECT_EQ(json_of({"spheres", "c.off", "--directions", "10", "--max-error", "600mm"})["depth"],
              json_of({"spheres", "c.off", "--directions", "10", "--max-error", "0.6"})["depth"]);
    EXPECT_EQ(run({"check", "c.off", "c.off", "--distance", "1mm"}).out,
              run({"check", "c.off", "c.off", "--distance", "1e-3"}).out);
    EXPECT_EQ(run({"cook", "h.pgm", "--spacing", "30cm", "-o", "h.cooked"}).code, 0);
    for (const char* bad : {"1foot", "mm", "1mm mm", "-1mm", "1e999mm", "nanmm"})
        expect_error(64, {"check", "c.off", "c.off", "--clearance", bad}, {"--clearance", bad});
    expect_error(64, {"accuracy", "study", "many", "--max-errors", "1cm,2ft"}, {"--max-errors 2ft", "such as 2mm"});
}

TEST_F(CommandLine, ErrorsOfNamesListEveryValidWord)
{
    expect_error(64, {"run", "many", "--exact", "yes"}, {"valid: auto, on, off, predicates, fcl"});
    expect_error(64, {"run", "many", "--backend", "gpu"}, {"valid: auto, cpu, gl-compute, gl-query, gl\n"});
    const std::string formats = ".json, .gltf, .glb, .dae or .3mf";
    expect_error(64, {"run", "x.urdf"}, {"x.urdf", formats, "scene --list"});
    folder_.write("x.urdf", "<robot/>");
    expect_error(65, {"run", "x.urdf"}, {"x.urdf", formats});
    expect_error(65, {"render", "x.urdf", "--out", "x.png"}, {"x.urdf", formats});
}

TEST_F(CommandLine, AnOutputNamedForAnotherFormatIsRefused)
{
    expect_error(64, {"run", "many", "--pairs", "out.csv"}, {"--pairs out.csv", ".h5, .hdf5", "--csv"});
    expect_error(64, {"run", "many", "--picture", "out.PNG"}, {"--picture out.PNG", ".svg"});
    expect_error(64, {"render", "paper", "--out", "x.jpg"}, {"--out x.jpg", ".png"});
    EXPECT_TRUE(folder_.list().empty());
}

/// docs/stability.md lists all formats.
TEST_F(CommandLine, EveryJsonFileSaysItsSchema)
{
    write_cube("c.off"), write_cube("d.off");
    std::ifstream file(ONCOLLIDE_SOURCE_DIR "/docs/stability.md");
    const std::string page{std::istreambuf_iterator<char>(file), {}};
    folder_.write(
        "s.json",
        R"({"geometries": {"c": {"mesh": {"file": "c.off"}}}, "bodies": [{"geometry": "c"}, {"geometry": "c"}]})");
    const std::vector<std::pair<const char*, std::vector<std::string>>> made{
        {"oncollide.results", {"run", "many", "--bodies", "20", "--frames", "2", "--json", "o.json"}},
        {"oncollide.results", {"check", "c.off", "c.off", "--json", "o.json"}},
        {"oncollide.trace", {"run", "many", "--bodies", "20", "--frames", "2", "--trace", "o.json"}},
        {"oncollide.scene", {"scene", "many", "--bodies", "20", "--out", "o.json"}},
        {"oncollide.spheres", {"spheres", "c.off", "--depth", "2", "--json", "o.json"}},
        {"oncollide.clash", {"clash", "c.off", "d.off", "-o", "o.json"}},
        {"oncollide.accuracy", {"accuracy", "s.json", "--json", "o.json"}},
        {"oncollide.accuracy_study", {"accuracy", "study", "s.json", "--depths", "2", "--json", "o.json"}},
    };
    for (const auto& [schema, arguments] : made) {
        SCOPED_TRACE(schema);
        const Outcome outcome = run(arguments);
        ASSERT_LT(outcome.code, 64) << outcome.err;
        const nlohmann::json j = read_json("o.json");
        EXPECT_EQ(j.value("schema", ""), schema);
        const std::string row = fmt::format("| `{}` | {} |", schema, j.value("schema_version", 0));
        EXPECT_NE(page.find(row), std::string::npos) << row;
    }
}

} // namespace
} // namespace oncollide::test
