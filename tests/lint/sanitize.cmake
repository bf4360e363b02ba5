# Configures, builds and runs the short form of a sanitized preset. cmake -D SOURCE= -D PRESET= -D CAMERAS= -D ROOMS= -P sanitize.cmake
function(must)
  execute_process(COMMAND ${ARGN} WORKING_DIRECTORY ${SOURCE} RESULT_VARIABLE failed)
  if(failed)
    message(FATAL_ERROR "${PRESET}: ${ARGN} failed")
  endif()
endfunction()

must(${CMAKE_COMMAND} --preset ${PRESET} -D ADIT_CAMERAS=${CAMERAS} -D ADIT_ONE_THREAD_FROM=${ROOMS} -D CMAKE_CXX_COMPILER_LAUNCHER=${LAUNCHER})
must(${CMAKE_COMMAND} --build --preset ${PRESET} --target short_form)
must(${CMAKE_CTEST_COMMAND} --preset ${PRESET} -L short)
