# The workstation's whole way: simulate, train, calibrate, track, evaluate; and every wrong input is one line.
find_package(Python3 REQUIRED COMPONENTS Interpreter)
add_test(NAME system.offline
  COMMAND Python3::Interpreter ${CMAKE_CURRENT_LIST_DIR}/offline.py $<TARGET_FILE:adit> ${PROJECT_SOURCE_DIR}/host/scenes)
set_tests_properties(system.offline PROPERTIES TIMEOUT 900)
