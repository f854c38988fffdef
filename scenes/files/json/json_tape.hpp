#pragma once
#include <cstdint>
#include <deque>
#include <string>
#include <string_view>
#include <unordered_set>
#include <vector>

namespace oncollide {

// Strict JSON (RFC 8259), read into a flat list of values that is reused for the next text: a scene's bodies are read
// one at a time, without a tree of all bodies. Private to scenes.

constexpr std::uint32_t most_json_levels = 32; ///< nesting of objects and arrays

/// The text is not JSON, has a number too large for a double or a duplicate key, or is nested too deeply. explain_json
/// finds the place and the reason.
struct JsonFault {
    const char* where;
};

/// A value on the tape. The value's contents follow it: elements, or each member's key (a text) and then its value.
struct JsonValue {
    enum class Kind : std::uint8_t { null, boolean, natural, negative, real, text, array, object };

    Kind kind;
    std::uint32_t parent; ///< 0 for the root
    std::uint32_t end;    ///< index of the first value after this one and its contents
    std::uint32_t length; ///< bytes of its source
    const char* source;
    union {
        bool truth;
        std::uint64_t natural;
        std::int64_t negative; ///< an integer with a minus sign
        double real;
        std::uint64_t size; ///< elements or members
        struct {
            const char* data;
            std::size_t size;
        } text; ///< escapes decoded
    };

    bool is_number() const { return kind == Kind::natural || kind == Kind::negative || kind == Kind::real; }
    double as_number() const ///< the value of a number
    {
        return kind == Kind::real      ? real
               : kind == Kind::natural ? static_cast<double>(natural)
                                       : static_cast<double>(negative);
    }
    std::string_view source_text() const { return {source, length}; }
    std::string_view as_text() const { return {text.data, text.size}; }
};

/// Origin of the root of a tape: the whole of `file`, or element `number` of its list `list`.
struct JsonPlace {
    std::string_view file{};
    std::string_view list{}; ///< "bodies"; empty: the whole file
    std::size_t number = 0;
};

inline bool is_json_blank(char c)
{
    return c == ' ' || c == '\n' || c == '\r' || c == '\t';
}

class JsonTape {
public:
    JsonTape() = default;
    explicit JsonTape(const JsonPlace& stands_at) : place(stands_at) {}

    /// Reads the value at the beginning of `text`, after blanks, replacing the previous contents; returns the rest
    /// after blanks. `text` must stay valid. Throws JsonFault.
    /// @param level    number of objects and arrays around the value
    /// @param unread   the array of this name in the root object is skipped: the tape has its size and position, but
    ///                 its elements are neither checked nor on the tape
    const char* read(std::string_view text, std::uint32_t level, std::string_view unread = {});

    const std::vector<JsonValue>& values() const { return values_; }

    JsonPlace place; ///< for messages

private:
    void read_value(std::uint32_t parent, std::uint32_t level);
    void read_array(std::uint32_t at, std::uint32_t level);
    void read_object(std::uint32_t at, std::uint32_t level);
    void check_new(std::uint32_t object, std::uint32_t key, std::unordered_set<std::string_view>& keys);
    void skip_array(JsonValue& array);
    void read_text(JsonValue& value);
    void read_number(JsonValue& value);
    void read_word(JsonValue& value, std::string_view word);
    void skip_blanks();
    bool take(char c); ///< also skips the blanks after it
    [[noreturn]] void fail() const { throw JsonFault{at_}; }

    std::vector<JsonValue> values_;
    std::deque<std::string> decoded_; ///< texts with escapes
    std::string_view unread_;
    const char *at_ = nullptr, *end_ = nullptr;
};

/// Calls visit(tape) for each element of `array`, the source of an array that is inside `level` objects and arrays;
/// `tape` then holds the element, and its place has the element's number. Throws JsonFault.
template <class Visit>
void each_element(std::string_view array, std::uint32_t level, JsonTape& tape, Visit visit)
{
    const char* const end = array.data() + array.size();
    const auto rest = [&](const char* at) { return std::string_view(at, static_cast<std::size_t>(end - at)); };
    const char* at = array.data() + 1;
    while (at != end && is_json_blank(*at)) ++at;
    if (at + 1 == end && *at == ']') return;
    for (tape.place.number = 0;; ++tape.place.number) {
        at = tape.read(rest(at), level + 1);
        visit(tape);
        if (at == end || (*at != ',' && *at != ']')) throw JsonFault{at};
        if (*at++ == ']') break;
    }
    if (at != end) throw JsonFault{at};
}

} // namespace oncollide
