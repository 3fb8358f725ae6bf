# Debian's googletest package: the sources.
set(GTest_FOUND FALSE)
if(EXISTS /usr/src/googletest/googletest/CMakeLists.txt)
  set(gtest_force_shared_crt ON)
  if(NOT TARGET GTest::gtest)
    add_subdirectory(/usr/src/googletest/googletest "${CMAKE_BINARY_DIR}/googletest" EXCLUDE_FROM_ALL)
  endif()
  set(GTest_FOUND TRUE)
endif()
