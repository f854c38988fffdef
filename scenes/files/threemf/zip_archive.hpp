#pragma once
#include <functional>
#include <memory>
#include <string>

#include <oncollide/scenes/files/mesh/mesh_source.hpp>

namespace oncollide {

/// The files of a zip archive, as libzip reads them. Private to scenes.
class ZipArchive {
public:
    /// Throws Error{bad_data} unless the archive is sound as a whole.
    explicit ZipArchive(const MeshSource& source);
    ~ZipArchive();

    bool has(const std::string& name) const;
    /// Passes the file on in pieces: at most 2 GiB, whose checksum is compared at the end. Throws where there is none.
    void read(const std::string& name, const std::function<void(std::string_view)>& visit) const;

private:
    struct Handle;
    const MeshSource& source_;
    std::unique_ptr<Handle> handle_;
};

} // namespace oncollide
