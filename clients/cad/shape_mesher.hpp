#pragma once
#include <string>
#include <vector>

#include <TopoDS_Shape.hxx>

#include "model.hpp"

namespace oncollide::cad {

constexpr double metres_per_unit = 1e-3; ///< of Open CASCADE's shapes: its readers convert files to millimetres

/// A connected piece of a shape: a solid, or the faces outside of all solids.
struct Piece {
    std::string name; ///< empty: the shape has no other piece
    Mesh mesh;
};

/// Divides a shape into triangles: the same ones for the same shape. Appends to `warnings` a line that names `name` for
/// each thing that is missing or worse than requested. Returns nothing for a shape without faces.
/// @param deflection  metres; 0: by the size of the shape
std::vector<Piece> mesh_of(const TopoDS_Shape& shape, const std::string& name, double deflection,
                           std::vector<std::string>& warnings);

} // namespace oncollide::cad
