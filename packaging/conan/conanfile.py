"""The library of psim for Conan 2, from a local archive that PSIM_ARCHIVE names (packaging/README.md)."""
import os

from conan import ConanFile
from conan.errors import ConanException
from conan.tools.cmake import CMake, CMakeToolchain, CMakeDeps, cmake_layout
from conan.tools.files import copy, unzip


class PsimConan(ConanFile):
    name = "psim"
    version = "0.1.0"
    license = "MIT"
    description = "A 2D real-time physics engine for very many bodies"
    settings = "os", "arch", "compiler", "build_type"
    options = {"shared": [True, False]}
    default_options = {"shared": False}

    def _asks_cpu_features(self):
        return self.settings.os == "Linux" and self.settings.arch == "x86_64"

    def requirements(self):
        if self._asks_cpu_features():
            self.requires("cpu_features/0.9.0")

    def layout(self):
        cmake_layout(self)

    def source(self):
        archive = os.environ.get("PSIM_ARCHIVE", "")
        if not os.path.isfile(archive):
            raise ConanException("PSIM_ARCHIVE must name an archive of the sources")
        unzip(self, archive, destination=self.source_folder, strip_root=True)

    def generate(self):
        CMakeDeps(self).generate()
        toolchain = CMakeToolchain(self)
        for part in ("PROGRAMS", "BENCH", "TESTS"):
            toolchain.cache_variables[f"PSIM_BUILD_{part}"] = False
        toolchain.cache_variables["PSIM_BUILD_SHARED"] = bool(self.options.shared)
        toolchain.generate()

    def build(self):
        cmake = CMake(self)
        cmake.configure()
        cmake.build()

    def package(self):
        CMake(self).install()
        copy(self, "LICENSE", src=self.source_folder, dst=os.path.join(self.package_folder, "licenses"))

    def package_info(self):
        self.cpp_info.set_property("cmake_file_name", "psim")
        self.cpp_info.set_property("cmake_target_name", "psim::psim_shared" if self.options.shared else "psim::psim")
        self.cpp_info.set_property("pkg_config_name", "psim")
        self.cpp_info.libs = ["psim"]
        if self.settings.os == "Linux":
            self.cpp_info.system_libs = ["m", "pthread"]
