# Embeds the pages / and /docs into the binary. build.mjs makes them by Node, from packages that `npm ci` installs in this
# folder; ./dev build runs it if there is an npm. Without npm the service answers 404 for its pages.
set(web ${CMAKE_CURRENT_SOURCE_DIR}/web)
set(web_out ${CMAKE_CURRENT_BINARY_DIR}/web)
set(MESHGAUGE_WEB_BUNDLE "" CACHE PATH "A folder that server/web/build.mjs has filled elsewhere, for a machine without node")
if(MESHGAUGE_NODE AND NOT EXISTS "${MESHGAUGE_NODE}")
  unset(MESHGAUGE_NODE CACHE)  # it was removed since the last run
endif()
find_program(MESHGAUGE_NODE node)
mark_as_advanced(MESHGAUGE_NODE)
set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS ${web}/package-lock.json)

set(bundle "")
set(bundling "")
set(sources ${web}/assets.cpp.in ${web}/embed_files.cmake)
if(MESHGAUGE_WEB_BUNDLE)
  set(bundle ${MESHGAUGE_WEB_BUNDLE})
  file(GLOB_RECURSE bundled CONFIGURE_DEPENDS ${bundle}/*.gz)
  list(APPEND sources ${bundled})
elseif(MESHGAUGE_NODE AND EXISTS ${web}/node_modules/.package-lock.json AND EXISTS ${web}/node_modules/esbuild
       AND EXISTS ${web}/node_modules/three AND EXISTS ${web}/node_modules/swagger-ui-dist)
  set(bundle ${web_out}/bundle)
  set(bundling COMMAND ${MESHGAUGE_NODE} ${web}/build.mjs ${bundle})
  file(GLOB_RECURSE page CONFIGURE_DEPENDS ${web}/page/*)
  list(APPEND sources ${page} ${web}/build.mjs ${web}/docs.html ${web}/docs.js ${web}/node_modules/.package-lock.json)
endif()

set(MESHGAUGE_HAS_PAGE OFF)
if(bundle)
  set(MESHGAUGE_HAS_PAGE ON)
else()
  message(STATUS "No node, or no packages in server/web: the service is built without its pages")
endif()
set(MESHGAUGE_HAS_PAGE ${MESHGAUGE_HAS_PAGE} CACHE INTERNAL "Whether the service has the pages / and /docs")

add_custom_command(
  OUTPUT ${web_out}/assets.cpp
  ${bundling}
  COMMAND ${CMAKE_COMMAND} -DFOLDER=${bundle} -DTEMPLATE=${web}/assets.cpp.in -DOUTPUT=${web_out}/assets.cpp
          -P ${web}/embed_files.cmake
  DEPENDS ${sources}
  COMMENT "Bundling the pages of the service"
  VERBATIM)
