#include <oncollide/base/numbers/random.hpp>
#include <oncollide/scenes/files/json/json_tape.hpp>

#include <optional>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <oncollide/base/error.hpp>
#include <oncollide/scenes/files/json/json_fault.hpp>
#include <oncollide/scenes/motion.hpp>

namespace oncollide {
namespace {

using nlohmann::json;

/// The value at `i` with its contents.
json tree_of(const JsonTape& tape, std::uint32_t i = 0)
{
    using Kind = JsonValue::Kind;
    const std::vector<JsonValue>& values = tape.values();
    const JsonValue& value = values[i];
    json tree;
    switch (value.kind) {
    case Kind::null:
        return nullptr;
    case Kind::boolean:
        return value.truth;
    case Kind::natural:
        return value.natural;
    case Kind::negative:
        return value.negative;
    case Kind::real:
        return value.real;
    case Kind::text:
        return std::string(value.as_text());
    case Kind::array:
        tree = json::array();
        for (std::uint32_t k = i + 1; k != value.end; k = values[k].end) tree.push_back(tree_of(tape, k));
        break;
    case Kind::object:
        tree = json::object();
        for (std::uint32_t k = i + 1; k != value.end; k = values[k + 1].end)
            tree[std::string(values[k].as_text())] = tree_of(tape, k + 1);
    }
    if (value.end > i + 1) { // else it may have been skipped
        EXPECT_EQ(tree.size(), value.size);
    }
    return tree;
}

/// The parsed value of the text, or nothing if it is refused.
std::optional<json> meaning(const std::string& text)
{
    JsonTape tape;
    try {
        if (tape.read(text, 0) != text.data() + text.size()) return std::nullopt;
        return tree_of(tape);
    } catch (const JsonFault&) {
        return std::nullopt;
    }
}

/// The same if the array "bodies" is read element by element.
std::optional<json> meaning_in_pieces(const std::string& text)
{
    JsonTape rest, element;
    try {
        if (rest.read(text, 0, "bodies") != text.data() + text.size()) return std::nullopt;
        const std::vector<JsonValue>& values = rest.values();
        json tree = tree_of(rest);
        if (!tree.is_object()) return tree;
        for (std::uint32_t k = 1; k != values[0].end; k = values[k + 1].end) {
            if (values[k].as_text() != "bodies" || values[k + 1].kind != JsonValue::Kind::array) continue;
            json list = json::array();
            each_element(values[k + 1].source_text(), 1, element,
                         [&](const JsonTape& tape) { list.push_back(tree_of(tape)); });
            EXPECT_EQ(list.size(), values[k + 1].size) << text;
            tree["bodies"] = list;
        }
        return tree;
    } catch (const JsonFault&) {
        return std::nullopt;
    }
}

std::string changed(std::string text, std::uint64_t round)
{
    constexpr std::string_view alphabet = "{}[]\",:0123456789.eE+-\\ \n\tutrfalsn\x01\x7f\xc3\xa9\xf0k1";
    std::uint64_t k = 0;
    const auto draw = [&](std::size_t below) { return static_cast<std::size_t>(u01(7, round, k++) * double(below)); };
    for (std::size_t changes = draw(4); changes > 0 && !text.empty(); --changes) {
        const std::size_t at = draw(text.size());
        const char c = alphabet[draw(alphabet.size())];
        switch (draw(4)) {
        case 0:
            text[at] = c;
            break;
        case 1:
            text.insert(at, 1, c);
            break;
        case 2:
            text.erase(at, 1 + draw(3));
            break;
        default:
            text.insert(at, text.substr(draw(text.size()), draw(20)));
        }
    }
    return text;
}

TEST(JsonTape, ReadsAndRefusesWhatAnotherParserDoes)
{
    const std::string seeds[] = {
        R"({"name": "x", "n": 5, "list": {"a": [[0, 0.5, -0], [1e3, 0, 0], []]}, "bodies": [{"name": "a\n\u00e9",
            "at": [1, 2, 3e-7]}, {"n": [true, false, null, [], {}, ""]}], "exclude": [["a", 3]]})",
        R"([18446744073709551615, 18446744073709551616, -9223372036854775808, -9223372036854775809, 1e308, 1e309, 0.1,
            -0.0, 5e-324, 1e-999, "\ud83d\ude00\\\"\/\b\f\n\r\t"])",
        R"({"bodies": [{"a": [1]}, {"b": "]}"}], "a": {"b": {"c": 1, "d": 2}}, "k1": 1, "k2": 2, "k3": 3, "k4": 1, "k5": 1,
            "k6": 1, "k7": 1, "k8": 1, "k9": 1, "k10": 1, "k11": 1, "k12": 1, "k13": 1, "k14": 1, "k15": 1, "k16": 1})"};
    int valid = 0;
    for (std::uint64_t round = 0; round < 30'000; ++round) {
        const std::string text = changed(seeds[round % 3], round);
        const std::optional<json> mine = meaning(text), pieces = meaning_in_pieces(text);
        ASSERT_EQ(mine.has_value(), pieces.has_value()) << text;
        if (mine) {
            ++valid;
            const json theirs = json::parse(text);
            ASSERT_EQ(mine->dump(), theirs.dump());
            ASSERT_EQ(pieces->dump(), theirs.dump());
            continue;
        }
        // The other parser knows the reason, so the message is not only the place where reading stopped.
        try {
            explain_json("file", text, text.data());
        } catch (const Error& error) {
            ASSERT_EQ(std::string(error.what()).find("not valid JSON: byte"), std::string::npos) << text;
        }
    }
    EXPECT_GT(valid, 5000);
}

} // namespace
} // namespace oncollide
