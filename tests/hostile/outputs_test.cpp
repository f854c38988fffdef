// Outputs that would destroy something: an input, another user's permissions, a folder full of leftovers.
#include "scenes/mesh_writers.hpp"
#include "tools/command_fixture.hpp"
#include <oncollide/scenes/model/mesh_generators.hpp>

namespace oncollide::test {
namespace {

class HostileOutputs : public CommandLine {
protected:
    /// Exit code 64, one line, and `file` as it was.
    void keeps(const std::string& file, const std::vector<std::string>& arguments)
    {
        const std::string before = folder_.read(file);
        expect_error(64, arguments, {"would overwrite"});
        EXPECT_EQ(folder_.read(file), before);
    }
};

TEST_F(HostileOutputs, AnOutputThatIsAnInputIsRefusedByEveryCommand)
{
    folder_.write("c.obj", as_obj(make_box_mesh({1, 1, 1})));
    std::filesystem::create_symlink("c.obj", folder_ / "link.obj");
    std::filesystem::create_hard_link(folder_ / "c.obj", folder_ / "hard.obj");
    const std::string absolute = folder_ / "c.obj";
    for (const std::string& out :
         {std::string("c.obj"), std::string("./c.obj"), std::string("link.obj"), std::string("hard.obj"), absolute}) {
        keeps("c.obj", {"check", "c.obj", "c.obj", "--exact", "predicates", "--contacts", out});
        keeps("c.obj", {"check", "c.obj", "link.obj", "--json", out});
        keeps("c.obj", {"spheres", "c.obj", "--csv", out});
        keeps("c.obj", {"bench", "narrow", "c.obj", "c.obj", "--csv", out});
        keeps("c.obj", {"accuracy", "study", "c.obj", "hard.obj", "--html", out});
    }
    expect_error(64, {"check", "c.obj", "c.obj", "--exact", "predicates", "--contacts", "-", "--json", "-"},
                 {"both go"});
}

TEST_F(HostileOutputs, AnOutputThatASceneNamesInsideIsRefused)
{
    folder_.write("c.obj", as_obj(make_box_mesh({1, 1, 1})));
    const Mesh box = make_box_mesh({1, 1, 1});
    folder_.write("b.bin", gltf_buffer(box));
    folder_.write("c.gltf", gltf_json(box, R"("uri":"b.bin",)"));
    folder_.write("w.tum", "0 1 2 3 0 0 0 1\n1 2 2 3 0 0 0 1\n");
    std::filesystem::create_symlink("c.obj", folder_ / "link.obj");
    folder_.write("s.json", R"({"geometries":{"a":{"mesh":{"file":"c.obj"}},"b":{"mesh":{"file":"c.gltf"}}},)"
                            R"("bodies":[{"geometry":"a"},{"geometry":"b"},)"
                            R"({"geometry":"a","motion":{"tum":{"file":"w.tum","frames_per_second":1}}}]})");
    for (const char* option : {"--json", "--csv", "--trace", "--picture"})
        for (const char* file : {"s.json", "c.obj", "link.obj", "c.gltf", "b.bin", "w.tum"})
            keeps(file, {"run", "s.json", option, file});
    for (const char* file : {"s.json", "c.obj", "w.tum"}) {
        keeps(file, {"accuracy", "s.json", "--json", file});
        keeps(file, {"bench", "scene", "s.json", "--csv", file});
        keeps(file, {"render", "s.json", "--out", file});
    }
    EXPECT_EQ(folder_.list(), (std::vector<std::string>{"b.bin", "c.gltf", "c.obj", "link.obj", "s.json", "w.tum"}));
    EXPECT_EQ(run({"run", "s.json", "--json", "out.json"}).code, 0);
}

} // namespace
} // namespace oncollide::test
