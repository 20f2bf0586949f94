# coppice_install_program(coppice_tool coppice completion [WITH coppice_lab])
# What `cmake --install` leaves of a program, component coppice_tools: the program, called `name`; its completion for bash, zsh and fish, which
# it prints when it is asked for with `completion` and the shell's name; and man pages, one for it and one for each of its sub-commands. All of
# that but the program is made by running it. WITH: programs that its commands start, installed beside it. The target coppice_tools builds all
# of that.
function(coppice_install_program target name completion)
  cmake_parse_arguments(ARG "" "" "WITH" ${ARGN})
  include(GNUInstallDirs)
  if(NOT TARGET coppice_tools)
    add_custom_target(coppice_tools)
  endif()
  add_dependencies(coppice_tools ${target} ${ARG_WITH})
  # Libraries of the system need no path; those that the build found elsewhere are found there by the installed program too.
  set_target_properties(${target} ${ARG_WITH} PROPERTIES INSTALL_RPATH_USE_LINK_PATH ON)
  install(TARGETS ${target} ${ARG_WITH} RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR} COMPONENT coppice_tools)
  if(CMAKE_CROSSCOMPILING AND NOT CMAKE_CROSSCOMPILING_EMULATOR)
    message(STATUS "${name}: no man pages and no completion, because it does not run on this machine")
    return()
  endif()

  set(completions ${PROJECT_BINARY_DIR}/completions)
  set(scripts)
  foreach(shell_file bash/${name} zsh/_${name} fish/${name}.fish)
    get_filename_component(shell ${shell_file} DIRECTORY)
    add_custom_command(
      OUTPUT ${completions}/${shell_file}
      COMMAND ${CMAKE_COMMAND} -E make_directory ${completions}/${shell}
      COMMAND ${target} ${completion} ${shell} > ${completions}/${shell_file}
      DEPENDS ${target}
      VERBATIM)
    list(APPEND scripts ${completions}/${shell_file})
  endforeach()
  add_custom_target(${target}_completion ALL DEPENDS ${scripts})
  add_dependencies(coppice_tools ${target}_completion)
  set(folders bash-completion/completions zsh/site-functions fish/vendor_completions.d)
  foreach(script folder IN ZIP_LISTS scripts folders)
    install(FILES ${script} DESTINATION ${CMAKE_INSTALL_DATAROOTDIR}/${folder} COMPONENT coppice_tools)
  endforeach()

  find_program(HELP2MAN help2man)
  if(NOT HELP2MAN)
    message(STATUS "${name}: no man pages, because there is no help2man")
    return()
  endif()
  set(script ${PROJECT_SOURCE_DIR}/bake/cli/command_line/write_manuals)
  set(manuals ${PROJECT_BINARY_DIR}/manuals/${name})
  add_custom_command(
    OUTPUT ${manuals}/man1/${name}.1
    COMMAND ${script} ${HELP2MAN} $<TARGET_FILE:${target}> ${PROJECT_VERSION} ${manuals}/man1
    DEPENDS ${target} ${ARG_WITH} ${script}
    COMMENT "Man pages of ${name}"
    VERBATIM)
  add_custom_target(${target}_manuals ALL DEPENDS ${manuals}/man1/${name}.1)
  add_dependencies(coppice_tools ${target}_manuals)
  install(DIRECTORY ${manuals}/man1 DESTINATION ${CMAKE_INSTALL_MANDIR} COMPONENT coppice_tools)
endfunction()
