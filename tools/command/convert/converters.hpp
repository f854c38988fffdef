#pragma once
#include <filesystem>
#include <string>
#include <utility>
#include <vector>

namespace oncollide::tools {

/// A program of its own that makes a GLB file of the files of other programs. It is called as
/// `PROGRAM FILE -o OUT.glb [--deflection LENGTH]`, and exits with a code of ErrorKind or 0. Printed lines with
/// "warning: " are warnings; the last line with "error: " is the reason of a failure.
struct Converter {
    const char* program;  ///< "oncollide-cad"
    const char* variable; ///< of the environment, that names another path of the program
    const char* formats;  ///< "STEP, IGES and BREP"
    const char* needs;    ///< software to install
};

/// Null: the file's extension is none of a converter.
const Converter* converter_of(const std::filesystem::path& file);

/// The path of the program: named by its variable, beside this program, in ../libexec/oncollide, or in PATH; empty: it
/// is nowhere. Throws Error{no_input} if its variable names no program.
std::string find_program(const Converter& converter);

/// After this call all readers of meshes and assemblies read the files of converters.
/// @param deflection  largest distance between a mesh and the true surface, in the form of length_from(); empty: the
///                    converter chooses it
void read_converted_files(const std::string& deflection = {});

/// For each converter: its name; its formats and path, or the software that it needs.
std::vector<std::pair<std::string, std::string>> describe_converters();

} // namespace oncollide::tools
