# embed_tables(OUTPUT_ROOT FILES...): turns each data/NAME.csv into rows of C++ initialisers,
# OUTPUT_ROOT/core/color/data/NAME.inc, so that the tables are compiled in and no file is read at
# run time. Comment lines (#) and the header line are left out; words become string literals. Runs
# when the project is configured, and again when a table changes.
function(embed_tables output_root)
  foreach(file IN LISTS ARGN)
    set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS "${CMAKE_CURRENT_SOURCE_DIR}/${file}")
    file(STRINGS "${CMAKE_CURRENT_SOURCE_DIR}/${file}" lines REGEX "^[^#]")
    list(POP_FRONT lines header)
    string(REGEX MATCHALL "," commas "${header}")
    set(text "// ${header}\n")
    foreach(line IN LISTS lines)
      string(REGEX MATCHALL "," line_commas "${line}")
      if(NOT "${line_commas}" STREQUAL "${commas}")
        message(FATAL_ERROR "${file}: '${line}' has not the columns '${header}'")
      endif()
      string(REGEX REPLACE "(^|,)([A-Za-z][^,]*)" "\\1\"\\2\"" line "${line}")
      string(APPEND text "{${line}},\n")
    endforeach()
    string(REGEX REPLACE "\\.csv$" ".inc" include_name "${file}")
    file(CONFIGURE OUTPUT "${output_root}/core/${include_name}" CONTENT "${text}" @ONLY)
  endforeach()
endfunction()

# embed_texts(OUTPUT_ROOT FILES...): each data/NAME.csv as one string literal,
# OUTPUT_ROOT/core/color/data/NAME.text.inc, for tables that are parsed like a person's own.
function(embed_texts output_root)
  foreach(file IN LISTS ARGN)
    set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS "${CMAKE_CURRENT_SOURCE_DIR}/${file}")
    file(READ "${CMAKE_CURRENT_SOURCE_DIR}/${file}" text)
    string(REGEX REPLACE "\\.csv$" ".text.inc" include_name "${file}")
    file(CONFIGURE OUTPUT "${output_root}/core/${include_name}" CONTENT "R\"csv(${text})csv\"" @ONLY)
  endforeach()
endfunction()
