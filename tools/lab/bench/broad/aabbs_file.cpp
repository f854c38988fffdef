#include "bench/broad/aabbs_file.hpp"

#include <array>
#include <bit>
#include <cmath>
#include <cstring>
#include <fstream>
#include <memory>

#include <fmt/format.h>

#include <oncollide/base/error.hpp>
#include <oncollide/base/files/file_bytes.hpp>

namespace oncollide::tools {
namespace {

static_assert(std::endian::native == std::endian::little, "recordings are little-endian");

struct Header {
    char scene[128], type[128];
    std::int32_t count, frames, zero[2];
    float world[8];
};
static_assert(sizeof(Header) == 304);

using FileBox = std::array<float, 8>; // min and max, each followed by a 0

class Recording {
public:
    explicit Recording(const std::filesystem::path& path) : path_(path)
    {
        check_readable(path);
        in_.open(path, std::ios::binary);
        std::error_code error;
        const std::uintmax_t size = std::filesystem::file_size(path, error);
        if (error || !in_) throw Error(ErrorKind::no_input, fmt::format("{}: cannot be read", path.string()));
        if (size < sizeof header_ || !in_.read(reinterpret_cast<char*>(&header_), sizeof header_))
            fail(fmt::format("{} bytes are too few for the header of {}", size, sizeof header_));
        check_header();
        const std::uintmax_t expected =
            sizeof header_ + (std::uintmax_t(frames()) + 1) * std::uintmax_t(count()) * sizeof(FileBox);
        if (size != expected)
            fail(fmt::format("{} boxes in {} frames and the initial one take {} bytes, but the file has {}", count(),
                             frames(), expected, size));
        file_boxes_.resize(count());
    }

    std::size_t count() const { return std::size_t(header_.count); }
    std::uint64_t frames() const { return std::uint64_t(header_.frames); }
    std::string name() const { return std::string(header_.scene) + " " + header_.type; }

    /// Reads the next frame and lists the boxes that changed.
    void read(std::uint64_t frame, std::vector<Aabb>& boxes, std::vector<std::uint32_t>& moved)
    {
        if (!in_.read(reinterpret_cast<char*>(file_boxes_.data()), std::streamsize(count() * sizeof(FileBox))))
            fail(fmt::format("cannot read frame {}", frame));
        moved.clear();
        for (std::uint32_t i = 0; i < count(); ++i) {
            const Aabb box = checked(frame, i);
            if (box.min == boxes[i].min && box.max == boxes[i].max) continue;
            boxes[i] = box;
            moved.push_back(i);
        }
    }

    void rewind() { in_.clear(), in_.seekg(sizeof header_); }

private:
    [[noreturn]] void fail(const std::string& what) const
    {
        throw Error(ErrorKind::bad_data, fmt::format("{}: {}", path_.string(), what));
    }

    void check_header() const
    {
        for (const char* text : {header_.scene, header_.type})
            if (!std::memchr(text, 0, 128)) fail("the names in the header do not end within their 128 bytes");
        if (header_.count < 1 || header_.count > 100'000'000)
            fail(fmt::format("the header has {} boxes; must be 1 to 100000000", header_.count));
        if (header_.frames < 1) fail(fmt::format("the header has {} frames; must be 1 or more", header_.frames));
        if (header_.zero[0] != 0 || header_.zero[1] != 0)
            fail("bytes 264 to 271 of the header are not 0: this is not a recording of boxes");
    }

    Aabb checked(std::uint64_t frame, std::uint32_t i) const
    {
        const FileBox& b = file_boxes_[i];
        for (int axis : {0, 1, 2})
            if (!std::isfinite(b[std::size_t(axis)]) || !std::isfinite(b[std::size_t(axis) + 4]) ||
                b[std::size_t(axis)] > b[std::size_t(axis) + 4])
                fail(fmt::format("frame {}, box {}: [{}, {}] along {} is not an interval", frame, i,
                                 b[std::size_t(axis)], b[std::size_t(axis) + 4], "xyz"[axis]));
        Aabb box;
        box.min = {b[0], b[1], b[2]};
        box.max = {b[4], b[5], b[6]};
        return box;
    }

    std::filesystem::path path_;
    std::ifstream in_;
    Header header_{};
    std::vector<FileBox> file_boxes_;
};

} // namespace

BoxScene open_aabbs(const std::filesystem::path& path)
{
    const auto recording = std::make_shared<Recording>(path);
    BoxScene scene;
    scene.name = recording->name();
    scene.boxes.resize(recording->count());
    scene.is_static.assign(recording->count(), 0);
    scene.last_frame = recording->frames();
    scene.next = [recording](BoxScene& s) { recording->read(s.frame, s.boxes, s.moved); };
    for (std::uint64_t frame = 0; frame <= scene.last_frame; ++frame) recording->read(frame, scene.boxes, scene.moved);
    recording->rewind();
    recording->read(0, scene.boxes, scene.moved);
    return scene;
}

} // namespace oncollide::tools
