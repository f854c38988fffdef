# No module of WebAssembly loads a number into all lanes (cmake/toolchains/no_load_splat.py says why):
# cmake -DWASM_DIS=wasm-dis -DMODULES=a.wasm;b.wasm -P no_load_splat_test.cmake
foreach(module IN LISTS MODULES)
  if(NOT EXISTS ${module})
    message(FATAL_ERROR "${module} is missing; build everything first")
  endif()
  execute_process(COMMAND ${WASM_DIS} ${module} -o ${module}.wat RESULT_VARIABLE failed)
  if(failed)
    message(FATAL_ERROR "${WASM_DIS} ${module} ended with ${failed}")
  endif()
  file(STRINGS ${module}.wat vectors REGEX "v128\\.(load|const)" LIMIT_COUNT 1)
  file(STRINGS ${module}.wat splats REGEX "v128\\.load[0-9]+_splat")
  file(REMOVE ${module}.wat)
  list(LENGTH splats count)
  if(count OR NOT vectors) # without any vector, the expression no longer matches the disassembler's text
    message(FATAL_ERROR "${module} has ${count} loads into all lanes; compile every file through cmake/toolchains/no_load_splat.py")
  endif()
endforeach()
