# The files of /docs become part of the binary. swagger-ui's are there after `npm ci` in this folder (./dev build runs it
# when there is an npm); without them the service says that it has no such page.
set(web ${CMAKE_CURRENT_SOURCE_DIR}/web)
set(swagger ${web}/node_modules/swagger-ui-dist)
set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS ${web}/package-lock.json)

set(files "")
set(MESHGAUGE_HAS_DOCS OFF CACHE INTERNAL "Whether the service has the page /docs")
if(EXISTS ${swagger}/swagger-ui-bundle.js)
  set(MESHGAUGE_HAS_DOCS ON CACHE INTERNAL "")
  set(files ${web}/docs.html ${web}/docs.js ${swagger}/swagger-ui-bundle.js ${swagger}/swagger-ui.css
            ${swagger}/favicon-32x32.png ${swagger}/LICENSE ${swagger}/NOTICE ${swagger}/swagger-ui-bundle.js.LICENSE.txt)
endif()

set(MESHGAUGE_BYTES "")
set(MESHGAUGE_SYMBOLS "")
set(MESHGAUGE_ASSETS "")
set(number 0)
foreach(file ${files})
  get_filename_component(name ${file} NAME)
  set(symbol meshgauge_asset_${number})
  string(APPEND MESHGAUGE_BYTES "MESHGAUGE_EMBED(\"${symbol}\", \"${file}\")\n")
  string(APPEND MESHGAUGE_SYMBOLS "extern const char ${symbol}[];\nextern const char ${symbol}_end[];\n")
  string(APPEND MESHGAUGE_ASSETS "      {\"${name}\", {${symbol}, ${symbol}_end}},\n")
  math(EXPR number "${number} + 1")
endforeach()
configure_file(${web}/assets.cpp.in ${CMAKE_CURRENT_BINARY_DIR}/web/assets.cpp @ONLY)
set_source_files_properties(${CMAKE_CURRENT_BINARY_DIR}/web/assets.cpp PROPERTIES OBJECT_DEPENDS "${files}")
