// Names of files and folders that std::filesystem, a shell or a network would take for something else: one error line
// with the exit code of the input, never an internal fault.
#include "tools/command/clash/clash_fixture.hpp"

namespace oncollide::test {
namespace {

class HostilePaths : public ClashCommand {
protected:
    void SetUp() override { write_cube("cube.off"); }
    /// One line and code 66, 65, 64 or 73: no fault of the program.
    void refused(std::vector<std::string> arguments, Surroundings around = {})
    {
        std::string line;
        for (const std::string& argument : arguments) line += " " + argument.substr(0, 40);
        SCOPED_TRACE(line);
        const Outcome outcome = run(std::move(arguments), std::move(around));
        EXPECT_TRUE(outcome.code >= 64 && outcome.code != 70) << outcome.code << ": " << outcome.err;
        EXPECT_EQ(outcome.err.find("internal fault"), std::string::npos) << outcome.err;
        EXPECT_EQ(std::count(outcome.err.begin(), outcome.err.end(), '\n'), 1) << outcome.err;
    }
    const std::string urdf_ = R"(<robot name="r"><link name="a"><collision><geometry><mesh filename="{}"/></geometry>)"
                              R"(</collision></link></robot>)";
    std::string urdf_of(const std::string& mesh)
    {
        std::string text = urdf_;
        return text.replace(text.find("{}"), 2, mesh);
    }
};

TEST_F(HostilePaths, AUrdfFileWithoutAFolderFindsItsPackages)
{
    folder_.write("v.urdf", urdf_of("package://parts/cube.off"));
    expect_error(65, {"robot", "v.urdf"}, {"v.urdf: line 1: mesh: ", "name the folder of package 'parts'"});
    std::filesystem::create_directory(folder_ / "parts");
    std::filesystem::copy(folder_ / "cube.off", folder_ / "parts/cube.off");
    EXPECT_EQ(run({"robot", "v.urdf", "--world", "cube.off"}).code, 1);
}

TEST_F(HostilePaths, NamesOfAnyLengthAndLoopsAreNoInternalFaults)
{
    const std::string longest(5000, 'n'), nested = "a/" + std::string(250, 'b') + "/c";
    std::filesystem::create_symlink("loop", folder_ / "loop");
    std::filesystem::create_symlink("loop.off", folder_ / "loop.off");
    folder_.write("s.json", R"({"geometries":{"g":{"mesh":{"file":"loop.off"}}},"bodies":[{"geometry":"g"}]})");
    folder_.write("l.urdf", urdf_of("package://loop/" + longest));
    for (const std::string& name : {longest, nested, std::string("loop"), std::string("cube.off/x")}) {
        for (const char* ending : {".off", ".gltf", ".bt", ".npy", ".cooked"})
            refused({"check", name + ending, "cube.off"});
        refused({"clash", name + ".glb", "cube.off"}), refused({"cook", name + ".ot", "-o", "x.cooked"});
        refused({"run", name + "/x.json"}), refused({"run", name + ".glb"});
        refused({"run", "city", "--bodies", "5", "--frames", "1", "--json", name + "/a", "--csv", name + "/a"});
        refused({"robot", name + ".urdf"}), refused({"spheres", name + ".off"});
        refused({"scene", "city", "--bodies", "5", "--out", name + "/s.json"});
        refused({"run", "city", "--data", name});
        refused({"cook", "cube.off", "-o", name + "/x.cooked"});
        refused({"cook", "--check", name + "/tiles.json"});
        refused({"clash", "cube.off", "cube.off", "--ignore", name});
        refused({"view", name + "/x.h5"});
    }
    refused({"run", "s.json"}), refused({"robot", "l.urdf"});
    EXPECT_EQ(run({"doctor", "--data", longest}).err.find("internal fault"), std::string::npos);
}

TEST_F(HostilePaths, FoldersWhoseNamesAreNotUtf8)
{
    const std::string folder = "\xff\xfe";
    std::filesystem::create_directory(folder_ / folder);
    std::filesystem::copy(folder_ / "cube.off", folder_ / folder / "cube.off");
    EXPECT_EQ(run({"cook", folder + "/cube.off", "--tiles", "2x2", "-o", folder + "/tiles"}).code, 0);
    EXPECT_EQ(run({"check", folder + "/cube.off", "cube.off", "--json", "-"}).code, 1);
    folder_.write("s.json", R"({"geometries":{"g":{"mesh":{"file":"cube.off"}}},"bodies":[{"geometry":"g"}]})");
    std::filesystem::copy(folder_ / "s.json", folder_ / folder / "s.json");
    for (const std::vector<std::string>& arguments :
         {std::vector<std::string>{"run", folder + "/s.json", "--json", folder + "/o.json"},
          {"run", folder + "/s.json", "--pairs", folder + "/o.h5"},
          {"scene", folder + "/s.json", "--out", folder + "/t.json"},
          {"scene", folder + "/s.json", "--out", "t.json"},
          {"clash", folder, "-o", folder + "/o.json", "-o", folder + "/o.csv"},
          {"cook", "--check", folder + "/tiles/tiles.json"}}) {
        const Outcome outcome = run(arguments);
        EXPECT_NE(outcome.code, 70) << arguments[0] << " " << arguments[2] << ": " << outcome.err;
    }
    folder_.write(folder + "/land.json", R"({"geometries":{},"bodies":[{"tiles":{"file":"tiles/tiles.json"}}]})");
    EXPECT_NE(run({"run", folder + "/land.json"}).code, 70);
}

TEST_F(HostilePaths, AFolderThatWasRemovedMeanwhileIsNoInternalFault)
{
    const std::string command = ONCOLLIDE_COMMAND, cube = (folder_ / "cube.off").string();
    folder_.write("s.json", R"({"geometries":{"g":{"mesh":{"file":"cube.off"}}},"bodies":[{"geometry":"g"}]})");
    const auto without_folder = [&](const std::string& rest) {
        return run_program("/bin/sh", {"-c", "mkdir gone && cd gone && rmdir ../gone && exec \"$0\" " + rest, command},
                           {.folder = folder_.path()});
    };
    EXPECT_EQ(without_folder("check " + cube + " " + cube).code, 1) << "whole paths need no folder";
    EXPECT_EQ(without_folder("run " + (folder_ / "s.json").string() + " --quiet").code, 0);
    for (const char* rest : {"check a.off b.off", "robot v.urdf", "run s.json", "cook a.off -o b.cooked",
                             "scene city --bodies 5 --out s.json", "clash . -o a.json"}) {
        const Outcome outcome = without_folder(rest);
        EXPECT_TRUE(outcome.code >= 64 && outcome.code != 70) << rest << ": " << outcome.code << " " << outcome.err;
    }
}

TEST_F(HostilePaths, AddressesAreNotReadInAnyFormat)
{
    const std::string address = "http://localhost/b.off",
                      words = address + ": is an address; files are read from this machine only";
    expect_error(66, {"check", address, "cube.off"}, {words});
    folder_.write("r.urdf", urdf_of(address));
    expect_error(65, {"robot", "r.urdf"}, {"r.urdf: line 1: mesh: ", words});
    folder_.write("s.json",
                  R"({"geometries":{"g":{"mesh":{"file":")" + address + R"("}}},"bodies":[{"geometry":"g"}]})");
    expect_error(66, {"run", "s.json"}, {"s.json: geometries.g.mesh.file: ", words});
    folder_.write("t.json", R"({"geometries":{},"tables":[{"file":")" + address + R"("}]})");
    expect_error(66, {"run", "t.json"}, {"t.json: ", words});
    folder_.write("a.gltf",
                  R"({"asset":{"version":"2.0"},"nodes":[{"mesh":0}],"meshes":[{"primitives":[{"attributes":)"
                  R"({"POSITION":0}}]}],"accessors":[{"bufferView":0,"componentType":5126,"count":3,"type":)"
                  R"("VEC3"}],"bufferViews":[{"buffer":0,"byteLength":36}],"buffers":[{"byteLength":36,"uri":")" +
                      address + R"("}]})");
    expect_error(65, {"check", "a.gltf", "cube.off"}, {"a.gltf: the file of a buffer cannot be read: ", words});
    const std::string here = "file://" + (folder_ / "cube.off").string();
    folder_.write("f.json", R"({"geometries":{"g":{"mesh":{"file":")" + here + R"("}}},"bodies":[{"geometry":"g"}]})");
    EXPECT_EQ(run({"run", "f.json"}).code, 0);
}

