// Instances, morph targets and skins change the number or the shape of glTF meshes.
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "scenes/files/mesh_writers.hpp"
#include "scenes/test_files.hpp"
#include <oncollide/samples/generators.hpp>
#include <oncollide/scenes/files/geometry_file.hpp>
#include <oncollide/scenes/files/scene_file.hpp>

namespace oncollide {
namespace {

using Eigen::Vector3d;
using nlohmann::json;
using test::expect_error;

std::vector<std::string> warnings;

/// A file of one box of 2 x 4 x 6 as mesh 0, shown by node 0.
class GltfShape : public ::testing::Test {
protected:
    void SetUp() override
    {
        bytes_ = test::gltf_buffer(box_);
        const std::size_t corners = 3 * box_.triangles.size(), vertices = box_.vertices.size();
        file_ = {{"asset", {{"version", "2.0"}}},
                 {"nodes", json::array({{{"mesh", 0}, {"name", "box"}}})},
                 {"meshes",
                  json::array({{{"primitives", json::array({{{"attributes", {{"POSITION", 1}}}, {"indices", 0}}})}}})}};
        add(5125, corners, "SCALAR", 0, 4 * corners);
        add(5126, vertices, "VEC3", 4 * corners, 12 * vertices);
        warnings.clear();
        on_file_warning([](const std::string& line) { warnings.push_back(line); });
    }
    void TearDown() override { on_file_warning(nullptr); }

    /// Returns the accessor's number.
    int add(int type, std::size_t count, const char* shape, std::size_t offset, std::size_t size,
            bool normalized = false)
    {
        const int view = int(file_["bufferViews"].size());
        file_["bufferViews"].push_back({{"buffer", 0}, {"byteOffset", offset}, {"byteLength", size}});
        json accessor{{"bufferView", view}, {"componentType", type}, {"count", count}, {"type", shape}};
        if (normalized) accessor["normalized"] = true;
        file_["accessors"].push_back(accessor);
        return view;
    }
    template <class Number>
    int add_numbers(int type, const char* shape, std::size_t each, const std::vector<Number>& numbers)
    {
        while (bytes_.size() % 4) bytes_ += '\0';
        const std::size_t begin = bytes_.size();
        for (const Number number : numbers) test::append(bytes_, number);
        return add(type, numbers.size() / each, shape, begin, bytes_.size() - begin, type != 5126);
    }
    std::filesystem::path write()
    {
        folder_.write("a.bin", bytes_);
        file_["buffers"] = json::array({{{"uri", "a.bin"}, {"byteLength", bytes_.size()}}});
        return folder_.write("a.gltf", file_.dump());
    }
    void instances(const json& attributes)
    {
        file_["nodes"][0]["extensions"]["EXT_mesh_gpu_instancing"]["attributes"] = attributes;
    }

