#pragma once
#include <concepts>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include <oncollide/base/text/number_text.hpp>
#include <oncollide/base/text_sink.hpp>

namespace oncollide {

/// `text` as a JSON string with its quotes. Bytes that are not UTF-8 become U+FFFD.
std::string json_string(std::string_view text);

/// JSON text, which is written unchanged.
struct JsonText {
    std::string_view text;
};

/// Writes JSON element by element: it writes commas, colons and escapes, and the caller ends objects and arrays.
/// Numbers are the shortest text that reads back as the same value; infinities and NaN become null.
class JsonWriter {
public:
    explicit JsonWriter(TextSink& out) : out_(&out) {}
    /// Writes further elements of an array or object that another writer has begun and put elements into.
    static JsonWriter within(TextSink& out)
    {
        JsonWriter json(out);
        json.comma_ = true;
        return json;
    }

    void begin_object() { begin('{'); }
    void end_object() { end('}'); }
    void begin_array() { begin('['); }
    void end_array() { end(']'); }
    /// The next element or closing bracket begins a line, after `indent` blanks.
    void line(int indent = 0) { indent_ = indent; }

    /// In an object: the name of the next value.
    void key(std::string_view name) { raw_key(json_string(name)); }
    /// Names and values in turn.
    template <class Value, class... More>
    void members(std::string_view name, const Value& v, const More&... more)
    {
        key(name), value(v);
        if constexpr (sizeof...(more) > 0) members(more...);
    }
    template <class... NamesAndValues>
    void object(const NamesAndValues&... parts)
    {
        begin_object(), members(parts...), end_object();
    }
    template <class... Values>
    void array(const Values&... values)
    {
        begin_array(), (value(values), ...), end_array();
    }

    void value(std::string_view text) { raw(json_string(text)); }
    void value(const std::string& text) { raw(json_string(text)); }
    void value(const char* text) { raw(json_string(text)); }
    void value(bool b) { raw(b ? "true" : "false"); }
    void value(double x);
    void value(Fixed x);
    void value(Hex x);
    void value(std::nullptr_t) { raw("null"); }
    void value(JsonText json) { raw(json.text); }
    /// Calls `write`, which writes one value.
    void value(const std::invocable auto& write) { write(); }
    template <std::integral Integer>
    void value(Integer x)
    {
        raw(std::string_view(fmt::format_int(x).c_str()));
    }
    template <class Value>
    void value(const std::optional<Value>& v)
    {
        v ? value(*v) : value(nullptr);
    }
    /// These take JSON text and write it unchanged.
    void raw(std::string_view json) { separate(), out_->write(json); }
    void raw_key(std::string_view json)
    {
        raw(json), out_->write(": ");
        comma_ = false;
    }

    /// The first members of a JSON file: the name and version of its format. docs/stability.md lists them.
    void schema(std::string_view name, int schema_version)
    {
        members("schema", name, "schema_version", schema_version);
    }

private:
    void begin(char bracket)
    {
        separate(), out_->write({&bracket, 1});
        comma_ = false;
    }
    void end(char bracket)
    {
        comma_ = false, separate(), out_->write({&bracket, 1});
        comma_ = true;
    }
    void separate();

    TextSink* out_;
    bool comma_ = false; ///< true if a comma comes before the next element
    int indent_ = -1;    ///< blanks before the line that the next element begins; -1: it begins no line
};

} // namespace oncollide
