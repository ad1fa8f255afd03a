# cmake -DBUILD_DIR=… -DSOURCE_DIR=… -DPREFIX=… -P installed_program_test.cmake
# What `cmake --install` puts down is complete, runs, and holds no path of the building machine.
file(REMOVE_RECURSE "${PREFIX}")
execute_process(COMMAND ${CMAKE_COMMAND} --install "${BUILD_DIR}" --prefix "${PREFIX}"
  OUTPUT_QUIET COMMAND_ERROR_IS_FATAL ANY)

foreach(file bin/reseau lib/udev/rules.d/60-reseau.rules share/doc/reseau/README.md)
  if(NOT EXISTS "${PREFIX}/${file}")
    message(FATAL_ERROR "${file} is not installed")
  endif()
endforeach()

execute_process(COMMAND "${PREFIX}/bin/reseau" --help OUTPUT_VARIABLE help
  COMMAND_ERROR_IS_FATAL ANY)
if(NOT help MATCHES "scan")
  message(FATAL_ERROR "the installed program does not explain itself: ${help}")
endif()

file(STRINGS "${PREFIX}/bin/reseau" found REGEX "${SOURCE_DIR}" LIMIT_COUNT 5)
if(found)
  message(FATAL_ERROR "the program holds paths of the building machine: ${found}")
endif()
