# Adds the system files that the command needs to the archive (not to the .deb), so that it runs after unpacking in any
# folder:
#   bin/PROGRAM                   a script that finds the rest (launcher.sh); PROGRAM: oncollide or oncollide-lab
#   lib/PROGRAM/PROGRAM           the program; it and its libraries look for each other in their own folder ($ORIGIN)
#   lib/PROGRAM/libc/             the C library, for systems whose own is older
#   lib/PROGRAM/gl/               the loaders of OpenGL and EGL, for systems that have a driver but no loader; vendors/ names
#                                 NVIDIA's driver, which containers often forget
#   share/PROGRAM/three/          three.js, which pages draw with, if Debian's libjs-three is installed
if(NOT CPACK_GENERATOR STREQUAL "TGZ")
  return()
endif()
find_program(PATCHELF patchelf REQUIRED)
set(root ${CPACK_TEMPORARY_INSTALL_DIRECTORY})
set(program ${CPACK_PACKAGE_NAME})
set(home ${root}/lib/${program})
file(MAKE_DIRECTORY ${home}/libc)
file(RENAME ${root}/bin/${program} ${home}/${program})
if(EXISTS ${root}/libexec/${program}/oncollide-ifc) # as far from share/ as before
  file(RENAME ${root}/libexec/${program}/oncollide-ifc ${home}/oncollide-ifc)
endif()
file(GET_RUNTIME_DEPENDENCIES EXECUTABLES ${home}/${program} RESOLVED_DEPENDENCIES_VAR libraries)
foreach(library IN LISTS libraries)
  get_filename_component(name ${library} NAME)
  get_filename_component(file ${library} REALPATH)
  if(name MATCHES "^(ld-linux.*|lib(c|m|dl|pthread|rt))\\.so")
    file(COPY_FILE ${file} ${home}/libc/${name})
  else()
    file(COPY_FILE ${file} ${home}/${name})
    list(APPEND bundled ${home}/${name})
  endif()
endforeach()
list(FILTER libraries INCLUDE REGEX "/libepoxy\\.so")
if(libraries) # a build with OpenGL; these are opened by name
  get_filename_component(folder ${libraries} DIRECTORY)
  foreach(name IN ITEMS libEGL.so.1 libOpenGL.so.0 libGLdispatch.so.0)
    get_filename_component(file ${folder}/${name} REALPATH)
    file(MAKE_DIRECTORY ${home}/gl/vendors)
    file(COPY_FILE ${file} ${home}/gl/${name})
    list(APPEND bundled ${home}/gl/${name})
  endforeach()
  file(WRITE ${home}/gl/vendors/10_nvidia.json
       [[{"file_format_version": "1.0.0", "ICD": {"library_path": "libEGL_nvidia.so.0"}}]] "\n")
endif()
foreach(file IN LISTS bundled ITEMS ${home}/${program})
  # DT_RPATH instead of DT_RUNPATH: it also applies to indirect dependencies.
  execute_process(COMMAND ${PATCHELF} --force-rpath --set-rpath "$ORIGIN" ${file} COMMAND_ERROR_IS_FATAL ANY)
endforeach()
set(three /usr/share/javascript/three)
if(EXISTS ${three}/three.min.js AND EXISTS ${three}/examples/js/controls/OrbitControls.js)
  file(INSTALL ${three}/three.min.js /usr/share/doc/libjs-three/copyright DESTINATION ${root}/share/${program}/three FOLLOW_SYMLINK_CHAIN)
  file(INSTALL ${three}/examples/js/controls/OrbitControls.js DESTINATION ${root}/share/${program}/three/examples/js/controls)
else()
  message(WARNING "The archive comes without three.js: 'run --view' will need it. Install Debian's libjs-three before packing.")
endif()
# The minimum version of the C library: the newest version that the command or a library requires.
set(needed 0)
foreach(file IN LISTS bundled ITEMS ${home}/${program})
  execute_process(COMMAND objdump -T ${file} OUTPUT_VARIABLE symbols COMMAND_ERROR_IS_FATAL ANY)
  string(REGEX MATCHALL "GLIBC_2\\.[0-9]+" versions "${symbols}")
  foreach(version IN LISTS versions)
    string(REPLACE "GLIBC_2." "" version ${version})
    if(version GREATER needed)
      set(needed ${version})
    endif()
  endforeach()
endforeach()
file(GLOB loader RELATIVE ${home}/libc ${home}/libc/ld-linux*)
configure_file(${CMAKE_CURRENT_LIST_DIR}/launcher.sh ${root}/bin/${program} @ONLY FILE_PERMISSIONS
  OWNER_READ OWNER_WRITE OWNER_EXECUTE GROUP_READ GROUP_EXECUTE WORLD_READ WORLD_EXECUTE)
