#pragma once
#include <cstddef>
#include <cstring>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include <oncollide/base/error.hpp>

namespace oncollide {

/// A message between processes.
using Bytes = std::vector<std::byte>;

/// Appends the bytes of a value: all processes run the same program.
template <class Value>
requires std::is_trivially_copyable_v<Value>
void put(Bytes& bytes, const Value& value)
{
    const auto* const from = reinterpret_cast<const std::byte*>(&value);
    bytes.resize(bytes.size() + sizeof(Value));
    std::memcpy(bytes.data() + bytes.size() - sizeof(Value), from, sizeof(Value));
}
/// Appends the length of a string or vector and its elements.
template <class List>
void put_list(Bytes& bytes, const List& list)
{
    put(bytes, static_cast<std::uint32_t>(list.size()));
    const auto* from = reinterpret_cast<const std::byte*>(list.data());
    bytes.insert(bytes.end(), from, from + list.size() * sizeof(list[0]));
}

/// Reads the values that put() wrote, in the same order.
class ByteReader {
public:
    explicit ByteReader(const Bytes& bytes) : at_(bytes.data()), end_(bytes.data() + bytes.size()) {}

    bool at_end() const { return at_ == end_; }
    template <class Value>
    Value get()
    {
        Value value;
        std::memcpy(static_cast<void*>(&value), take(sizeof(Value)), sizeof(Value));
        return value;
    }
    template <class List>
    List get_list()
    {
        List list;
        list.resize(get<std::uint32_t>());
        const std::size_t bytes = list.size() * sizeof(list[0]);
        if (bytes) std::memcpy(static_cast<void*>(list.data()), take(bytes), bytes);
        return list;
    }

private:
    const std::byte* take(std::size_t bytes)
    {
        if (bytes > static_cast<std::size_t>(end_ - at_))
            throw Error(ErrorKind::internal, "a message from another process is truncated");
        return std::exchange(at_, at_ + bytes);
    }

    const std::byte *at_, *end_;
};

} // namespace oncollide
