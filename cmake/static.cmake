# One program without shared libraries, which runs on every Linux: docs/packaging.md. Debian has no static form of some
# libraries; packaging/static_libraries makes them, and the preset `package` names their folder in CMAKE_LIBRARY_PATH.
set(CMAKE_FIND_LIBRARY_SUFFIXES .a)
set(CMAKE_SKIP_RPATH ON)
set(OPENSSL_USE_STATIC_LIBS ON)
string(APPEND CMAKE_EXE_LINKER_FLAGS " -static-pie -Wl,--gc-sections")
add_link_options(-Wl,-Map=${PROJECT_BINARY_DIR}/$<TARGET_PROPERTY:NAME>.map)  # which libraries it contains: packaging/sbom.py
link_directories(${CMAKE_LIBRARY_PATH})
# What static libraries need themselves, last on the line of the linker: first libpq, last cpp-httplib.
set(CMAKE_CXX_STANDARD_LIBRARIES "-lpgcommon -lpgport -l:libssl.a -l:libcrypto.a -l:libz.a -lbrotlienc -lbrotlidec -lbrotlicommon")
# libpq.pc names Debian's folder, which would come first; the libpq.a there needs Kerberos and LDAP.
find_library(pkgcfg_lib_libpq_pq pq PATHS ${CMAKE_LIBRARY_PATH} NO_DEFAULT_PATH REQUIRED)
