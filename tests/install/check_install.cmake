# Installs the library into a scratch folder, moves it, and uses it there as a stranger would: C++ and
# C, static and shared, through find_package and through pkg-config; then looks at the names that the
# shared library shows. Run by CTest with cmake -P.
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

# The headers: the public ones, no scene reader, no intrinsics, nothing of the sources.
if(EXISTS "${prefix}/include/psim/scene.h")
  message(FATAL_ERROR "psim/scene.h is installed, but the scene reader is not part of the library")
endif()
file(GLOB_RECURSE headers RELATIVE "${prefix}/include" "${prefix}/include/*")
foreach(header IN LISTS headers)
  if(NOT header MATCHES "^psim(/.+)?\\.h$")
    message(FATAL_ERROR "${header} is installed and is no header of psim")
  endif()
  file(STRINGS "${prefix}/include/${header}" includes REGEX "^ *#include")
  foreach(line IN LISTS includes)
    if(line MATCHES "intrin|cpu_features|cpuinfo" OR
       (line MATCHES "\"" AND NOT line MATCHES "\"psim/"))
      message(FATAL_ERROR "${header} has ${line}")
    endif()
  endforeach()
endforeach()

# find_package: C++ with both libraries, C with the shared one.
run(${CMAKE_COMMAND} -S "${CONSUMER_DIR}" -B "${scratch}/consumer" -G "${GENERATOR}"
    "-DCMAKE_CXX_COMPILER=${CXX}" "-DCMAKE_PREFIX_PATH=${prefix}" "-DINSTALLED_TO=${prefix}"
    -DCMAKE_BUILD_TYPE=Release)
run(${CMAKE_COMMAND} --build "${scratch}/consumer")
run("${scratch}/consumer/consumer_psim")
run("${scratch}/consumer/consumer_psim_shared")
run(${CMAKE_COMMAND} -S "${CONSUMER_DIR}/c" -B "${scratch}/c-consumer" -G "${GENERATOR}"
    "-DCMAKE_C_COMPILER=${CC}" "-DCMAKE_PREFIX_PATH=${prefix}" "-DSOURCE=${C_SOURCE}"
    -DCMAKE_BUILD_TYPE=Release)
run(${CMAKE_COMMAND} --build "${scratch}/c-consumer")
run("${scratch}/c-consumer/consumer")

# The names that the shared library shows.
file(GLOB_RECURSE shared "${prefix}/*/libpsim.so")
run("${PYTHON}" "${CONSUMER_DIR}/check_symbols.py" "${NM}" "${shared}" "${prefix}/include")

find_program(PKG_CONFIG pkg-config)
if(NOT PKG_CONFIG)
  message(STATUS "no pkg-config here: psim.pc is not tried")
  return()
endif()
file(GLOB_RECURSE pc "${prefix}/psim.pc")
cmake_path(GET pc PARENT_PATH pc_dir)
cmake_path(GET pc_dir PARENT_PATH lib_dir)
set(pkg_config ${CMAKE_COMMAND} -E env "PKG_CONFIG_PATH=${pc_dir}" "${PKG_CONFIG}")
run(${pkg_config} --cflags --libs psim)
separate_arguments(flags UNIX_COMMAND "${output}")
run("${CXX}" -std=c++20 "${CONSUMER_DIR}/consumer.cpp" -o "${scratch}/pc-shared" ${flags}
    "-Wl,-rpath,${lib_dir}")
run("${scratch}/pc-shared")
run("${CC}" -std=c99 "${C_SOURCE}" -o "${scratch}/pc-shared-c" ${flags} -lm "-Wl,-rpath,${lib_dir}")
run("${scratch}/pc-shared-c")
run(${pkg_config} --static --cflags --libs psim)
separate_arguments(flags UNIX_COMMAND "${output}")
run("${CC}" -static -std=c99 "${C_SOURCE}" -o "${scratch}/pc-static-c" ${flags})
run("${scratch}/pc-static-c")
