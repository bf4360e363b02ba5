# The Aravis driver against simulated cameras of small frames, in a network namespace: every way a stream can go wrong.
add_executable(gige_stand ${CMAKE_CURRENT_LIST_DIR}/gige_stand.cpp ${CMAKE_CURRENT_LIST_DIR}/gige_rig.cpp)
target_link_libraries(gige_stand PRIVATE adit_test_main adit_aravis adit_sim)
set_target_properties(gige_stand PROPERTIES UNITY_BUILD OFF)
add_test(NAME system.gige
  COMMAND Python3::Interpreter ${CMAKE_CURRENT_LIST_DIR}/gige.py $<TARGET_FILE:gige_stand>)
set_tests_properties(system.gige PROPERTIES RUN_SERIAL ON TIMEOUT 180)
