// Small files of every format that the readers accept: the initial corpus of the fuzzers.
#pragma once
#include <string>
#include <vector>

#include "tools/run_command.hpp"

namespace oncollide::test {

std::vector<std::string> obj_seeds();
std::vector<std::string> off_seeds();
std::vector<std::string> ply_seeds();
std::vector<std::string> stl_seeds();
std::vector<std::string> gltf_seeds();
std::vector<std::string> glb_seeds();
std::vector<std::string> dae_seeds();
std::vector<std::string> threemf_seeds(); ///< archives, and bare models
std::vector<std::string> urdf_seeds();
std::vector<std::string> srdf_seeds(); ///< for arm.urdf
std::vector<std::string> mjcf_seeds();
std::vector<std::string> problem_seeds(); ///< MotionBenchMaker's
std::vector<std::string> request_seeds();
std::vector<std::string> sphere_model_seeds(); ///< of arm.urdf
std::vector<std::string> bt_seeds();
std::vector<std::string> ot_seeds();
std::vector<std::string> pgm_seeds();
std::vector<std::string> png_seeds();
std::vector<std::string> npy_seeds();
std::vector<std::string> scene_seeds();
std::vector<std::string> poses_seeds();
std::vector<std::string> aabbs_seeds();
std::vector<std::string> table_seeds(); ///< CSV
std::vector<std::string> recording_seeds();
std::vector<std::string> vertices_seeds(); ///< NumPy
std::vector<std::string> cooked_seeds();
std::vector<std::string> tiles_seeds(); ///< of one chunk, and of several

/// Writes the files that some seeds refer to.
void add_companions(const TemporaryFolder& folder);

} // namespace oncollide::test
