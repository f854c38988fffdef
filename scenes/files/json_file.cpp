#include <oncollide/scenes/files/json_file.hpp>

#include <algorithm>
#include <limits>
#include <set>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <oncollide/base/error.hpp>

namespace oncollide {

namespace {

constexpr int most_levels = 32;

/// Follows the parser: where it stands, and which keys the open objects have had.
class Watcher {
public:
    explicit Watcher(const std::string& file) : file_(file) {}

    bool operator()(int depth, Json::parse_event_t event, Json& value)
    {
        using Event = Json::parse_event_t;
        switch (event) {
        case Event::object_start:
        case Event::array_start:
            if (depth >= most_levels) fail(fmt::format("nested deeper than {} levels", most_levels));
            if (!open_.empty()) ++open_.back().elements;
            open_.push_back({.is_array = event == Event::array_start});
            break;
        case Event::object_end:
        case Event::array_end:
            open_.pop_back();
            break;
        case Event::key:
            take_key(value.get_ref<const std::string&>());
            break;
        case Event::value:
            if (!open_.empty()) ++open_.back().elements;
            break;
        }
        return true;
    }

    [[noreturn]] void fail(const std::string& what) const
    {
        std::string place;
        for (const Level& level : open_) {
            if (level.is_array) // the innermost array fails before an element has begun
                place += fmt::format("[{}]", &level == &open_.back() ? level.elements : level.elements - 1);
            else if (!level.key.empty())
                place += (place.empty() ? "" : ".") + level.key;
        }
        throw Error(ErrorKind::bad_data, fmt::format("{}: {}{}{}", file_, place, place.empty() ? "" : ": ", what));
    }

    std::vector<std::string> geometries;

private:
    struct Level {
        bool is_array;
        std::size_t elements = 0; ///< begun so far
        std::string key{};        ///< the last one
        std::set<std::string> keys{};
    };

    void take_key(const std::string& key)
    {
        Level& level = open_.back();
        if (!level.keys.insert(key).second) fail(fmt::format("the key '{}' is given twice", key));
        level.key = key;
        if (open_.size() == 2 && open_[0].key == "geometries") geometries.push_back(key);
    }

    const std::string& file_;
    std::vector<Level> open_;
};

/// What nlohmann says, without its own prefix `[json.exception.parse_error.101] `.
std::string plain(const std::exception& error)
{
    const std::string text = error.what();
    const std::size_t end = text.find("] ");
    return text.front() == '[' && end != std::string::npos ? text.substr(end + 2) : text;
}

} // namespace

JsonFile parse_json(const std::string& file, const std::string& text)
{
    Watcher watcher(file);
    try {
        JsonFile result;
        result.root = Json::parse(text, std::ref(watcher));
        result.geometries = std::move(watcher.geometries);
        return result;
    } catch (const Json::out_of_range& error) {
        watcher.fail(plain(error));
    } catch (const Json::exception& error) {
        throw Error(ErrorKind::bad_data, fmt::format("{}: not valid JSON: {}", file, plain(error)));
    }
}

std::string Node::place() const
{
    return path_.empty() ? std::string(file_) : fmt::format("{}: {}", file_, path_);
}

void Node::fail(const std::string& what) const
{
    throw Error(ErrorKind::bad_data, fmt::format("{}: {}", place(), what));
}

Node Node::child(const Json& value, std::string_view key) const
{
    return {value, file_, path_.empty() ? std::string(key) : fmt::format("{}.{}", path_, key)};
}

void Node::must_be(bool right, std::string_view what) const
{
    if (!right)
        fail(fmt::format("is {} {}, must be {}", value_->is_array() || value_->is_object() ? "an" : "a",
                         value_->type_name(), what));
}

void Node::only(std::initializer_list<std::string_view> keys) const
{
    must_be(value_->is_object(), fmt::format("an object with keys among: {}", fmt::join(keys, ", ")));
    for (const auto& [key, value] : value_->items())
        if (std::find(keys.begin(), keys.end(), key) == keys.end())
            child(value, key).fail(fmt::format("unknown key; valid: {}", fmt::join(keys, ", ")));
}

std::string Node::one_of(std::initializer_list<std::string_view> keys) const
{
    only(keys);
    if (value_->size() != 1)
        fail(fmt::format("has {} keys, must have exactly one of: {}", value_->size(), fmt::join(keys, ", ")));
    return value_->begin().key();
}

bool Node::has(std::string_view key) const
{
    return value_->contains(key);
}

Node Node::operator[](std::string_view key) const
{
    const auto found = value_->find(key);
    if (found == value_->end()) fail(fmt::format("the key '{}' is missing", key));
    return child(*found, key);
}

Node Node::operator[](std::size_t i) const
{
    return {(*value_)[i], file_, fmt::format("{}[{}]", path_, i)};
}

std::size_t Node::size() const
{
    must_be(value_->is_array(), "an array");
    return value_->size();
}

double Node::number() const
{
    must_be(value_->is_number(), "a number");
    return value_->get<double>();
}

double Node::number(std::string_view key, double otherwise) const
{
    return has(key) ? (*this)[key].number() : otherwise;
}

double Node::positive(std::string_view key, double otherwise) const
{
    const double number = this->number(key, otherwise);
    if (has(key) && !(number > 0)) (*this)[key].fail(fmt::format("is {}, must be above 0", number));
    return number;
}

std::int64_t Node::integer(std::int64_t least, std::int64_t most) const
{
    const std::string range = fmt::format("a whole number from {} to {}", least, most);
    must_be(value_->is_number(), range);
    const bool fits = value_->is_number_integer() &&
                      !(value_->is_number_unsigned() &&
                        value_->get<std::uint64_t>() > std::uint64_t(std::numeric_limits<std::int64_t>::max()));
    if (!fits || value_->get<std::int64_t>() < least || value_->get<std::int64_t>() > most)
        fail(fmt::format("is {}, must be {}", value_->dump(), range));
    return value_->get<std::int64_t>();
}

std::uint64_t Node::natural() const
{
    constexpr std::string_view range = "a whole number from 0 to 2^64 - 1";
    must_be(value_->is_number(), range);
    if (!value_->is_number_unsigned()) fail(fmt::format("is {}, must be {}", value_->dump(), range));
    return value_->get<std::uint64_t>();
}

std::string Node::text() const
{
    must_be(value_->is_string(), "a text");
    return value_->get<std::string>();
}

bool Node::boolean() const
{
    must_be(value_->is_boolean(), "true or false");
    return value_->get<bool>();
}

Eigen::Vector3d Node::vector3() const
{
    Eigen::Vector3d v;
    numbers(3, v.data());
    return v;
}

void Node::numbers(std::size_t count, double* out) const
{
    const bool right = value_->is_array() && value_->size() == count &&
                       std::all_of(value_->begin(), value_->end(), [](const Json& v) { return v.is_number(); });
    if (!right) {
        std::string got = value_->dump();
        if (got.size() > 60) got = got.substr(0, 57) + "...";
        fail(fmt::format("is {}, must be an array of {} numbers", got, count));
    }
    for (std::size_t i = 0; i < count; ++i) out[i] = (*value_)[i].get<double>();
}

} // namespace oncollide
