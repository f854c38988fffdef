#pragma once
#include <fstream>
#include <iterator>
#include <string>

#include <gtest/gtest.h>

#include "load_with_samples.hpp"
#include "scenes/same_scene.hpp"
#include "scenes/test_files.hpp"

namespace oncollide::scene_file_test {

using Eigen::Vector3d;
using test::expect_error;

class SceneFile : public testing::Test {
protected:
    Scene load(const std::string& content) { return test::load_with_samples(folder_.write("scene.json", content)); }

    /// A scene with the geometry "ball", and one body with these members.
    Scene load_body(const std::string& members)
    {
        return load(R"({"geometries": {"ball": {"shape": {"kind": "sphere", "radius": 1}}}, "bodies": [{)" + members +
                    "}]}");
    }
    Scene load_geometry(const std::string& entry)
    {
        return load(R"({"geometries": {"thing": )" + entry + R"(}, "bodies": [{"name": "a", "geometry": "thing"}]})");
    }

    template <class... Parts>
    void refuses(const std::string& content, Parts... parts)
    {
        SCOPED_TRACE(content.substr(0, 200));
        expect_error(
            ErrorKind::bad_data, [&] { load(content); }, "scene.json: ", parts...);
    }
    template <class... Parts>
    void refuses_body(const std::string& members, Parts... parts)
    {
        SCOPED_TRACE(members);
        expect_error(
            ErrorKind::bad_data, [&] { load_body(members); }, "scene.json: bodies[0]", parts...);
    }
    template <class... Parts>
    void refuses_geometry(const std::string& entry, Parts... parts)
    {
        SCOPED_TRACE(entry);
        expect_error(
            ErrorKind::bad_data, [&] { load_geometry(entry); }, "scene.json: geometries.thing", parts...);
    }

    std::string content_of(const std::string& name) const
    {
        std::ifstream in(folder_.path() / name);
        return {std::istreambuf_iterator<char>(in), {}};
    }

    test::TemporaryFolder folder_;
};

inline const std::string ball = R"("name": "a", "geometry": "ball")";

} // namespace oncollide::scene_file_test
