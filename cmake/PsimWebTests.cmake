# What runs of the tests in Node: the golden hashes, and the rooms of psim_tests that start no program and read no file
# of the tree. The program itself, the package and the page have tests of their own in tests/web.
set(PSIM_GTEST_SOURCE /usr/src/googletest/googletest CACHE PATH "GoogleTest's source (Debian: googletest)")

# A program that Node runs alone: node --no-experimental-fetch NAME.js. Its thread may wait for others.
function(psim_web_program target)
  psim_target_defaults(${target})
  target_link_options(${target} PRIVATE -sALLOW_MEMORY_GROWTH -sMAXIMUM_MEMORY=4GB -sENVIRONMENT=node,worker
                      -sNODERAWFS=1 -sEXIT_RUNTIME -sPROXY_TO_PTHREAD)
endfunction()

add_executable(golden tests/golden/main.cpp)
psim_web_program(golden)
target_link_libraries(golden PRIVATE psim_scene)

add_library(psim_gtest STATIC EXCLUDE_FROM_ALL "${PSIM_GTEST_SOURCE}/src/gtest-all.cc"
            "${PSIM_GTEST_SOURCE}/src/gtest_main.cc")
target_compile_features(psim_gtest PUBLIC cxx_std_20)
target_compile_options(psim_gtest PRIVATE -w)
target_include_directories(psim_gtest PRIVATE "${PSIM_GTEST_SOURCE}")
target_include_directories(psim_gtest SYSTEM PUBLIC "${PSIM_GTEST_SOURCE}/include")

file(GLOB _web_tests CONFIGURE_DEPENDS tests/base/*_test.cpp tests/kernels/*_test.cpp
     tests/state/*_test.cpp tests/world/*_test.cpp tests/reference/*.cpp)
list(FILTER _web_tests EXCLUDE REGEX "/pendulums\\.cpp$")  # elliptic integrals, which libc++ lacks
add_executable(psim_tests EXCLUDE_FROM_ALL ${_web_tests} tests/support/allocation_counter.cpp)
psim_web_program(psim_tests)
target_compile_options(psim_tests PRIVATE -O1)
target_compile_definitions(psim_tests PRIVATE "PSIM_SOURCE_DIR=\"${PROJECT_SOURCE_DIR}\"")
target_include_directories(psim_tests PRIVATE tests tests/support tests/reference src/kernels src/core src/scene)
target_link_libraries(psim_tests PRIVATE psim_scene psim_fuzz_inputs psim_gtest)
psim_rooms(psim_tests)
