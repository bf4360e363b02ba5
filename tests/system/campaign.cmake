# The campaigns, `adit diff` and `adit inspect` as commands; the full counts are run by hand.
find_package(Python3 REQUIRED COMPONENTS Interpreter)
add_test(NAME system.campaign
  COMMAND Python3::Interpreter ${CMAKE_CURRENT_LIST_DIR}/campaign.py $<TARGET_FILE:adit> ${PROJECT_SOURCE_DIR}/tests/data/golden)
set_tests_properties(system.campaign PROPERTIES TIMEOUT ${ADIT_TEST_LIMIT_S})
