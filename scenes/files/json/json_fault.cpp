#include <oncollide/scenes/files/json/json_fault.hpp>

#include <algorithm>
#include <set>
#include <vector>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <oncollide/base/error.hpp>
#include <oncollide/scenes/files/json/json_tape.hpp>

namespace oncollide {

namespace {

using Json = nlohmann::json;

/// nlohmann's message without its prefix `[json.exception.parse_error.101] `.
std::string plain(const std::exception& error)
{
    const std::string text = error.what();
    const std::size_t end = text.find("] ");
    return text.front() == '[' && end != std::string::npos ? text.substr(end + 2) : text;
}

/// Follows nlohmann's parser: tracks its position and the keys of the open objects.
class Watcher final : public nlohmann::json_sax<Json> {
public:
    explicit Watcher(const std::string& file) : file_(file) {}

    bool null() override { return element(); }
    bool boolean(bool) override { return element(); }
    bool number_integer(std::int64_t) override { return element(); }
    bool number_unsigned(std::uint64_t) override { return element(); }
    bool number_float(double, const std::string&) override { return element(); }
    bool string(std::string&) override { return element(); }
    bool binary(Json::binary_t&) override { return element(); }
    bool start_object(std::size_t) override { return open(false); }
    bool start_array(std::size_t) override { return open(true); }
    bool end_object() override { return open_.pop_back(), true; }
    bool end_array() override { return open_.pop_back(), true; }
    bool key(std::string& key) override
    {
        Level& level = open_.back();
        if (!level.keys.insert(key).second) fail(fmt::format("the key '{}' is given twice", key));
        level.key = key;
        return true;
    }
    bool parse_error(std::size_t, const std::string&, const nlohmann::detail::exception& error) override
    {
        if (dynamic_cast<const Json::out_of_range*>(&error)) fail(plain(error));
        std::string why = plain(error);
        // Text of another kind of file is not quoted, because a link may lead to any file.
        if (open_.empty()) why.erase(std::min(why.find("; last read"), why.size()));
        throw Error(ErrorKind::bad_data, fmt::format("{}: not valid JSON: {}", file_, why));
    }

private:
    struct Level {
        bool is_array;
        std::size_t elements = 0; ///< number of elements begun
        std::string key{};        ///< the last key
        std::set<std::string> keys{};
    };

    bool element()
    {
        if (!open_.empty()) ++open_.back().elements;
        return true;
    }

    bool open(bool is_array)
    {
        if (open_.size() >= most_json_levels) fail(fmt::format("nested deeper than {} levels", most_json_levels));
        element();
        open_.push_back({.is_array = is_array});
        return true;
    }

    [[noreturn]] void fail(const std::string& what) const
    {
        std::string place;
        for (const Level& level : open_) {
            if (level.is_array) // the error may be in an array before the next element begins
                place += fmt::format("[{}]", &level == &open_.back() ? level.elements : level.elements - 1);
            else if (!level.key.empty())
                place += (place.empty() ? "" : ".") + level.key;
        }
        throw Error(ErrorKind::bad_data, fmt::format("{}: {}{}{}", file_, place, place.empty() ? "" : ": ", what));
    }

    const std::string& file_;
    std::vector<Level> open_;
};

} // namespace

void explain_json(const std::string& file, std::string_view text, const char* where)
{
    Watcher watcher(file);
    Json::sax_parse(text.begin(), text.end(), &watcher);
    throw Error(ErrorKind::bad_data, fmt::format("{}: not valid JSON: byte {}", file, where - text.data() + 1));
}

} // namespace oncollide
