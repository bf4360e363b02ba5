# Ten seconds without a camera: long enough for Aravis to give it up and for the driver to open it again. The cameras are
# served by ADIT_CAMERAS where that is set: a program without sanitizers, which would be too slow to render.
add_test(NAME system.vanish COMMAND Python3::Interpreter ${CMAKE_CURRENT_SOURCE_DIR}/vanish.py
  $<IF:$<BOOL:${ADIT_CAMERAS}>,${ADIT_CAMERAS},$<TARGET_FILE:adit>> $<TARGET_FILE:aditd>
  ${PROJECT_SOURCE_DIR}/host/scenes ${CMAKE_BINARY_DIR}/vanish)
set_tests_properties(system.vanish PROPERTIES RUN_SERIAL ON TIMEOUT 120)
if(NOT ADIT_SANITIZE STREQUAL "address")  # its threads are what the short form is after
  adit_short_form(system.vanish aditd)
endif()
