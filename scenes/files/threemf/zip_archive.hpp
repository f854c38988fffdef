#pragma once
#include <functional>
#include <memory>
#include <string>

#include <oncollide/scenes/files/mesh/mesh_source.hpp>

namespace oncollide {

/// The files of a zip archive, read by libzip. Private to scenes.
class ZipArchive {
public:
    /// Throws Error{bad_data} unless the whole archive is valid.
    explicit ZipArchive(const MeshSource& source);
    ~ZipArchive();

    bool has(const std::string& name) const;
    /// Passes on the file in pieces, at most 2 GiB in all, and compares its checksum at the end. Throws if the file is
    /// missing, and if all files together unpack to more than 100 times the archive and 16 MiB: meshes are packed 3 to
    /// 20 times, and a longer text only takes time.
    void read(const std::string& name, const std::function<void(std::string_view)>& visit) const;

private:
    struct Handle;
    const MeshSource& source_;
    std::unique_ptr<Handle> handle_;
};

} // namespace oncollide