    const Mesh box_ = make_box_mesh({1, 2, 3});
    std::string bytes_;
    json file_;
    test::TemporaryFolder folder_;
};

TEST_F(GltfShape, EachInstanceOfANodeIsAPartAndSharesTheMesh)
{
    file_["nodes"][0]["translation"] = {100, 0, 0};
    instances(
        {{"TRANSLATION", add_numbers<float>(5126, "VEC3", 3, {0, 0, 0, 10, 0, 0, 0, 20, 0})},
         {"ROTATION", add_numbers<std::int16_t>(5122, "VEC4", 4, {0, 0, 0, 32767, 0, 0, 32767, 0, 0, 0, 0, 32767})},
         {"_ID", 0}});
    file_["extensionsRequired"] = {"EXT_mesh_gpu_instancing"};
    const Assembly found = load_assembly(write());
    ASSERT_EQ(found.parts.size(), 3u);
    EXPECT_EQ(found.meshes.size(), 1u);
    EXPECT_EQ(found.parts[0].pose.translation(), Vector3d(100, 0, 0));
    EXPECT_EQ(found.parts[1].pose.translation(), Vector3d(110, 0, 0));
    EXPECT_TRUE(found.parts[1].pose.linear().isApprox(Vector3d(-1, -1, 1).asDiagonal().toDenseMatrix(), 1e-12));
    EXPECT_EQ(found.parts[2].pose.translation(), Vector3d(100, 20, 0));
    EXPECT_EQ(found.parts[2].name, "box");
    const Mesh whole = load_mesh(folder_.path() / "a.gltf");
    EXPECT_EQ(whole.triangles.size(), 36u);
    EXPECT_EQ(whole.bounds.max, Vector3d(111, 22, 3));
}

TEST_F(GltfShape, InstancesAreScaledBeforeTheirNode)
{
    file_["nodes"][0]["scale"] = {2, 1, 1};
    instances({{"SCALE", add_numbers<float>(5126, "VEC3", 3, {1, 1, 1, 1, 1, 5})}});
    const Assembly found = load_assembly(write());
    ASSERT_EQ(found.parts.size(), 2u);
    EXPECT_EQ(load_mesh(folder_.path() / "a.gltf").bounds.max, Vector3d(2, 2, 15));
}

TEST_F(GltfShape, BadInstancesAreRefusedWithTheirPlace)
{
    const auto refuse = [&](std::string_view part) {
        const auto path = write();
        expect_error(
            ErrorKind::bad_data, [&] { load_mesh(path); }, "a.gltf: ", part);
    };
    const int three = add_numbers<float>(5126, "VEC3", 3, {0, 0, 0, 1, 0, 0, 2, 0, 0});
    instances({{"TRANSLATION", three}, {"SCALE", add_numbers<float>(5126, "VEC3", 3, {1, 1, 1})}});
    refuse("attributes.SCALE: has 1 instances, another attribute 3");
    instances({{"TRANSLATION", 0}});
    refuse("an accessor of instances is not made of three floats");
    instances({{"TRANSLATION", 99}});
    refuse("attributes.TRANSLATION: there is no accessors[99]");
    instances({{"ROTATION", add_numbers<float>(5126, "VEC4", 4, {0, 0, 0, 0})}});
    refuse("quaternion 0 has no direction");
    file_["nodes"][0]["extensions"]["EXT_mesh_gpu_instancing"] = json::object();
    refuse("the key 'attributes' is missing");
}

TEST_F(GltfShape, InstancesThatNoBytesHoldAreBounded)
{
    file_["accessors"].push_back({{"componentType", 5126}, {"count", 4'000'000'000}, {"type", "VEC3"}});
    file_["accessors"].back()["sparse"] = {
        {"count", 0}, {"indices", {{"bufferView", 0}, {"componentType", 5125}}}, {"values", {{"bufferView", 1}}}};
    instances({{"TRANSLATION", 2}});
    const auto path = write();
    expect_error(
        ErrorKind::bad_data, [&] { load_assembly(path); }, "a.gltf: ", "its instances make 4000000000 parts or more",
        "the limit is 100000");
    expect_error(
        ErrorKind::bad_data, [&] { load_mesh(path); }, "a.gltf: ");
}

TEST_F(GltfShape, MorphTargetsDisplaceTheMeshByTheirDefaultWeights)
{
    // The first target moves all vertices by (0, 0, 10), the second by (1, 0, 0).
    std::vector<float> up, right;
    for (std::size_t i = 0; i < box_.vertices.size(); ++i)
        up.insert(up.end(), {0, 0, 10}), right.insert(right.end(), {1, 0, 0});
    json& mesh = file_["meshes"][0];
    mesh["primitives"][0]["targets"] =
        json::array({{{"POSITION", add_numbers(5126, "VEC3", 3, up)}},
                     {{"POSITION", add_numbers(5126, "VEC3", 3, right)}, {"NORMAL", 0}}});
    EXPECT_EQ(load_mesh(write()).bounds.max, Vector3d(1, 2, 3)) << "without weights nothing moves";
    mesh["weights"] = {1, 0};
    EXPECT_EQ(load_mesh(write()).bounds.max, Vector3d(1, 2, 13));
    file_["nodes"].push_back({{"mesh", 0}, {"weights", {0.5, 2}}});
    file_["nodes"].push_back({{"mesh", 0}, {"translation", {50, 0, 0}}});
    const Assembly found = load_assembly(write());
    ASSERT_EQ(found.parts.size(), 3u);
    EXPECT_EQ(found.meshes.size(), 2u) << "one for each set of weights";
    const auto most = [&](std::size_t i) {
        const Mesh& shape = std::get<Mesh>(found.meshes[found.parts[i].mesh]->data);
        return Vector3d(found.parts[i].pose * shape.bounds.max);
    };
    EXPECT_EQ(most(0), Vector3d(1, 2, 13));
    EXPECT_EQ(most(1), Vector3d(3, 2, 8)) << "a node's own weights replace the mesh's";
    EXPECT_EQ(most(2), Vector3d(51, 2, 13));
    mesh["weights"] = {1};
    expect_error(
        ErrorKind::bad_data, [path = write()] { load_mesh(path); },
        "meshes[0].primitives[0].targets: has 2 morph targets; there are 1 weights");
    EXPECT_TRUE(warnings.empty()) << warnings.front();
}

TEST_F(GltfShape, SkinsAreWarnedOf)
{
    file_["skins"] = json::array({{{"joints", {0}}}});
    file_["nodes"][0]["skin"] = 0;
    const auto path = write();
    EXPECT_EQ(load_assembly(path).parts.size(), 1u);
    ASSERT_EQ(warnings.size(), 1u);
    EXPECT_EQ(warnings[0], path.string() +
                               ": 1 node has a skin, which is not applied: the mesh stands as it is stored, "
                               "at the node's pose");
    on_file_warning(nullptr);
    EXPECT_EQ(load_mesh(path).triangles.size(), 12u) << "warnings that no one wants are dropped";
}

} // namespace
} // namespace oncollide
