#pragma once
#include "tools/command_fixture.hpp"

namespace oncollide::test {

inline std::size_t count_of(const std::string& text, const std::string& word)
{
    std::size_t count = 0;
    for (std::size_t at = text.find(word); at != std::string::npos; at = text.find(word, at + 1)) ++count;
    return count;
}

class Study : public CommandLine {
protected:
    /// Three cubes of side 1, rotated so that their AABBs overlap: 'a' and 'c' collide; 'b' is 0.05, 0.04 and 0.03 m
    /// from both.
    void SetUp() override
    {
        const double s = std::sqrt(0.5);
        const auto cube = [](const std::string& name, double x, double y, const std::string& motion) {
            return fmt::format(R"({{"name": "{}", "geometry": "cube", "position": [{}, {}, 0], "rotation":
                [0, 0, 0.38268343236508977, 0.92387953251128674]{}}})",
                               name, x, y, motion);
        };
        const std::string drift = fmt::format(R"(, "motion": {{"drift": {{"velocity": [{0}, {0}, 0]}}}})", -0.01 * s);
        folder_.write("cubes.json",
                      fmt::format(R"({{"frames": 3, "geometries": {{"cube": {{"mesh": {{"generate": {{"kind": "box",
                      "half": [0.5, 0.5, 0.5]}}}}}}}}, "bodies": [{}, {}, {}]}})",
                                  cube("a", 0, 0, ""), cube("b <&>", 1.05 * s, 1.05 * s, drift),
                                  cube("c", -0.9 * s, 0.9 * s, "")));
    }

    nlohmann::json study(std::vector<std::string> arguments, int code = 0)
    {
        arguments.insert(arguments.begin(), command_.begin(), command_.end());
        arguments.insert(arguments.end(), {"--json", "s.json"});
        const Outcome outcome = run(arguments);
        EXPECT_EQ(outcome.code, code) << outcome.out << outcome.err;
        return read_json("s.json");
    }

    std::vector<std::string> command_{"accuracy", "study"};

    static nlohmann::json variant(const nlohmann::json& study, const std::string& name)
    {
        for (const nlohmann::json& row : study["variants"])
            if (row["variant"] == name) return row;
        ADD_FAILURE() << "no variant " << name << " in " << study["variants"];
        return {};
    }

    static nlohmann::json peer(const nlohmann::json& study, const std::string& name)
    {
        for (const nlohmann::json& row : study["peers"])
            if (row["name"] == name) return row;
        return {};
    }
};

} // namespace oncollide::test
