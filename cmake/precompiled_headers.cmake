# Two thirds of the time a file takes to compile is spent in other people's headers. The most frequent ones are compiled
# once for position-independent code, once for the rest and once, with GoogleTest, for tests, and used by every target
# that has our compile options. Our own headers are never among them: changing one would compile everything again.
#
# A missing #include of one of these is not seen then; scripts/lint and the fuzzers compile without.
set(SLAMFUSE_FREQUENT_HEADERS
    <algorithm>
    <chrono>
    <filesystem>
    <functional>
    <map>
    <memory>
    <optional>
    <string>
    <variant>
    <vector>
    <Eigen/Cholesky>
    <Eigen/Geometry>
    <Eigen/LU>
    <tl/expected.hpp>)

# slamfuse_precompile(DIRECTORY...): for all targets of these directories.
function(slamfuse_precompile)
  file(WRITE ${PROJECT_BINARY_DIR}/precompiled_headers.cpp "")
  foreach(kind library program test)
    add_library(slamfuse_${kind}_headers OBJECT EXCLUDE_FROM_ALL ${PROJECT_BINARY_DIR}/precompiled_headers.cpp)
    target_link_libraries(slamfuse_${kind}_headers PRIVATE Eigen3::Eigen slamfuse_compile_options)
    target_precompile_headers(slamfuse_${kind}_headers PRIVATE ${SLAMFUSE_FREQUENT_HEADERS})
  endforeach()
  set_target_properties(slamfuse_library_headers PROPERTIES POSITION_INDEPENDENT_CODE ON)
  if(SLAMFUSE_BUILD_TESTS)
    target_link_libraries(slamfuse_test_headers PRIVATE GTest::gmock)
    target_precompile_headers(slamfuse_test_headers PRIVATE <gmock/gmock.h> <gtest/gtest.h>)
  endif()

  foreach(directory ${ARGN})
    get_property(targets DIRECTORY ${directory} PROPERTY BUILDSYSTEM_TARGETS)
    foreach(target ${targets})
      get_target_property(libraries ${target} LINK_LIBRARIES)
      get_target_property(independent ${target} POSITION_INDEPENDENT_CODE)
      if(NOT "${libraries}" MATCHES "slamfuse_compile_options")
        continue()
      elseif("${libraries}" MATCHES "GTest::")
        target_precompile_headers(${target} REUSE_FROM slamfuse_test_headers)
      elseif(independent)
        target_precompile_headers(${target} REUSE_FROM slamfuse_library_headers)
      else()
        target_precompile_headers(${target} REUSE_FROM slamfuse_program_headers)
      endif()
    endforeach()
  endforeach()
endfunction()
