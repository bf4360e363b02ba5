# mbpoll, a PLC programmer's first tool, reads the map of a box that stands still.
find_package(Python3 REQUIRED COMPONENTS Interpreter)
add_executable(modbus_stand ${CMAKE_CURRENT_LIST_DIR}/modbus_stand.cpp)
target_link_libraries(modbus_stand PRIVATE adit_modbus adit_publish)
add_test(NAME system.modbus
  COMMAND Python3::Interpreter ${CMAKE_CURRENT_LIST_DIR}/modbus_mbpoll.py $<TARGET_FILE:modbus_stand>)
set_tests_properties(system.modbus PROPERTIES TIMEOUT 60 SKIP_RETURN_CODE 77)

# canmatrix, a reader of the trade, loads the DBC and decodes the golden set with it. Debian's package serves Debian's python.
add_test(NAME system.dbc
  COMMAND /usr/bin/python3 ${CMAKE_CURRENT_LIST_DIR}/dbc_canmatrix.py ${PROJECT_SOURCE_DIR})
set_tests_properties(system.dbc PROPERTIES TIMEOUT 60 SKIP_RETURN_CODE 77)
