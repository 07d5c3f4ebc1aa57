# cmake --install gives the binary and the engine as a library: find_package(meshgauge), meshgauge::engine.
include(CMakePackageConfigHelpers)

set(meshgauge_package_dir ${CMAKE_INSTALL_LIBDIR}/cmake/meshgauge)

install(TARGETS meshgauge_engine EXPORT meshgauge_targets ARCHIVE COMPONENT engine)
# The face of the engine alone: what hausdorff.h includes.
install(FILES engine/hausdorff.h engine/mesh.h engine/options.h engine/outcome.h engine/control.h engine/result.h
              engine/area.h engine/region.h engine/sides.h engine/statistics.h engine/thresholds.h engine/vector.h
        DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/meshgauge/engine COMPONENT engine)
install(EXPORT meshgauge_targets NAMESPACE meshgauge:: DESTINATION ${meshgauge_package_dir} COMPONENT engine)

configure_package_config_file(cmake/meshgaugeConfig.cmake.in ${PROJECT_BINARY_DIR}/meshgaugeConfig.cmake
                              INSTALL_DESTINATION ${meshgauge_package_dir})
write_basic_package_version_file(${PROJECT_BINARY_DIR}/meshgaugeConfigVersion.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${PROJECT_BINARY_DIR}/meshgaugeConfig.cmake ${PROJECT_BINARY_DIR}/meshgaugeConfigVersion.cmake
        DESTINATION ${meshgauge_package_dir} COMPONENT engine)

if(TARGET meshgauge)
  install(TARGETS meshgauge RUNTIME COMPONENT service)
  install(FILES check/gates.schema.json DESTINATION ${CMAKE_INSTALL_DATADIR}/meshgauge COMPONENT service)
endif()
