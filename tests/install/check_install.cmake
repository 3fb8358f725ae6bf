# Installs the library into a scratch folder, moves it, and uses it there as a stranger would:
# once through find_package, once through pkg-config. Run by CTest with cmake -P.
set(scratch "${BUILD_DIR}/install-check")
file(REMOVE_RECURSE "${scratch}")

function(run)
  execute_process(COMMAND ${ARGN} RESULT_VARIABLE result OUTPUT_VARIABLE output ERROR_VARIABLE output)
  string(STRIP "${output}" output)
  message(STATUS "${output}")
  if(NOT result EQUAL 0)
    string(REPLACE ";" " " command "${ARGN}")
    message(FATAL_ERROR "${command}: exit ${result}")
  endif()
  set(output "${output}" PARENT_SCOPE)
endfunction()

run(${CMAKE_COMMAND} --install "${BUILD_DIR}" --component psim_library --prefix "${scratch}/first")
file(RENAME "${scratch}/first" "${scratch}/prefix")  # an installation may be moved
set(prefix "${scratch}/prefix")
if(EXISTS "${prefix}/include/psim/scene.h")
  message(FATAL_ERROR "psim/scene.h is installed, but the scene reader is not part of the library")
endif()

run(${CMAKE_COMMAND} -S "${CONSUMER_DIR}" -B "${scratch}/consumer" -G "${GENERATOR}"
    "-DCMAKE_CXX_COMPILER=${CXX}" "-DCMAKE_PREFIX_PATH=${prefix}" -DCMAKE_BUILD_TYPE=Release)
run(${CMAKE_COMMAND} --build "${scratch}/consumer")
run("${scratch}/consumer/consumer")

find_program(PKG_CONFIG pkg-config)
if(NOT PKG_CONFIG)
  message(STATUS "no pkg-config here: psim.pc is not tried")
  return()
endif()
file(GLOB_RECURSE pc "${prefix}/psim.pc")
cmake_path(GET pc PARENT_PATH pc_dir)
run(${CMAKE_COMMAND} -E env "PKG_CONFIG_PATH=${pc_dir}" "${PKG_CONFIG}" --cflags --libs psim)
separate_arguments(flags UNIX_COMMAND "${output}")
cmake_path(GET pc_dir PARENT_PATH lib_dir)
run("${CXX}" -std=c++20 "${CONSUMER_DIR}/consumer.cpp" -o "${scratch}/pc-consumer" ${flags}
    "-Wl,-rpath,${lib_dir}")
run("${scratch}/pc-consumer")
