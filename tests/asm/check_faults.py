#!/usr/bin/env python3
"""Proves that tools/asm-inspect finds what it looks for: check_faults.py CXX."""
import pathlib
import subprocess
import sys
import tempfile

compiler = sys.argv[1]
here = pathlib.Path(__file__).resolve().parent
# Outside the build folder, where a search for kernel objects must find the real ones only.
folder = tempfile.TemporaryDirectory()
scratch = pathlib.Path(folder.name)
units = scratch / "psim_kernels.dir"
units.mkdir(parents=True)
machine = subprocess.run([compiler, "-dumpmachine"], check=True, capture_output=True, text=True).stdout
arm = machine.startswith("aarch64")
x86_units = (("scalar", ["-mavx"]), ("sse4", ["-msse3"]), ("avx2", ["-mavx2", "-mfma", "-DWITH_AVX"]))
for isa, flags in (("scalar", []), ("neon", [])) if arm else x86_units:
    subprocess.run([compiler, "-std=c++20", "-O2", "-g1", *flags, "-c", here / "faults.cpp",
                    "-o", units / f"kernels_{isa}.cpp.o"], check=True)
core = scratch / "psim_core_objects.dir"
core.mkdir()
flags = ["-march=armv8.1-a"] if arm else ["-msse3", "-DWITH_SSE3"]
subprocess.run([compiler, "-std=c++20", "-O2", *flags, "-c", here / "faults.cpp",
                "-o", core / "step.cpp.o"], check=True)

result = subprocess.run([here.parent.parent / "tools/asm-inspect", "--build", scratch, "--check"],
                        capture_output=True, text=True)
print(result.stdout + result.stderr)
arm_expected = [
    "kernels_scalar.cpp.o: weak symbol shared_by_all_units(float)",
    "kernels_neon.cpp.o: call_in_loop: call in a loop at faults.cpp:1",
    "kernels_neon.cpp.o: estimate: estimate whose bits differ",
    "kernels_neon.cpp.o: other_minimum: minimum or maximum",
    "kernels_neon.cpp.o: fused: fused multiply-add",
    "step.cpp.o: above_base: instruction above Armv8.0-A",
]
expected = arm_expected if arm else [
    "kernels_scalar.cpp.o: weak symbol shared_by_all_units(float)",
    "kernels_scalar.cpp.o: call_in_loop: AVX code outside the AVX2 unit",
    "kernels_sse4.cpp.o: call_in_loop: call in a loop at faults.cpp:1",
    "kernels_sse4.cpp.o: estimate: estimate whose bits differ",
    "kernels_avx2.cpp.o: fused: fused multiply-add",
    "step.cpp.o: above_sse2: instruction above SSE2",
]
missed = [e for e in expected if "FAULT " + e not in result.stdout]
wrong = [l for l in result.stdout.splitlines() if "cold_call_is_fine: call" in l]
for line in missed:
    print("not found: " + line)
for line in wrong:
    print("no fault: " + line)
sys.exit(bool(missed or wrong or result.returncode != 1))
