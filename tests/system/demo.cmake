add_test(NAME system.demo COMMAND Python3::Interpreter ${CMAKE_CURRENT_SOURCE_DIR}/demo.py ${CMAKE_BINARY_DIR}/bin
  ${PROJECT_SOURCE_DIR} ${CMAKE_BINARY_DIR}/demo)
set_tests_properties(system.demo PROPERTIES RUN_SERIAL ON TIMEOUT 180)
