"""conan create cmake/packaging/conan: the library, without the command, from this source tree."""
import os

from conan import ConanFile
from conan.tools.cmake import CMake, CMakeDeps, CMakeToolchain, cmake_layout
from conan.tools.files import copy


class Oncollide(ConanFile):
    name = "oncollide"
    version = "0.1.0"
    license = "BSD-3-Clause"
    description = "Finds which bodies of a large environment collide, at a certified accuracy"
    package_type = "static-library"
    settings = "os", "compiler", "build_type", "arch"
    options = {"fcl": [True, False], "octomap": [True, False]}
    default_options = {"fcl": False, "octomap": True}

    def export_sources(self):
        source = os.path.join(self.recipe_folder, "..", "..", "..")
        for folder in ("base", "scenes", "samples", "broadphase", "narrowphase", "pipeline", "robots", "runs", "cmake"):
            copy(self, f"{folder}/*", source, self.export_sources_folder)
        copy(self, "CMakeLists.txt", source, self.export_sources_folder)
        copy(self, "LICENSE", source, self.export_sources_folder)

    def requirements(self):
        self.requires("eigen/3.4.0", transitive_headers=True)
        for library in ("fmt/9.1.0", "nlohmann_json/3.11.2", "qhull/8.0.2", "libpng/1.6.40"):
            self.requires(library)
        if self.options.fcl:
            self.requires("fcl/0.7.0")
        if self.options.octomap:
            self.requires("octomap/1.9.7")

    def layout(self):
        cmake_layout(self)

    def generate(self):
        CMakeDeps(self).generate()
        toolchain = CMakeToolchain(self)
        for part in ("TOOLS", "TESTS", "PYTHON", "GDAL", "HDF5", "XML", "GL"):
            toolchain.cache_variables[f"ONCOLLIDE_{part}"] = False
        toolchain.cache_variables["ONCOLLIDE_FCL"] = bool(self.options.fcl)
        toolchain.cache_variables["ONCOLLIDE_OCTOMAP"] = bool(self.options.octomap)
        toolchain.generate()

    def build(self):
        cmake = CMake(self)
        cmake.configure()
        cmake.build()

    def package(self):
        CMake(self).install()
        copy(self, "LICENSE", self.source_folder, os.path.join(self.package_folder, "licenses"))

    def package_info(self):  # the CMake package files that the library installs
        self.cpp_info.set_property("cmake_find_mode", "none")
        self.cpp_info.builddirs = [os.path.join("lib", "cmake", "oncollide")]
