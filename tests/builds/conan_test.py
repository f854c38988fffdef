"""Tests the recipe for Conan without Conan: Conan is mocked, and the exported project must configure with the options that the recipe passes.

    conan_test.py SOURCE
"""
import importlib.util
import pathlib
import shutil
import subprocess
import sys
import tempfile
import types

source = pathlib.Path(sys.argv[1])
recipe_file = source / "cmake/packaging/conan/conanfile.py"


class ConanFile:
    def requires(self, reference, **_):
        self.required.append(reference)


class CMakeToolchain:
    def __init__(self, recipe):
        self.recipe, self.cache_variables = recipe, {}

    def generate(self):
        self.recipe.variables = self.cache_variables


class CMake:
    def __init__(self, recipe):
        self.recipe = recipe

    def configure(self):
        options = [f"-D{name}={'ON' if value else 'OFF'}" for name, value in self.recipe.variables.items()]
        command = ["cmake", "-S", self.recipe.source_folder, "-B", self.recipe.source_folder + "/build", "-G", "Ninja", *options]
        done = subprocess.run(command, capture_output=True, text=True)
        if done.returncode or "Manually-specified variables were not used" in done.stderr:
            sys.exit(f"what the recipe exports does not configure:\n{done.stdout}{done.stderr}")

    def build(self):
        pass

    def install(self):
        pass


def copy(recipe, pattern, src, dst):
    found = [path for path in pathlib.Path(src).glob(pattern.replace("/*", "/**/*")) if path.is_file() or path.is_symlink()]
    assert found, f"nothing matches {pattern}"
    for path in found:
        target = pathlib.Path(dst) / path.relative_to(src)
        target.parent.mkdir(parents=True, exist_ok=True)
        shutil.copy(path, target, follow_symlinks=not path.is_symlink())


def module(name, **contents):
    made = types.ModuleType(name)
    made.__dict__.update(contents)
    sys.modules[name] = made


module("conan", ConanFile=ConanFile)
module("conan.tools")
module("conan.tools.cmake", CMake=CMake, CMakeToolchain=CMakeToolchain, CMakeDeps=lambda recipe: types.SimpleNamespace(generate=lambda: None),
       cmake_layout=lambda recipe: None)  # fmt: skip
module("conan.tools.files", copy=copy)
spec = importlib.util.spec_from_file_location("conanfile", recipe_file)
conanfile = importlib.util.module_from_spec(spec)
spec.loader.exec_module(conanfile)

for fcl in (False, True):
    recipe = conanfile.Oncollide()
    recipe.required, recipe.recipe_folder = [], str(recipe_file.parent)
    recipe.options = types.SimpleNamespace(fcl=fcl, octomap=True)
    assert f"VERSION {recipe.version} " in (source / "CMakeLists.txt").read_text(), "the version is not the project's"
    with tempfile.TemporaryDirectory() as folder:
        recipe.export_sources_folder = recipe.source_folder = recipe.package_folder = folder
        recipe.export_sources(), recipe.requirements(), recipe.layout(), recipe.generate(), recipe.build(), recipe.package()
    assert any(reference.startswith("fcl/") for reference in recipe.required) == fcl
