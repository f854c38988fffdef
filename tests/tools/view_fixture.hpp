#pragma once
#include "tools/command_fixture.hpp"

#include <cmath>
#include <cstring>

namespace oncollide::test {

inline const char* const three = "/usr/share/javascript/three/three.min.js";

inline std::string decoded_base64(std::string_view text)
{
    constexpr std::string_view digits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    std::string bytes;
    unsigned group = 0, bits = 0;
    for (const char c : text) {
        if (c == '=') break;
        group = group << 6 | unsigned(digits.find(c)), bits += 6;
        if (bits >= 8) bits -= 8, bytes += char(group >> bits & 255);
    }
    return bytes;
}

class View : public CommandLine {
protected:
    /// Two spheres of radius 0.5, the second moving by -0.1 m per frame, initially `distance` away.
    void write_scene(const std::string& name, double distance, const std::string& second = "other")
    {
        const nlohmann::json body = second;
        folder_.write(name, fmt::format(R"({{"frames": 8, "geometries": {{"ball": {{"mesh": {{"generate":
            {{"kind": "sphere", "radius": 0.5, "triangles": 512}}}}}}}},
            "bodies": [{{"name": "one", "geometry": "ball", "static": true}}, {{"name": {}, "geometry": "ball",
            "position": [{}, 0.1, 0.05], "motion": {{"drift": {{"velocity": [-0.1, 0, 0]}}}}}}]}})",
                                        body.dump(), distance));
    }

    /// Runs with a mock of three.js, so that tests of the page's contents do not need three.js.
    void write_stand_in()
    {
        const std::filesystem::path controls = "lib/examples/js/controls";
        std::filesystem::create_directories(folder_.path() / controls);
        folder_.write("lib/three.min.js", "/* three </script> */");
        folder_.write(controls / "OrbitControls.js", "/* controls */");
    }
    Outcome run_without_three(std::vector<std::string> arguments)
    {
        write_stand_in();
        Surroundings around;
        around.environment.emplace_back("ONCOLLIDE_THREE", (folder_.path() / "lib").string());
        return run(std::move(arguments), around);
    }

    /// The contents of the element of that id.
    std::string block(const std::string& id, const std::string& file = "x.html")
    {
        const std::string page = folder_.read(file), mark = "id=\"" + id + "\">";
        const std::size_t from = page.find(mark);
        if (from == std::string::npos) return ADD_FAILURE() << "no " << id, "";
        return page.substr(from + mark.size(), page.find("</script>", from) - from - mark.size());
    }
    nlohmann::json header(const std::string& file = "x.html") { return nlohmann::json::parse(block("header", file)); }
    std::vector<float> floats(const std::string& id, std::size_t first, std::size_t count)
    {
        const std::string bytes = decoded_base64(block(id));
        std::vector<float> numbers(count);
        EXPECT_GE(bytes.size(), 4 * (first + count)) << id;
        if (bytes.size() >= 4 * (first + count)) std::memcpy(numbers.data(), bytes.data() + 4 * first, 4 * count);
        return numbers;
    }
};

} // namespace oncollide::test
