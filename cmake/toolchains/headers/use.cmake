# For a target that has no packages of its own: find_package takes what this machine has as headers (nlohmann-json,
# CLI11, fmt) or as sources (GoogleTest) from the files in this folder.
foreach(_package nlohmann_json CLI11 fmt GTest)
  set(${_package}_DIR "${CMAKE_CURRENT_LIST_DIR}")
endforeach()

# A folder with nothing but these headers: /usr/include itself would bring this machine's C library along.
function(psim_headers target folder)
  if(TARGET ${target})
    return()
  endif()
  set(_headers "${CMAKE_BINARY_DIR}/headers")
  if(NOT EXISTS "/usr/include/${folder}")
    set(${CMAKE_FIND_PACKAGE_NAME}_FOUND FALSE PARENT_SCOPE)
    return()
  endif()
  file(MAKE_DIRECTORY "${_headers}")
  file(CREATE_LINK "/usr/include/${folder}" "${_headers}/${folder}" SYMBOLIC)
  add_library(${target} INTERFACE IMPORTED GLOBAL)
  target_include_directories(${target} INTERFACE "${_headers}")
endfunction()
