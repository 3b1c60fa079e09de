# Warnings as errors for our own code; dependencies are SYSTEM and stay quiet.
add_library(slamfuse_compile_options INTERFACE)
target_compile_features(slamfuse_compile_options INTERFACE cxx_std_20)
target_compile_options(slamfuse_compile_options INTERFACE -Wall -Wextra -Wpedantic -Wshadow -Wconversion
                       -Wno-sign-conversion -Wnon-virtual-dtor -Woverloaded-virtual -Werror)

set(SLAMFUSE_SANITIZE "" CACHE STRING "Sanitizers for every target, e.g. address,undefined or thread")
if(SLAMFUSE_SANITIZE)
  add_compile_options(-fsanitize=${SLAMFUSE_SANITIZE} -fno-omit-frame-pointer -fno-sanitize-recover=all)
  add_link_options(-fsanitize=${SLAMFUSE_SANITIZE})
  # What the sanitizers put in makes gcc take Eigen's variables for uninitialised; the release build warns of real ones.
  target_compile_options(slamfuse_compile_options INTERFACE $<$<CXX_COMPILER_ID:GNU>:-Wno-maybe-uninitialized>)
endif()

# Every target is instrumented for libFuzzer; the programs of tests/fuzz link it. Needs clang.
option(SLAMFUSE_FUZZ "Build the fuzzers" OFF)
if(SLAMFUSE_FUZZ)
  add_compile_options(-fsanitize=fuzzer-no-link)
  target_compile_options(slamfuse_compile_options INTERFACE -Wno-error)  # clang warns of other things than gcc
endif()

option(SLAMFUSE_COVERAGE "Instrument for gcov" OFF)
if(SLAMFUSE_COVERAGE)
  add_compile_options(--coverage)
  add_link_options(--coverage)
endif()
