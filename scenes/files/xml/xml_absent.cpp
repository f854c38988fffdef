// Replaces the readers that need Expat and libzip in builds without them.
#include <oncollide/base/error.hpp>
#include <oncollide/scenes/files/assembly/raw_assembly.hpp>

namespace oncollide {

namespace {

[[noreturn]] void fail(const MeshSource& source)
{
    throw Error(
        ErrorKind::usage,
        source.name +
            ": this is a build without the readers of COLLADA and 3MF; build on Linux with -DONCOLLIDE_XML=ON (Debian: "
            "libexpat1-dev, libzip-dev), or export the file as glTF, OBJ or PLY");
}

} // namespace

RawMesh read_collada(const MeshSource& source)
{
    fail(source);
}

RawMesh read_3mf(const MeshSource& source)
{
    fail(source);
}

RawAssembly read_collada_parts(const MeshSource& source, const PartsReading&)
{
    fail(source);
}

RawAssembly read_3mf_parts(const MeshSource& source, const PartsReading&)
{
    fail(source);
}

} // namespace oncollide
