# A turn of the right camera, from the images to the buses, and its correction.
add_test(NAME system.watch COMMAND Python3::Interpreter ${CMAKE_CURRENT_SOURCE_DIR}/watch.py $<TARGET_FILE:adit>
  $<TARGET_FILE:aditd> ${PROJECT_SOURCE_DIR}/host/scenes ${CMAKE_BINARY_DIR}/watch)
set_tests_properties(system.watch PROPERTIES RUN_SERIAL ON TIMEOUT 180)
