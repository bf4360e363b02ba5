# One place for what every translation unit is compiled with, and the function that makes a room.
set(CMAKE_CXX_STANDARD 20)
set(CMAKE_CXX_STANDARD_REQUIRED ON)
set(CMAKE_CXX_EXTENSIONS OFF)
set(CMAKE_EXPORT_COMPILE_COMMANDS ON)
set(CMAKE_RUNTIME_OUTPUT_DIRECTORY ${CMAKE_BINARY_DIR}/bin)

add_library(adit_options INTERFACE)
target_include_directories(adit_options INTERFACE ${PROJECT_SOURCE_DIR})
target_compile_options(adit_options INTERFACE
  -Wall -Wextra -Wpedantic -Wshadow -Wconversion -Wnon-virtual-dtor -Woverloaded-virtual -Werror
  # GCC 12 sees overlaps in std::string's operator+ (its bug 105651) and unset values in Eigen's inlined ones, where
  # there are none; ASan and UBSan look at the same code.
  $<$<CXX_COMPILER_ID:GNU>:-Wno-restrict> $<$<CXX_COMPILER_ID:GNU>:-Wno-maybe-uninitialized>
  # The same sums on every machine of an architecture: no fused multiply-add where it happens to be available.
  -ffp-contract=off -pthread)
if(CMAKE_SYSTEM_PROCESSOR STREQUAL "x86_64")
  # The oldest box we support; wider instructions are chosen at run time.
  target_compile_options(adit_options INTERFACE -march=x86-64-v2)
endif()
if(ADIT_SANITIZE STREQUAL "address")
  # Without those of UBSan that ASan sees too (null, object-size) or that our types cannot break (vptr): a quarter of the
  # time of compiling.
  target_compile_options(adit_options INTERFACE -fsanitize=address,undefined -fno-sanitize=null,object-size,vptr
    -fno-sanitize-recover=all -fno-omit-frame-pointer)
  target_link_options(adit_options INTERFACE -fsanitize=address,undefined)
elseif(ADIT_SANITIZE STREQUAL "thread")
  target_compile_options(adit_options INTERFACE -fsanitize=thread -fno-omit-frame-pointer -Wno-tsan)
  target_link_options(adit_options INTERFACE -fsanitize=thread)
endif()

if(ADIT_FUZZ)
  # The engine steers by the coverage of the rooms, so they are instrumented too.
  target_compile_options(adit_options INTERFACE -fsanitize=fuzzer-no-link,address,undefined -fno-sanitize-recover=all)
  target_link_options(adit_options INTERFACE -fsanitize=address,undefined)
endif()

# adit_room(name [ONE_THREAD] DEPENDS targets...): a library adit_<name> of all sources in the current folder. ONE_THREAD: nothing
# in it runs beside or waits for another thread, so that a build which looks for races may take it from another build
# (ADIT_ONE_THREAD_FROM) instead of compiling what takes longest.
function(adit_room name)
  cmake_parse_arguments(ROOM "ONE_THREAD" "" "DEPENDS" ${ARGN})
  file(GLOB sources CONFIGURE_DEPENDS ${CMAKE_CURRENT_SOURCE_DIR}/*.cpp)
  if(ROOM_ONE_THREAD AND ADIT_ONE_THREAD_FROM)
    file(RELATIVE_PATH folder ${PROJECT_SOURCE_DIR} ${CMAKE_CURRENT_SOURCE_DIR})
    add_library(adit_${name} STATIC IMPORTED GLOBAL)
    set_target_properties(adit_${name} PROPERTIES IMPORTED_LOCATION ${ADIT_ONE_THREAD_FROM}/${folder}/libadit_${name}.a)
    target_link_libraries(adit_${name} INTERFACE adit_options ${ROOM_DEPENDS})
  elseif(sources)
    add_library(adit_${name} STATIC ${sources})
    target_link_libraries(adit_${name} PUBLIC adit_options ${ROOM_DEPENDS})
  else()
    add_library(adit_${name} INTERFACE)
    target_link_libraries(adit_${name} INTERFACE adit_options ${ROOM_DEPENDS})
  endif()
endfunction()
