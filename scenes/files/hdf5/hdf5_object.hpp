#pragma once
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include <oncollide/scenes/files/hdf5/hdf5_bytes.hpp>

namespace oncollide {

// Headers of HDF5 objects (groups, datasets, named types), as lists of messages. Private to scenes.

enum class Hdf5MessageType : std::uint16_t {
    nothing = 0x00,
    dataspace = 0x01,
    link_info = 0x02,
    datatype = 0x03,
    old_fill_value = 0x04,
    fill_value = 0x05,
    link = 0x06,
    external_files = 0x07,
    layout = 0x08,
    filters = 0x0b,
    attribute = 0x0c,
    continuation = 0x10,
    symbol_table = 0x11,
    attribute_info = 0x15,
    last_known = 0x18
};

struct Hdf5Message {
    Hdf5MessageType type;
    bool is_shared; ///< the block holds the place of the message
    Hdf5Block block;
};

class Hdf5Object {
public:
    Hdf5Object(Hdf5Walk& walk, std::uint64_t address);

    std::uint64_t address() const { return address_; }
    const std::vector<Hdf5Message>& messages() const { return messages_; }
    /// Null if there is none.
    const Hdf5Message* find(Hdf5MessageType type) const;

private:
    struct Piece {
        std::uint64_t address, size;
    };
    void read_old(Hdf5Walk& walk);
    void read_new(Hdf5Walk& walk);
    /// @param header_bytes  the size of each message's header
    void add_messages(Hdf5Cursor cursor, unsigned header_bytes);

    std::uint64_t address_;
    std::vector<Hdf5Message> messages_;
    std::vector<Piece> pieces_; ///< continuations that were not read yet
};

/// The content of a message, which may be in the header of a named type.
Hdf5Block hdf5_content(Hdf5Walk& walk, const Hdf5Message& message);
Hdf5Block hdf5_content(Hdf5Walk& walk, Hdf5Cursor shared, Hdf5MessageType type);

} // namespace oncollide
