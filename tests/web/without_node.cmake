# Configures the project as on a machine without node: it says that there will be no pages, and goes on.
# cmake -DSOURCE_DIR=... -DWORK_DIR=... -P without_node.cmake
file(REMOVE_RECURSE ${WORK_DIR})
execute_process(COMMAND ${CMAKE_COMMAND} -G Ninja -S ${SOURCE_DIR} -B ${WORK_DIR} -DMESHGAUGE_NODE= -DMESHGAUGE_BUILD_TESTS=OFF
                RESULT_VARIABLE code OUTPUT_VARIABLE said ERROR_VARIABLE said)
if(NOT code EQUAL 0)
  message(FATAL_ERROR "It does not configure:\n${said}")
endif()
if(NOT said MATCHES "the service is built without its pages")
  message(FATAL_ERROR "It does not say what is missing:\n${said}")
endif()
file(STRINGS ${WORK_DIR}/build.ninja bundling REGEX "build\\.mjs")
if(bundling)
  message(FATAL_ERROR "It bundles all the same: ${bundling}")
endif()
