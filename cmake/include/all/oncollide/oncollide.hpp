// The headers of a first program: Worlds and their results, queries of two meshes, shapes and files. Further headers:
// docs/architecture.md.
#pragma once
#include <oncollide/base/error.hpp>
#include <oncollide/pipeline/two_geometries.hpp>
#include <oncollide/pipeline/world.hpp>
#include <oncollide/scenes/files/geometry_file.hpp>
