# Installs the library, builds examples/ on it and looks at what each prints. Run by CTest with
# cmake -P.
set(scratch "${BUILD_DIR}/examples-check")
file(REMOVE_RECURSE "${scratch}")

function(run)
  execute_process(COMMAND ${ARGN} RESULT_VARIABLE result OUTPUT_VARIABLE output ERROR_VARIABLE output)
  string(STRIP "${output}" output)
  if(NOT result EQUAL 0)
    string(REPLACE ";" " " command "${ARGN}")
    message(FATAL_ERROR "${command}: exit ${result}\n${output}")
  endif()
  set(output "${output}" PARENT_SCOPE)
endfunction()

# Runs an example; its whole output has to match.
function(example expected)
  run(${ARGN})
  message(STATUS "${output}")
  if(NOT output MATCHES "^${expected}$")
    message(FATAL_ERROR "${ARGN} printed\n${output}\nwhich is not\n${expected}")
  endif()
endfunction()

run(${CMAKE_COMMAND} --install "${BUILD_DIR}" --component psim_library --prefix "${scratch}/prefix")
run(${CMAKE_COMMAND} -S "${EXAMPLES_DIR}" -B "${scratch}/build" -G "${GENERATOR}"
    "-DCMAKE_CXX_COMPILER=${CXX}" "-DCMAKE_C_COMPILER=${CC}" -DCMAKE_BUILD_TYPE=Release
    "-DCMAKE_PREFIX_PATH=${scratch}/prefix" "-DCMAKE_C_FLAGS=-Wall -Wextra -Wpedantic -Werror"
    "-DCMAKE_CXX_FLAGS=-Wall -Wextra -Wconversion -Wpedantic -Werror")
run(${CMAKE_COMMAND} --build "${scratch}/build")

file(GLOB sources "${EXAMPLES_DIR}/*.c" "${EXAMPLES_DIR}/*.cpp" "${EXAMPLES_DIR}/*.py")
foreach(source IN LISTS sources)
  file(READ "${source}" text)
  string(REGEX REPLACE "[^\n]" "" newlines "${text}")
  string(LENGTH "${newlines}" count)
  if(count GREATER_EQUAL 80)
    message(FATAL_ERROR "${source} has ${count} lines; an example stays under 80")
  endif()
endforeach()

set(bin "${scratch}/build")
example("after 1 s the disc is at y = -4\\.9[0-9]+ m" "${bin}/hello_disc")
example("6[0-9] steps, 14[0-9] pictures, speed on the screen 3 m/s \\+- 0\\.00[0-9]+" "${bin}/game_loop")
example("[0-9a-f]+ on one thread\n[0-9a-f]+ on the pool" "${bin}/own_job_system")
example("spawned in [0-9.]+ ms, then [0-9.]+ ms a step\n100000 discs, the highest at y = -?[0-9.]+ m"
        "${bin}/bulk_spawn")
example("0\\.[0-9]+ s: the floor was hit at x = 3\\.[0-9] with 8\\.[0-9] m/s\n.*1\\.[0-9]+ s: goal!\n.*out of the goal.*"
        "${bin}/events")
example("stands: at [^\n]*\n.*rides: at \\(1[5-8]\\.[0-9], 4\\.[0-9]\\), where it should be" "${bin}/platformer")
example(".*\\(150, [0-9.]+\\) with (9|10|11)\\.[0-9] m/s
the springs moved 0\\.1[0-9]+ m, the wheels left their axis by [0-9.]+e-0[4-9] m" "${bin}/car")
example(".*2\\.0 s: the hip is at \\([0-9.]+, -1\\.[0-9]\\)
widest gap [0-9.]+e-0[3-9] m, farthest past a limit [0-9.]+e-0[2-9] rad, at rest" "${bin}/ragdoll")
example("25 kg: the ends carry (9\\.9|10\\.[01])[0-9] kN of 10\\.06 kN
50 kg: [^\n]*
.*[0-9]+ kg: pin [0-9]+ breaks with [6-9][0-9]\\.[0-9] kN
the crate is at y = -[0-9]+ m, [0-9]+ of 21 pins are left" "${bin}/bridge")
example("bin red: 15 red, 0 blue
bin blue, left: 0 red, [0-9]+ blue
bin blue, right: 0 red, [0-9]+ blue
0 parcels are left" "${bin}/conveyor")
example("ball 1 [^\n]*
.*ball 9 is lost after [0-9.]+ s, score [1-9][0-9]*00
the flippers passed their limits by 0\\.0[0-9]+ rad" "${bin}/pinball")
example(".*dry road: 0\\.[0-4] m from the crossing with 12\\.0 m/s, drifted by up to 0\\.5 degrees
wet road: [^\n]* up to 5[0-9]\\.[0-9] degrees
the tyres gave up to 1\\.000 and 1\\.000 of their grip" "${bin}/topdown_cars")
example("21 rollbacks, each of [0-9.]+ steps, [0-9.]+ ms; a state has [0-9]+ bytes
the end has the same bits as with all inputs on time" "${bin}/rollback")
if(PSIM)  # the program reads the level
  run("${PSIM}" --scene "${EXAMPLES_DIR}/rube_level.json" --frames 0 --save "${scratch}/level.state")
  example("bodies: 10, joints: 1
[34]\\.[0-9] s: the last domino rings the bell
6 dominoes have fallen, [^\n]* turns with 2\\.00 rad/s" "${bin}/rube_level" "${scratch}/level.state")
endif()
example("the ball is at \\(.*\\)\n(the wall is [0-7]\\.[0-9] m high|nothing is left of the wall)" "${bin}/c_api")
file(GLOB_RECURSE shared "${scratch}/prefix/*/libpsim.so")
example("psim [0-9.]+: 1000 discs fell [34]\\.[0-9]+ m in a second"
        "${PYTHON}" "${EXAMPLES_DIR}/python_ctypes.py" "${shared}")
execute_process(COMMAND "${PYTHON}" "${EXAMPLES_DIR}/python_ctypes.py" none/libpsim.so
  RESULT_VARIABLE status ERROR_VARIABLE said OUTPUT_QUIET)
if(status EQUAL 0 OR NOT said MATCHES "^none/libpsim.so: [^\n]*; name the library: [^\n]*\n$")
  message(FATAL_ERROR "python_ctypes.py without its library: ${status}, ${said}")
endif()
