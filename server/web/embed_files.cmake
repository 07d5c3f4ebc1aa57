cmake_minimum_required(VERSION 3.25)

# Writes the source that embeds the compressed files of a folder that build.mjs has made:
# cmake -DFOLDER=FOLDER -DTEMPLATE=assets.cpp.in -DOUTPUT=assets.cpp -P embed_files.cmake
# Without FOLDER it embeds none.
set(files "")
if(FOLDER)
  file(GLOB_RECURSE files RELATIVE ${FOLDER} ${FOLDER}/*.gz)
  if(NOT "page/index.html.gz" IN_LIST files)
    message(FATAL_ERROR "${FOLDER} is not what server/web/build.mjs makes: it has no page/index.html.gz")
  endif()
endif()

set(MESHGAUGE_BYTES "")
set(MESHGAUGE_SYMBOLS "")
set(MESHGAUGE_ASSETS "")
set(number 0)
foreach(file IN LISTS files)
  string(REGEX REPLACE "\\.gz$" "" name ${file})
  set(symbol meshgauge_asset_${number})
  string(APPEND MESHGAUGE_BYTES "MESHGAUGE_EMBED(\"${symbol}\", \"${FOLDER}/${file}\")\n")
  string(APPEND MESHGAUGE_SYMBOLS "extern const char ${symbol}[];\nextern const char ${symbol}_end[];\n")
  string(APPEND MESHGAUGE_ASSETS "      {\"${name}\", {${symbol}, ${symbol}_end}},\n")
  math(EXPR number "${number} + 1")
endforeach()
configure_file(${TEMPLATE} ${OUTPUT} @ONLY)
file(TOUCH ${OUTPUT})  # the contents may have changed although the names have not
