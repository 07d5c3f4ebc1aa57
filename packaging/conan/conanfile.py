"""Conan 2 recipe of the engine, meshgauge::engine: `conan create packaging/conan` in the project's root."""

import os
import re

from conan import ConanFile
from conan.tools.build import check_min_cppstd
from conan.tools.cmake import CMake, CMakeDeps, CMakeToolchain, cmake_layout
from conan.tools.files import copy, load

ROOT = os.path.join("..", "..")


class Meshgauge(ConanFile):
    name = "meshgauge"
    description = "Certified Hausdorff distance between triangle meshes: the engine as a library"
    license = "MIT"
    url = homepage = "https://github.com/OWNER/meshgauge"
    package_type = "static-library"
    settings = "os", "arch", "compiler", "build_type"
    languages = "C++"

    def set_version(self):
        text = load(self, os.path.join(self.recipe_folder, ROOT, "CMakeLists.txt"))
        self.version = re.search(r"project\(meshgauge VERSION (\S+)", text)[1]

    def export_sources(self):
        top = os.path.join(self.recipe_folder, ROOT)
        for pattern in ("CMakeLists.txt", "LICENSE", "cmake/*", "engine/*"):
            copy(self, pattern, top, self.export_sources_folder)

    def layout(self):
        cmake_layout(self)

    def requirements(self):
        self.requires("eigen/3.4.0", transitive_headers=True)
        self.requires("highway/1.0.7", visible=False)

    def validate(self):
        check_min_cppstd(self, 20)

    def generate(self):
        toolchain = CMakeToolchain(self)
        for option in ("MESHGAUGE_BUILD_SERVICE", "MESHGAUGE_BUILD_TESTS", "MESHGAUGE_WERROR"):
            toolchain.cache_variables[option] = False
        toolchain.generate()
        CMakeDeps(self).generate()

    def build(self):
        cmake = CMake(self)
        cmake.configure()
        cmake.build()

    def package(self):
        copy(self, "LICENSE", self.source_folder, os.path.join(self.package_folder, "licenses"))
        CMake(self).install()

    def package_info(self):
        # The package's own CMake files are used: they are the same as after `cmake --install`.
        self.cpp_info.set_property("cmake_find_mode", "none")
        self.cpp_info.builddirs = [os.path.join("lib", "cmake", "meshgauge")]
