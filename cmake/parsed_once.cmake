# Precompiled headers: what nearly each file of a target includes is parsed once. The preset `single` goes without, so that a file
# which lacks an include shows there, and a true warning of those below.

# What nearly each file of the service, the gate and the command line includes.
set(SERVICE_HEADERS <algorithm> <chrono> <condition_variable> <deque> <filesystem> <functional> <map> <memory> <mutex> <optional> <set>
    <span> <string> <thread> <unordered_map> <variant> <vector> <nlohmann/json.hpp> [["api/compare/compare.h"]])

# parsed_once(TARGET HEADERS...)
function(parsed_once target)
  target_precompile_headers(${target} PRIVATE ${ARGN})
  without_false_warnings(${target})
endfunction()

# parsed_with(OTHER TARGET): by the header of another target, which is compiled with the same flags.
function(parsed_with other target)
  target_precompile_headers(${target} REUSE_FROM ${other})
  without_false_warnings(${target})
endfunction()

# For GCC, -fpch-preprocess lets ccache know what a precompiled header holds (CCACHE_SLOPPINESS=pch_defines,time_macros).
# From a precompiled header GCC forgets which headers are the system's. Its optimiser then warns of what it inlined from them:
# of GCC 12 these are false.
function(without_false_warnings target)
  if(NOT CMAKE_DISABLE_PRECOMPILE_HEADERS)
    foreach(option -fpch-preprocess -Wno-array-bounds -Wno-maybe-uninitialized -Wno-stringop-overflow -Wno-stringop-overread)
      target_compile_options(${target} PRIVATE $<$<CXX_COMPILER_ID:GNU>:${option}>)
    endforeach()
  endif()
endfunction()
