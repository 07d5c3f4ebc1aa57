# Installs the build into an empty prefix, then configures, builds and runs the consumer against it.
# cmake -DBUILD_DIR=... -DSOURCE_DIR=... -DWORK_DIR=... -DCXX=... -DCXX_FLAGS=... -P check.cmake
file(REMOVE_RECURSE ${WORK_DIR})
file(MAKE_DIRECTORY ${WORK_DIR})

function(run)
  execute_process(COMMAND ${ARGV} COMMAND_ERROR_IS_FATAL ANY)
endfunction()

run(${CMAKE_COMMAND} --install ${BUILD_DIR} --prefix ${WORK_DIR}/prefix)
run(${CMAKE_COMMAND} -S ${SOURCE_DIR} -B ${WORK_DIR}/build -G Ninja -DCMAKE_BUILD_TYPE=Release
    -DCMAKE_CXX_COMPILER=${CXX} -DCMAKE_CXX_FLAGS=${CXX_FLAGS} -DCMAKE_PREFIX_PATH=${WORK_DIR}/prefix)

# The headers must come from the prefix, and the project's own flags must not reach the consumer.
file(READ ${WORK_DIR}/build/build.ninja rules)
string(FIND "${rules}" "${WORK_DIR}/prefix/include/meshgauge" from_prefix)
string(FIND "${rules}" "-Wconversion" strict)
if(from_prefix EQUAL -1 OR NOT strict EQUAL -1)
  message(FATAL_ERROR "the exported target is wrong: see ${WORK_DIR}/build/build.ninja")
endif()

run(${CMAKE_COMMAND} --build ${WORK_DIR}/build)
run(${WORK_DIR}/build/consumer)
if(EXISTS ${WORK_DIR}/prefix/bin/meshgauge)
  run(${WORK_DIR}/prefix/bin/meshgauge --version)
endif()
