# `adit intrinsics` on real images; every wrong input is one line.
find_package(Python3 REQUIRED COMPONENTS Interpreter)
add_test(NAME system.intrinsics
  COMMAND Python3::Interpreter ${CMAKE_CURRENT_LIST_DIR}/intrinsics.py $<TARGET_FILE:adit> ${PROJECT_SOURCE_DIR}/tests/data/chessboard)
set_tests_properties(system.intrinsics PROPERTIES TIMEOUT 120)
