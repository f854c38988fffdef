#include <oncollide/scenes/files/hdf5/hdf5_bytes.hpp>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <thread>

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <fmt/format.h>

#include <oncollide/base/files/checksum.hpp>

namespace oncollide {

namespace {

constexpr std::string_view file_signature("\x89HDF\r\n\x1a\n", 8);

[[noreturn]] void incomplete()
{
    throw Hdf5Fault{"is not a complete HDF5 file, or is being written"};
}

std::uint64_t size_of(int file)
{
    struct stat status;
    return ::fstat(file, &status) == 0 ? static_cast<std::uint64_t>(status.st_size) : 0;
}

} // namespace

void hdf5_damaged(std::uint64_t address, std::string_view what)
{
    throw Hdf5Fault{fmt::format("the file is damaged or cut off (byte {}: {})", address, what)};
}

void hdf5_unread(std::string_view feature, std::string_view arguments)
{
    throw Hdf5Fault{fmt::format("{} is not supported; rewrite the file: h5repack {}{}OLD NEW", feature, arguments,
                                arguments.empty() ? "" : " ")};
}

Hdf5Bytes::Hdf5Bytes(const std::filesystem::path& path, Access access)
    : file_(::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK))
{
    try {
        if (file_ < 0) incomplete();
        size_ = size_of(file_);
        lock(access), find_superblock();
        read_superblock(access);
    } catch (const Hdf5Fault&) {
        if (file_ >= 0) ::close(file_);
        incomplete();
    }
}

Hdf5Bytes::~Hdf5Bytes()
{
    ::close(file_);
}

/// Locks the file as HDF5's library does: writers lock their files, and a file that is read alone stays locked. Not all
/// file systems have locks.
void Hdf5Bytes::lock(Access access)
{
    if (::flock(file_, LOCK_SH | LOCK_NB) != 0 && errno == EWOULDBLOCK) incomplete();
    if (access == Access::while_written) ::flock(file_, LOCK_UN);
}

/// The superblock follows a block of the user's own, of 0, 512, 1024, 2048, ... bytes.
void Hdf5Bytes::find_superblock()
{
    const std::uint64_t whole = size_;
    for (base_ = 0; base_ + file_signature.size() <= whole; base_ = base_ ? 2 * base_ : 512) {
        char found[file_signature.size()];
        size_ = whole - base_;
        read(0, sizeof found, found);
        if (std::string_view(found, sizeof found) == file_signature) return;
    }
    incomplete();
}

void Hdf5Bytes::read_superblock(Access access)
{
    Hdf5Walk walk(*this);
    const std::uint8_t version = walk.block(8, 1).cursor(*this).u8();
    if (version < 2) return read_old_superblock();
    if (version > 3) incomplete();
    const Hdf5Block prefix = walk.block(0, 12);
    Hdf5Cursor start = prefix.cursor(*this);
    start.skip(9), offset_ = start.u8(), length_ = start.u8();
    const unsigned flags = version == 3 ? start.u8() : 0, written = 1, with_readers = 4;
    if (std::min(offset_, length_) < 2 || std::max(offset_, length_) > 8) incomplete();
    is_written_ = flags & (written | with_readers);
    if (is_written_ && (access == Access::alone || !(flags & with_readers))) incomplete();
    const Hdf5Block block = walk.checked(0, 12 + 4 * offset_ + 4);
    Hdf5Cursor cursor = block.cursor(*this);
    cursor.skip(12);
    const std::uint64_t base = cursor.number(offset_);
    cursor.address(); // address of the superblock's extension
    const std::uint64_t end = cursor.number(offset_);
    root_ = cursor.address();
    if (!is_written_ && end - base > size_) incomplete();
}

/// Reads version 0 or 1.
void Hdf5Bytes::read_old_superblock()
{
    Hdf5Walk walk(*this);
    const Hdf5Block prefix = walk.block(0, 16);
    Hdf5Cursor start = prefix.cursor(*this);
    start.skip(8);
    const unsigned version = start.u8(), fixed = version == 0 ? 24 : 28;
    start.skip(4), offset_ = start.u8(), length_ = start.u8();
    if (std::min(offset_, length_) < 2 || std::max(offset_, length_) > 8) incomplete();
    const Hdf5Block block = walk.block(0, fixed + 6 * offset_);
    Hdf5Cursor cursor = block.cursor(*this);
    cursor.skip(fixed);
    const std::uint64_t base = cursor.number(offset_);
    cursor.address(); // address of free space
    const std::uint64_t end = cursor.number(offset_);
    cursor.address(), cursor.address(); // addresses of a driver's data and of the root group's name
    root_ = cursor.address();
    if (end - base > size_) incomplete();
}

