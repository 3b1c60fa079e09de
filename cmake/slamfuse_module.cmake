# slamfuse_module(NAME SOURCES ... [PUBLIC libs...] [PRIVATE libs...])
# One static library a module, alias slamfuse::NAME. Headers are included as "<module>/<header>.hpp" from the repository
# root; installed they stand in include/slamfuse/<module>/.
function(slamfuse_module name)
  cmake_parse_arguments(ARG "" "" "SOURCES;PUBLIC;PRIVATE" ${ARGN})
  add_library(slamfuse_${name} STATIC ${ARG_SOURCES})
  add_library(slamfuse::${name} ALIAS slamfuse_${name})
  target_include_directories(slamfuse_${name} PUBLIC $<BUILD_INTERFACE:${PROJECT_SOURCE_DIR}>
                             $<INSTALL_INTERFACE:include/slamfuse>)
  target_compile_features(slamfuse_${name} PUBLIC cxx_std_20)
  target_link_libraries(slamfuse_${name} PUBLIC ${ARG_PUBLIC} PRIVATE ${ARG_PRIVATE}
                        $<BUILD_INTERFACE:slamfuse_compile_options>)
  set_target_properties(slamfuse_${name} PROPERTIES EXPORT_NAME ${name} POSITION_INDEPENDENT_CODE ON)
  install(TARGETS slamfuse_${name} EXPORT slamfuseTargets ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR})
  install(DIRECTORY ${CMAKE_CURRENT_SOURCE_DIR}/ DESTINATION include/slamfuse/${name} FILES_MATCHING PATTERN "*.hpp")
endfunction()

# slamfuse_test(MODULE SOURCES ... LIBS ...): the GoogleTest program test_<module>, its cases registered with CTest one by one.
function(slamfuse_test module)
  cmake_parse_arguments(ARG "" "" "SOURCES;LIBS" ${ARGN})
  add_executable(test_${module} ${ARG_SOURCES})
  target_link_libraries(test_${module} PRIVATE ${ARG_LIBS} GTest::gmock GTest::gtest_main slamfuse_compile_options)
  target_include_directories(test_${module} PRIVATE ${PROJECT_SOURCE_DIR}/tests)
  target_compile_definitions(test_${module} PRIVATE SLAMFUSE_DATA_DIR="${PROJECT_SOURCE_DIR}/data"
                             SLAMFUSE_CONFIG_DIR="${PROJECT_SOURCE_DIR}/config")
  gtest_discover_tests(test_${module} TEST_PREFIX "${module}." PROPERTIES TIMEOUT 300 LABELS ${module} DISCOVERY_TIMEOUT 60)
endfunction()
