# The modules of a WebAssembly build; with PSIM_WEB_THREADS their names end with -threads.
#   program.js       psim itself for Node, which web/psim.mjs starts
#   psim-simd.mjs    the library for pages and Node, which packaging/npm wraps, without the scalar kernels
#   psim-plain.mjs   the same for browsers without SIMD, with no other kernels
set(_suffix "")
if(PSIM_WEB_THREADS)
  set(_suffix "-threads")
endif()
set(_memory -sALLOW_MEMORY_GROWTH -sINITIAL_MEMORY=32MB)

# What is no kernel is inlined less than by default: a sixth less code for a few percent of the time.
foreach(_target psim_core_objects psim_capi_objects psim_scene)
  target_compile_options(${_target} PRIVATE "SHELL:-mllvm -inline-threshold=50")
endforeach()

# Node's own files; the program's thread is not Node's first one, so that it may wait for others.
set_target_properties(psim PROPERTIES OUTPUT_NAME "program${_suffix}")
target_link_options(psim PRIVATE ${_memory} -sMAXIMUM_MEMORY=4GB -sENVIRONMENT=node -sNODERAWFS=1 -sMODULARIZE
                    -sEXPORT_NAME=psim -sEXIT_RUNTIME)
if(PSIM_WEB_THREADS)
  target_link_options(psim PRIVATE -sPROXY_TO_PTHREAD -sENVIRONMENT=node,worker)
endif()

# The functions of the C API that JavaScript calls as they are; those of src/web mark themselves.
set(_exported _malloc _free)
foreach(_name version isa_name parse_isa isa_available best_isa world_destroy last_error world_enable_snapshots
        world_set_sleeping world_prepare world_memory_bytes world_isa world_body_count
        world_dynamic_count world_joint_count)
  list(APPEND _exported _psim_${_name})
endforeach()
list(JOIN _exported "," _exported)

# psim_web_module(NAME DEFINITION): the library as an ES module. It sees no file. What names the instruction sets comes
# with the sources and not from the archive, and so do not the kernels that it does not name under the definition.
function(psim_web_module name definition)
  add_executable(${name} src/web/flat_scene.cpp src/web/flat_world.cpp src/web/flat_fluids.cpp src/core/base/isa.cpp)
  psim_target_defaults(${name})
  target_compile_definitions(${name} PRIVATE ${definition})
  target_include_directories(${name} PRIVATE include src/capi src/scene src/core src/kernels)
  target_link_libraries(${name} PRIVATE psim_scene)
  set_target_properties(${name} PROPERTIES OUTPUT_NAME "${name}${_suffix}" SUFFIX .mjs)
  target_link_options(${name} PRIVATE -O3 ${_memory} -sMAXIMUM_MEMORY=2GB -sENVIRONMENT=web,worker --no-entry
                      -sFILESYSTEM=0 -sMODULARIZE -sEXPORT_ES6 -sEXPORT_NAME=psim "-sEXPORTED_FUNCTIONS=${_exported}"
                      -sEXPORTED_RUNTIME_METHODS=UTF8ToString,stringToUTF8,lengthBytesUTF8)
  if(PSIM_WEB_THREADS)
    target_link_options(${name} PRIVATE "-sPTHREAD_POOL_SIZE=Module.threads-1")
  endif()
endfunction()
psim_web_module(psim-simd PSIM_SIMD_ALONE)
if(NOT PSIM_WEB_THREADS)
  psim_web_module(psim-plain PSIM_PORTABLE)
endif()
