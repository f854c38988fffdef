#include "cli/cooked_cache.hpp"

#include <algorithm>
#include <bit>
#include <vector>

#include <unistd.h>

#include <fmt/format.h>

#include <oncollide/base/error.hpp>
#include <oncollide/base/files/checksum.hpp>
#include <oncollide/base/files/file_bytes.hpp>
#include <oncollide/base/numbers/random.hpp>
#include <oncollide/narrowphase/cook_mesh.hpp>
#include <oncollide/scenes/cooked/cooked_format.hpp>
#include <oncollide/scenes/cooked/cooked_mesh.hpp>

#include "cli/cooked_tiles.hpp"
#include "convert/converters.hpp"

namespace oncollide::tools {

namespace fs = std::filesystem;

namespace {

std::uintmax_t bytes_in(const fs::path& folder)
{
    std::uintmax_t sum = 0;
    std::error_code error;
    for (fs::directory_iterator it(folder, error), end; !error && it != end; it.increment(error)) {
        std::error_code gone;
        const std::uintmax_t bytes = it->file_size(gone);
        if (!gone) sum += bytes;
    }
    return sum;
}

} // namespace

CookedCache::CookedCache(fs::path folder, std::uintmax_t most) : folder_(std::move(folder)), most_(most)
{
    std::error_code error;
    fs::create_directories(folder_, error);
    if (!fs::is_directory(folder_, error))
        throw Error(ErrorKind::cannot_write,
                    fmt::format("--cache: '{}' is not a folder and cannot be created", folder_.string()));
}

std::optional<fs::path> CookedCache::cooked(const fs::path& mesh, const MeshOptions& options) const
{
    const std::string extension = lower_extension(mesh);
    if (mesh == "-" || extension == ".gltf" || extension == ".cooked") return {};
    if (converter_of(mesh)) return {}; // the content does not say with which deflection it was read
    std::uint64_t content, size;
    {
        const FileBytes bytes = read_large_file(mesh, std::uintmax_t(2) << 30);
        content = checksum(bytes), size = bytes.size();
    }
    std::uint64_t key = content;
    for (const std::uint64_t part : {size, checksum(extension), std::bit_cast<std::uint64_t>(options.scale),
                                     std::bit_cast<std::uint64_t>(options.fit_diagonal), std::uint64_t(options.centre),
                                     std::uint64_t(cooked_version)})
        key = splitmix(key ^ part);
    const fs::path file = folder_ / fmt::format("{:016x}{:016x}.cooked", content, key);
    std::error_code ignored;
    if (fs::is_regular_file(file, ignored)) {
        try {
            CookedMesh{file};
            fs::last_write_time(file, fs::file_time_type::clock::now(), ignored); // marks it as used, for make_room()
            return file;
        } catch (const Error&) { // the file is damaged or was just removed: cook it again
        }
    }
    cook_mesh(load_mesh(mesh, options), file);
    make_room(file);
    return file;
}

fs::path CookedCache::tiles(const std::string& name, std::size_t count,
                            const std::function<Mesh(std::size_t)>& make) const
{
    const fs::path folder = folder_ / fmt::format("{}-v{}", name, cooked_version), index = folder / tile_index_name;
    std::error_code ignored;
    if (!fs::is_regular_file(index, ignored)) {
        const fs::path made = folder_ / fmt::format("{}.{}.tmp", folder.filename().string(), getpid());
        try {
            cook_tiles(
                made, count, [&](std::size_t i) { return std::pair(fmt::format("{}", i), make(i)); }, false);
        } catch (...) {
            fs::remove_all(made, ignored);
            throw;
        }
        fs::rename(made, folder, ignored);
        if (ignored) fs::remove_all(made, ignored); // another process made it first
        make_room(folder);
    }
    fs::last_write_time(folder, fs::file_time_type::clock::now(), ignored); // marks it as used, for make_room()
    return index;
}

/// Other processes may remove the same files meanwhile. Processes that read removed files keep them open.
void CookedCache::make_room(const fs::path& keep) const
{
    struct Entry {
        fs::file_time_type used;
        std::uintmax_t bytes;
        fs::path path;
    };
    std::vector<Entry> entries;
    std::uintmax_t held = 0;
    std::error_code error;
    for (fs::directory_iterator it(folder_, error), end; !error && it != end; it.increment(error)) {
        std::error_code gone;
        const bool tiles = fs::is_regular_file(it->path() / tile_index_name, gone);
        if (!(tiles || is_cooked(it->path()))) continue;
        const std::uintmax_t bytes = tiles ? bytes_in(it->path()) : it->file_size(gone);
        const fs::file_time_type used = it->last_write_time(gone);
        if (gone) continue;
        held += bytes;
        if (it->path() != keep) entries.push_back({used, bytes, it->path()});
    }
    std::ranges::sort(entries, {}, &Entry::used);
    for (const Entry& entry : entries) {
        if (held <= most_) return;
        fs::remove_all(entry.path, error);
        held -= entry.bytes;
    }
}

} // namespace oncollide::tools
