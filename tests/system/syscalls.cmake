# What the hot threads ask of the kernel.
add_test(NAME system.syscalls COMMAND Python3::Interpreter ${CMAKE_CURRENT_LIST_DIR}/syscalls.py
  $<TARGET_FILE:adit> $<TARGET_FILE:aditd> ${PROJECT_SOURCE_DIR}/host/scenes ${CMAKE_BINARY_DIR}/syscalls)
set_tests_properties(system.syscalls PROPERTIES RUN_SERIAL ON TIMEOUT 60 SKIP_RETURN_CODE 77)
