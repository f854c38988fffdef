#pragma once
#include <cmath>
#include <string>

#include <fmt/format.h>
#include <yaml-cpp/yaml.h>

#include <oncollide/base/error.hpp>
#include <oncollide/base/files/file_bytes.hpp>
#include <oncollide/base/text/printable.hpp>

namespace oncollide::tools {

/// A YAML file whose faults name the line. Only for sources that are built with yaml-cpp.
class YamlFile {
public:
    /// Calls work(file). Throws Error{no_input} and Error{bad_data}, also for faults that yaml-cpp finds in `work`.
    template <class Work>
    static void read(const std::string& path, Work work)
    {
        const std::string text = read_file(path, std::uintmax_t{64} << 20);
        try {
            work(YamlFile(path, YAML::Load(text)));
        } catch (const YAML::Exception& fault) {
            refuse_at(path, fault.mark, printable(fault.msg));
        }
    }

    const std::string& path() const { return path_; }
    const YAML::Node& root() const { return root_; }
    [[noreturn]] void fail(const YAML::Node& node, const std::string& what) const
    {
        refuse_at(path_, node ? node.Mark() : YAML::Mark::null_mark(), what);
    }
    double number(const YAML::Node& node, const char* what) const
    {
        const double value = node && node.IsScalar() ? node.as<double>(std::nan("")) : std::nan("");
        if (!std::isfinite(value)) fail(node, fmt::format("{} is not a finite number", what));
        return value;
    }
    std::string text(const YAML::Node& node, const char* what) const
    {
        if (!node || !node.IsScalar()) fail(node, fmt::format("{} is missing", what));
        return node.as<std::string>();
    }
    YAML::Node list(const YAML::Node& node, const char* what) const
    {
        if (!node || !node.IsSequence()) fail(node, fmt::format("{} must be a list", what));
        return node;
    }

private:
    YamlFile(const std::string& path, YAML::Node root) : path_(path), root_(std::move(root)) {}
    [[noreturn]] static void refuse_at(const std::string& path, const YAML::Mark& mark, const std::string& what)
    {
        refuse(path, mark.is_null() ? what : fmt::format("line {}: {}", mark.line + 1, what));
    }

    std::string path_;
    YAML::Node root_;
};

} // namespace oncollide::tools
