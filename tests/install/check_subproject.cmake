# psim's sources as a part of another project, with zones for its profiler: FetchContent and add_subdirectory configure and
# hand on nothing; one of the two is built, run and installed. Run by CTest with cmake -P.
set(scratch "${BUILD_DIR}/subproject-check")
file(REMOVE_RECURSE "${scratch}")

function(run)
  execute_process(COMMAND ${ARGN} RESULT_VARIABLE result OUTPUT_VARIABLE output ERROR_VARIABLE output)
  if(NOT result EQUAL 0)
    string(REPLACE ";" " " command "${ARGN}")
    message(FATAL_ERROR "${command}: exit ${result}\n${output}")
  endif()
endfunction()

foreach(by_fetch ON OFF)
  run(${CMAKE_COMMAND} -S "${CONSUMER_DIR}/subproject" -B "${scratch}/${by_fetch}" -G "${GENERATOR}"
      "-DCMAKE_CXX_COMPILER=${CXX}" "-DPSIM_SOURCES=${SOURCE_DIR}" -DBY_FETCH=${by_fetch} -DCMAKE_BUILD_TYPE=Release
      -DPSIM_ROOMS=ON)
endforeach()
run(${CMAKE_COMMAND} --build "${scratch}/ON")
run("${scratch}/ON/consumer")
run("${scratch}/ON/zones")

# An installation of that project has its own files alone.
run(${CMAKE_COMMAND} --install "${scratch}/ON" --prefix "${scratch}/prefix")
file(GLOB_RECURSE installed RELATIVE "${scratch}/prefix" "${scratch}/prefix/*")
if(NOT installed STREQUAL "bin/consumer")
  message(FATAL_ERROR "the project around psim installs ${installed}")
endif()
