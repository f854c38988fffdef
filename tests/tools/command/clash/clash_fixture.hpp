#pragma once
#include <set>

#include <Eigen/Core>

#include "tools/command_fixture.hpp"

namespace oncollide::test {

class ClashCommand : public CommandLine {
protected:
    /// A closed box as an OFF file.
    void write_box(const std::string& name, const Eigen::Vector3d& least, const Eigen::Vector3d& most)
    {
        std::string text = "OFF\n8 12 0\n";
        for (unsigned k = 0; k < 8; ++k)
            text += fmt::format("{} {} {}\n", (k & 1 ? most : least).x(), (k & 2 ? most : least).y(),
                                (k & 4 ? most : least).z());
        text += "3 0 2 1\n3 1 2 3\n3 4 5 6\n3 5 7 6\n3 0 1 4\n3 1 5 4\n3 2 6 3\n3 3 6 7\n3 0 4 2\n3 2 4 6\n3 1 3 5\n"
                "3 3 7 5\n";
        folder_.write(name, text);
    }
    /// Block a crosses b by 1, touches c, and is 0.5 from d; e is inside b, f far away.
    std::vector<std::string> small_assembly()
    {
        write_box("a.off", {0, 0, 0}, {10, 10, 10});
        write_box("b.off", {9, -5, -5}, {30, 15, 15});
        write_box("c.off", {2, 0, 10}, {7, 8, 20});
        write_box("d.off", {-10, 0, 0}, {-0.5, 10, 10});
        write_box("e.off", {15, 1, 1}, {20, 5, 5});
        write_box("f.off", {100, 0, 0}, {101, 1, 1});
        return {"a.off", "b.off", "c.off", "d.off", "e.off", "f.off"};
    }
    Outcome clash(std::vector<std::string> more)
    {
        std::vector<std::string> arguments{"clash"};
        if (files_.empty()) files_ = small_assembly();
        arguments.insert(arguments.end(), files_.begin(), files_.end());
        arguments.insert(arguments.end(), more.begin(), more.end());
        return run(arguments);
    }
    /// "a b crossing new" of each pair of a JSON report.
    std::set<std::string> pairs(const std::string& file)
    {
        std::set<std::string> found;
        const nlohmann::json report = read_json(file);
        for (const nlohmann::json& c : report["clashes"])
            found.insert(fmt::format("{} {} {} {}", c["a"]["name"].get<std::string>(),
                                     c["b"]["name"].get<std::string>(), c["kind"].get<std::string>(),
                                     c["status"].get<std::string>()));
        return found;
    }
    using Pairs = std::set<std::string>;

    std::vector<std::string> files_;
};

} // namespace oncollide::test