TEST_F(HostilePaths, NothingIsQuotedOfAFileOfAnotherKind)
{
    folder_.write("secret", "zebra:x:0:0:hunter2:/root:/bin/sh\nother:y:1:1\n");
    folder_.write("v.urdf", urdf_of("cube.off"));
    const auto quotes_nothing = [&](const std::vector<std::string>& arguments) {
        const Outcome outcome = run(arguments);
        EXPECT_GE(outcome.code, 64) << arguments[0] << " " << arguments[1];
        EXPECT_NE(outcome.code, 70) << outcome.err;
        EXPECT_EQ(outcome.err.find("hunter2"), std::string::npos) << outcome.err;
        EXPECT_EQ(outcome.err.find("zebra"), std::string::npos) << outcome.err;
        EXPECT_EQ(std::count(outcome.err.begin(), outcome.err.end(), '\n'), 1) << outcome.err;
    };
    for (const char* ending : {"obj", "off", "stl", "ply", "gltf", "glb", "dae", "3mf", "bt", "ot", "npy", "pgm", "png",
                               "cooked", "tif", "csv", "json", "h5"}) {
        const std::string name = fmt::format("link.{}", ending);
        std::filesystem::create_symlink("secret", folder_ / name);
        quotes_nothing({"check", name, "cube.off"});
    }
    write_box("a.off", {0, 0, 0}, {1, 1, 1});
    quotes_nothing({"run", "link.json"}), quotes_nothing({"robot", "secret"}), quotes_nothing({"view", "link.h5"});
    quotes_nothing({"clash", "a.off", "cube.off", "--baseline", "link.json"});
    quotes_nothing({"robot", "v.urdf", "--srdf", "secret"});
    quotes_nothing({"robot", "v.urdf", "--configurations", "link.csv"});
    folder_.write("t.json", R"({"geometries":{},"tables":[{"file":"link.csv"}]})");
    quotes_nothing({"run", "t.json"});
    folder_.write("m.json", R"({"geometries":{"g":{"mesh":{"file":"cube.off"}}},"bodies":[{"geometry":"g","motion":)"
                            R"({"tum":{"file":"link.csv","frames_per_second":1}}}]})");
    quotes_nothing({"run", "m.json"});
}

} // namespace
} // namespace oncollide::test
