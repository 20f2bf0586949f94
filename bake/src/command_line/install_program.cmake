# coppice_install_program(coppice_tool coppice)
# What `cmake --install` leaves of a program, component coppice_tools: the program, called `name`, and its man pages, one for it and one for
# each of its sub-commands, made by running it. The target coppice_tools builds all of that.
function(coppice_install_program target name)
  include(GNUInstallDirs)
  if(NOT TARGET coppice_tools)
    add_custom_target(coppice_tools)
  endif()
  add_dependencies(coppice_tools ${target})
  # Libraries of the system need no path; those that the build found elsewhere are found there by the installed program too.
  set_target_properties(${target} PROPERTIES INSTALL_RPATH_USE_LINK_PATH ON)
  install(TARGETS ${target} RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR} COMPONENT coppice_tools)
  if(CMAKE_CROSSCOMPILING AND NOT CMAKE_CROSSCOMPILING_EMULATOR)
    message(STATUS "${name}: no man pages, because it does not run on this machine")
    return()
  endif()
  find_program(HELP2MAN help2man)
  if(NOT HELP2MAN)
    message(STATUS "${name}: no man pages, because there is no help2man")
    return()
  endif()
  set(script ${PROJECT_SOURCE_DIR}/bake/src/command_line/write_manuals)
  set(manuals ${PROJECT_BINARY_DIR}/manuals/${name})
  add_custom_command(
    OUTPUT ${manuals}/man1/${name}.1
    COMMAND ${script} ${HELP2MAN} $<TARGET_FILE:${target}> ${PROJECT_VERSION} ${manuals}/man1
    DEPENDS ${target} ${script}
    COMMENT "Man pages of ${name}"
    VERBATIM)
  add_custom_target(${target}_manuals ALL DEPENDS ${manuals}/man1/${name}.1)
  add_dependencies(coppice_tools ${target}_manuals)
  install(DIRECTORY ${manuals}/man1 DESTINATION ${CMAKE_INSTALL_MANDIR} COMPONENT coppice_tools)
endfunction()
