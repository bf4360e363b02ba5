# From a recording and control points to a georeference, and the box on the bus with it.
find_package(Python3 REQUIRED COMPONENTS Interpreter)
add_test(NAME system.georef
  COMMAND Python3::Interpreter ${CMAKE_CURRENT_LIST_DIR}/georef.py $<TARGET_FILE:adit> $<TARGET_FILE:aditd>
    ${PROJECT_SOURCE_DIR}/host/scenes)
set_tests_properties(system.georef PROPERTIES TIMEOUT ${ADIT_TEST_LIMIT_S})
