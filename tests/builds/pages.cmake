# Code and output in the pages of docs/.

# All blocks of `page` that begin with ```<fence>, in order.
function(blocks page fence result)
  file(READ ${page} rest)
  set(text)
  while("${rest}" MATCHES "```${fence}\n([^`]*)```(.*)")
    string(APPEND text "${CMAKE_MATCH_1}")
    set(rest "${CMAKE_MATCH_2}")
  endwhile()
  if(text STREQUAL "")
    message(FATAL_ERROR "${page}: no block begins with ```${fence}")
  endif()
  set(${result} "${text}" PARENT_SCOPE)
endfunction()

# Runs a program; its output must equal the text blocks of `page`.
function(run_as_shown page program)
  run(${program})
  blocks(${page} text shown)
  if(NOT output STREQUAL shown)
    message(FATAL_ERROR "${page} shows\n${shown}\nbut ${program} prints\n${output}")
  endif()
endfunction()