std::uint64_t Hdf5Bytes::size() const
{
    return is_written_ ? size_of(file_) - base_ : size_;
}

void Hdf5Bytes::read(std::uint64_t address, std::uint64_t count, void* out) const
{
    if (address > size() || count > size() - address) hdf5_damaged(address, "the file ends");
    char* to = static_cast<char*>(out);
    while (count > 0) {
        const ssize_t got = ::pread(file_, to, count, static_cast<off_t>(base_ + address));
        if (got < 0 && errno == EINTR) continue;
        if (got <= 0) hdf5_damaged(address, "cannot be read");
        to += got, address += static_cast<std::uint64_t>(got), count -= static_cast<std::uint64_t>(got);
    }
}

std::uint64_t Hdf5Cursor::number(unsigned bytes)
{
    const std::string_view taken = take(bytes);
    std::uint64_t value = 0;
    for (unsigned i = bytes; i-- > 0;) value = value << 8 | static_cast<unsigned char>(taken[i]);
    return value;
}

std::uint64_t Hdf5Cursor::address()
{
    const std::uint64_t value = number(offset_);
    return value == hdf5_nowhere >> (64 - 8 * offset_) ? hdf5_nowhere : value;
}

std::string_view Hdf5Cursor::take(std::uint64_t bytes)
{
    if (bytes > left()) damaged("a structure ends");
    at_ += bytes;
    return bytes_.substr(at_ - bytes, bytes);
}

std::string_view Hdf5Cursor::text()
{
    const std::size_t end = bytes_.find('\0', at_);
    if (end == bytes_.npos) damaged("a text has no end");
    const std::string_view found = bytes_.substr(at_, end - at_);
    at_ = end + 1;
    return found;
}

Hdf5Cursor Hdf5Cursor::part(std::uint64_t bytes)
{
    Hdf5Cursor part = *this;
    part.bytes_ = take(bytes), part.address_ = address_ + at_ - bytes, part.at_ = 0;
    return part;
}

void Hdf5Cursor::expect(std::string_view signature)
{
    if (left() < signature.size() || bytes_.substr(at_, signature.size()) != signature)
        damaged(fmt::format("'{}' is missing", signature));
    at_ += signature.size();
}

void Hdf5Cursor::expect(std::string_view signature, unsigned version)
{
    expect(signature);
    if (u8() != version) hdf5_unread(fmt::format("a newer version of the format ('{}')", signature));
}

Hdf5Block Hdf5Walk::block(std::uint64_t address, std::uint64_t size)
{
    if (address == hdf5_nowhere) hdf5_damaged(address, "a structure is missing");
    if (size > left_) hdf5_damaged(address, "structures overlap");
    left_ -= size;
    Hdf5Block block{{}, address};
    if (size > file.size()) hdf5_damaged(address, "the file ends");
    block.bytes.resize(size);
    file.read(address, size, block.bytes.data());
    return block;
}

Hdf5Block Hdf5Walk::checked(std::uint64_t address, std::uint64_t size)
{
    if (size < 4) hdf5_damaged(address, "a structure is too short");
    Hdf5Block block = this->block(address, size);
    const auto is_right = [&] {
        const std::string_view bytes = block.bytes;
        Hdf5Cursor stored(file, bytes.substr(size - 4), address);
        return stored.u32() == lookup3(bytes.substr(0, size - 4));
    };
    bool right = is_right();
    // Bytes that do not change are not being written.
    for (int wait = 250, unchanged = 0; !right && file.is_written() && wait < 16'000 && unchanged < 2; wait *= 2) {
        std::this_thread::sleep_for(std::chrono::microseconds(wait));
        const std::string before = block.bytes;
        file.read(address, size, block.bytes.data());
        unchanged = block.bytes == before ? unchanged + 1 : 0;
        right = is_right();
    }
    if (!right) hdf5_damaged(address, "wrong checksum");
    return block;
}

} // namespace oncollide
