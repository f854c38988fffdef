# cmake -DOUTPUT=x.cpp -DNAMESPACE=a::b -DFILES=one;two -P EmbedFiles.cmake
# Writes a source that holds each file as a constant of type std::string_view: page/main.js is main_js.
set(text "// Written by EmbedFiles.cmake.\n#include <string_view>\n\nnamespace ${NAMESPACE} {\n\n")
foreach(file IN LISTS FILES)
  get_filename_component(name ${file} NAME)
  string(MAKE_C_IDENTIFIER ${name} name)
  file(READ ${file} content)
  string(APPEND text "extern const std::string_view ${name};\nconst std::string_view ${name} = R\"oncollide(${content})oncollide\";\n\n")
endforeach()
file(WRITE ${OUTPUT} "${text}} // namespace ${NAMESPACE}\n")
