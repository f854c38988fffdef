#pragma once
#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>

namespace oncollide {

// The bytes of an HDF5 file, and its superblock. Source of this folder: "HDF5 File Format Specification Version 3.0",
// The HDF Group. All numbers in a file are untrusted. Private to scenes.

constexpr std::uint64_t hdf5_nowhere = ~std::uint64_t{0}; ///< the address of data that the file does not have

/// Why a file cannot be read. Callers add the name of the file and of the object.
struct Hdf5Fault {
    std::string what;
};

/// Throws Hdf5Fault for a damaged structure.
[[noreturn]] void hdf5_damaged(std::uint64_t address, std::string_view what);
/// Throws Hdf5Fault for a feature of the format that is not read.
/// @param arguments  the arguments of h5repack, which rewrites the file without the feature
[[noreturn]] void hdf5_unread(std::string_view feature, std::string_view arguments = "");

/// An HDF5 file, open for reading. The file is never mapped, because truncating a mapped file ends the program.
class Hdf5Bytes {
public:
    enum class Access {
        alone,        ///< no other program writes it
        while_written ///< the writer may be running, or was killed ("SWMR")
    };
    /// Throws Hdf5Fault if it is not a complete HDF5 file or is being written.
    Hdf5Bytes(const std::filesystem::path& path, Access access);
    ~Hdf5Bytes();
    Hdf5Bytes(const Hdf5Bytes&) = delete;
    Hdf5Bytes& operator=(const Hdf5Bytes&) = delete;

    std::uint64_t size() const;                       ///< present size; it grows while the file is written
    bool is_written() const { return is_written_; }   ///< its writer has not closed it
    std::uint64_t root() const { return root_; }      ///< address of the root group's header
    unsigned offset_bytes() const { return offset_; } ///< bytes of an address
    unsigned length_bytes() const { return length_; }
    /// Throws Hdf5Fault if the file ends before.
    void read(std::uint64_t address, std::uint64_t count, void* out) const;

private:
    void lock(Access access);
    void find_superblock();
    void read_superblock(Access access);
    void read_old_superblock();

    int file_;
    std::uint64_t base_ = 0, size_ = 0, root_ = 0; ///< size_: from base_
    unsigned offset_ = 8, length_ = 8;
    bool is_written_ = false;
};

/// Reads numbers from the bytes of a structure, and throws Hdf5Fault at their end.
class Hdf5Cursor {
public:
    /// @param address  the address of the first byte, for errors
    Hdf5Cursor(const Hdf5Bytes& file, std::string_view bytes, std::uint64_t address)
        : bytes_(bytes), address_(address), offset_(file.offset_bytes()), length_(file.length_bytes())
    {
    }

    /// @param bytes  1 to 8
    std::uint64_t number(unsigned bytes);
    std::uint8_t u8() { return static_cast<std::uint8_t>(number(1)); }
    std::uint16_t u16() { return static_cast<std::uint16_t>(number(2)); }
    std::uint32_t u32() { return static_cast<std::uint32_t>(number(4)); }
    std::uint64_t length() { return number(length_); }
    std::uint64_t address(); ///< hdf5_nowhere: undefined
    std::string_view take(std::uint64_t bytes);
    void skip(std::uint64_t bytes) { take(bytes); }
    std::string_view text(); ///< up to a null character, which is skipped
    Hdf5Cursor part(std::uint64_t bytes);
    /// Skips these characters; throws if the next characters are others.
    void expect(std::string_view signature);
    /// Skips these characters and a version number of one byte.
    void expect(std::string_view signature, unsigned version);

    std::uint64_t left() const { return bytes_.size() - at_; }
    std::uint64_t here() const { return address_ + at_; } ///< address of the next byte
    [[noreturn]] void damaged(std::string_view what) const { hdf5_damaged(here(), what); }

private:
    std::string_view bytes_;
    std::size_t at_ = 0;
    std::uint64_t address_;
    unsigned offset_, length_;
};

/// A structure that was read.
struct Hdf5Block {
    std::string bytes;
    std::uint64_t address = 0;
    Hdf5Cursor cursor(const Hdf5Bytes& file) const { return {file, bytes, address}; }
};

/// Reads the structures of one object. In a valid file each byte belongs to one structure, so the size of the file
/// limits the bytes of all blocks: links in a circle come to an end.
class Hdf5Walk {
public:
    explicit Hdf5Walk(const Hdf5Bytes& of) : file(of), left_(2 * of.size() + 4096) {}

    const Hdf5Bytes& file;
    Hdf5Block block(std::uint64_t address, std::uint64_t size);
    /// A block that ends with its checksum. If the file is being written, a wrong checksum is read again for some
    /// milliseconds.
    Hdf5Block checked(std::uint64_t address, std::uint64_t size);

private:
    std::uint64_t left_;
};

} // namespace oncollide
