# What makes a defect of memory harder to use: tests/operations/test_hardening.py reads it off the built program.
# Sanitizers have checks of their own, and do not go with some of these.
# Programs are position independent by the compiler's default: CMake's own -pie would undo the readers' -static-pie.
if(NOT MESHGAUGE_SANITIZE AND NOT MESHGAUGE_FUZZERS)
  target_compile_options(meshgauge_flags INTERFACE -fstack-protector-strong -fstack-clash-protection
    $<$<CONFIG:Release,RelWithDebInfo,MinSizeRel>:-U_FORTIFY_SOURCE$<SEMICOLON>-D_FORTIFY_SOURCE=3>)
  if(CMAKE_SYSTEM_PROCESSOR MATCHES "x86_64|AMD64")
    target_compile_options(meshgauge_flags INTERFACE -fcf-protection=full)
  elseif(CMAKE_SYSTEM_PROCESSOR MATCHES "aarch64|arm64")
    target_compile_options(meshgauge_flags INTERFACE -mbranch-protection=standard)
  endif()
  # Not in the engine, whose searches it slows; tests/engine runs with it under the asan preset.
  target_compile_definitions(meshgauge_flags INTERFACE
    $<$<NOT:$<STREQUAL:$<TARGET_PROPERTY:NAME>,meshgauge_engine>>:_GLIBCXX_ASSERTIONS>)
  target_link_options(meshgauge_flags INTERFACE -Wl,-z,relro,-z,now,-z,noexecstack)
endif()
