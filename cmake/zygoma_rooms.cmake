# One static library per room. Sources are globbed so that adding a file to a room is adding a file;
# every header of a room is public and must compile alone (all_verify_interface_header_sets).
include_guard()

set_property(GLOBAL PROPERTY GLOBAL_DEPENDS_NO_CYCLES ON)
set(CMAKE_VERIFY_INTERFACE_HEADER_SETS ON)
set(CMAKE_EXPORT_COMPILE_COMMANDS ON)
set(CMAKE_CXX_STANDARD 20)
set(CMAKE_CXX_STANDARD_REQUIRED ON)
set(CMAKE_CXX_EXTENSIONS OFF)

if(NOT CMAKE_BUILD_TYPE AND NOT CMAKE_CONFIGURATION_TYPES)
  set(CMAKE_BUILD_TYPE Release CACHE STRING "" FORCE)
endif()

find_program(CCACHE_PROGRAM ccache)
if(CCACHE_PROGRAM AND NOT CMAKE_CXX_COMPILER_LAUNCHER)
  set(CMAKE_CXX_COMPILER_LAUNCHER "${CCACHE_PROGRAM}")
endif()

# Flags for our own targets. -ffp-contract=off: fused multiply-add would make the last bits depend
# on the compiler's choices, and "same bits for 1 and N threads" is a promise.
function(zygoma_compile_options target)
  target_compile_options(${target} PRIVATE
    -ffp-contract=off -Wall -Wextra -Wpedantic -Wshadow -Wconversion -Wno-sign-conversion
    -Wnon-virtual-dtor -Wold-style-cast
    # GCC 12 sees copies of 2^63 characters in additions of strings (its bug 105651).
    $<$<AND:$<CXX_COMPILER_ID:GNU>,$<VERSION_LESS:$<CXX_COMPILER_VERSION>,13>>:-Wno-restrict>
    $<$<BOOL:${ZYGOMA_WARNINGS_AS_ERRORS}>:-Werror>)
  if(ZYGOMA_SANITIZE)
    target_compile_options(${target} PRIVATE -fsanitize=${ZYGOMA_SANITIZE} -fno-omit-frame-pointer)
    target_link_options(${target} PRIVATE -fsanitize=${ZYGOMA_SANITIZE})
  endif()
endfunction()

# zygoma_room(NAME FOLDER DIR [PUBLIC lib...] [PRIVATE lib...]); a room without sources is header only.
function(zygoma_room name)
  cmake_parse_arguments(ROOM "" "FOLDER" "PUBLIC;PRIVATE" ${ARGN})
  file(GLOB_RECURSE headers CONFIGURE_DEPENDS "${CMAKE_SOURCE_DIR}/${ROOM_FOLDER}/*.h")
  file(GLOB_RECURSE sources CONFIGURE_DEPENDS "${CMAKE_SOURCE_DIR}/${ROOM_FOLDER}/*.cpp")
  if(NOT sources)
    add_library(zygoma_${name} INTERFACE)
    target_sources(zygoma_${name} INTERFACE FILE_SET HEADERS BASE_DIRS "${CMAKE_SOURCE_DIR}" FILES ${headers})
    target_include_directories(zygoma_${name} INTERFACE "${CMAKE_SOURCE_DIR}")
    target_link_libraries(zygoma_${name} INTERFACE ${ROOM_PUBLIC})
    return()
  endif()
  add_library(zygoma_${name} STATIC ${sources})
  set_target_properties(zygoma_${name} PROPERTIES LINKER_LANGUAGE CXX)
  target_sources(zygoma_${name} PUBLIC FILE_SET HEADERS BASE_DIRS "${CMAKE_SOURCE_DIR}" FILES ${headers})
  target_include_directories(zygoma_${name} PUBLIC "${CMAKE_SOURCE_DIR}")
  target_link_libraries(zygoma_${name} PUBLIC ${ROOM_PUBLIC} PRIVATE ${ROOM_PRIVATE})
  zygoma_compile_options(zygoma_${name})
endfunction()

# Things that exist by being a file: for every FOLDER/NAME.cpp a function (FUNCTION with % replaced
# by NAME) is declared and listed, in the order of the sorted names, in <generated/ROOM_list.inc>
# as ZYGOMA_PLUGIN(function). No static-initialiser registration, so nothing depends on link order.
function(zygoma_plugin_list room)
  cmake_parse_arguments(LIST_OF "" "FOLDER;FUNCTION" "" ${ARGN})
  file(GLOB files CONFIGURE_DEPENDS RELATIVE "${CMAKE_SOURCE_DIR}/${LIST_OF_FOLDER}"
       "${CMAKE_SOURCE_DIR}/${LIST_OF_FOLDER}/*.cpp")
  list(SORT files)
  set(text "// Generated from the files in ${LIST_OF_FOLDER}.\n")
  foreach(file ${files})
    get_filename_component(stem "${file}" NAME_WE)
    string(REPLACE "%" "${stem}" function "${LIST_OF_FUNCTION}")
    string(APPEND text "ZYGOMA_PLUGIN(${function})\n")
  endforeach()
  file(CONFIGURE OUTPUT "${CMAKE_BINARY_DIR}/generated/${room}_list.inc" CONTENT "${text}" @ONLY)
  target_include_directories(zygoma_${room} PRIVATE "${CMAKE_BINARY_DIR}")
endfunction()
